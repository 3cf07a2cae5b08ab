"""The study as the command line runs it: its files, its keys, its refusals, the same bytes again."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from gomboc_cad.errors import GombocError, OutputError, SpecError, StudyError
from gomboc_cad.products.template_files import copy_template
from gomboc_cad.tolerance.whole_study import Question, study_tolerances
from tests.external import digests
from tests.report.walker import untraced

SMALL = Question(
    process="cnc-5axis",
    variants=600,
    samples=16,
    against=("sla", "cnc-5axis"),
    compared=512,
    undulations=(2, 8),
    searched=512,
    confirmed=1024,
    rebuilt=1,
)


def run(folder: Path, question: Question, subject: str = "primary", **options: Any) -> dict[str, Any]:
    """Study with one process, and no report unless one is wanted."""
    options = {"executor": "local:1", "report": False, **options}
    return study_tolerances(subject, folder, question, **options)


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """A precise part of which 60 % are asked for, with all answers; its waviness ends at 4 undulations."""
    folder = tmp_path_factory.mktemp("study")
    precise = folder / "precise.toml"
    copy_template("cnc-5axis", precise)
    told = precise.read_text(encoding="utf-8")
    told = told.replace("value = 15.0, range = [15.0, 50.0]", "value = 4.0, range = [4.0, 50.0]")
    precise.write_text(told, encoding="utf-8")
    question = replace(SMALL, process=str(precise), good_share=0.6, max_tilt_deg=5.0)
    return run(folder / "out", question, report=True)


@pytest.mark.slow
def test_the_document_has_the_contracts_keys(study: dict[str, Any]) -> None:
    assert study["variants"] == 600
    for key in ("yield_monostable", "yield_tilt"):
        share = study[key]
        assert 0.0 <= share["low"] <= share["estimate"] <= share["high"] <= 1.0
        assert share["passed"] == round(600 * share["estimate"])
    assert study["yield_tilt"]["passed"] <= study["yield_monostable"]["passed"]
    assert 0.0 < study["tilt_deg"]["p50"] < study["tilt_deg"]["p95"]
    names = {source["name"] for source in study["sources"]}
    assert {entry["source"] for entry in study["sobol"]} == names
    assert {"first", "total"} <= set(study["sobol"][0])
    assert {entry["source"] for entry in study["budget"]} == names
    assert all(entry["allowed"] >= 0.0 for entry in study["budget"])
    assert study["recommend"]["sentence"]
    assert study["cross_check"]["rows"] == 1
    assert study["cross_check"]["disagreed"] == []
    assert next(source for source in study["sources"] if source["name"] == "form_error")["dimensions"] == 21


@pytest.mark.slow
def test_every_number_of_its_report_stands_in_its_files(study: dict[str, Any]) -> None:
    assert "report.html" in study["files"]
    assert untraced(Path(study["folder"])) == []


@pytest.mark.slow
def test_processes_are_compared_and_the_best_comes_first(study: dict[str, Any]) -> None:
    rows = study["processes"]
    assert {row["process"] for row in rows} == {"sla", "cnc-5axis"}
    lows = [row["yield_tilt"]["low"] for row in rows]
    assert lows == sorted(lows, reverse=True)
    assert rows[0]["process"] == "cnc-5axis"


@pytest.mark.slow
def test_the_allowed_form_error_falls_with_the_undulations(study: dict[str, Any]) -> None:
    entries = study["form_error"]["degrees"]
    guaranteed = [entry["guaranteed_um"] for entry in entries]
    assert guaranteed == sorted(guaranteed, reverse=True)
    allowed = [entry["allowed_um"] for entry in entries]
    assert allowed[0] > allowed[1] > 0.0


@pytest.mark.slow
def test_the_folder_holds_the_rows_and_the_document(study: dict[str, Any]) -> None:
    folder = Path(study["folder"])
    with (folder / "variants.csv").open(encoding="utf-8", newline="") as stream:
        assert sum(1 for _ in csv.DictReader(stream)) == 600
    on_disk = json.loads((folder / "tolerance.json").read_text(encoding="utf-8"))
    assert on_disk == {key: value for key, value in study.items() if key not in ("folder", "files")}


def test_called_again_it_reads_its_rows_and_writes_the_same_bytes(tmp_path: Path) -> None:
    question = Question(process="cnc-5axis", variants=512, samples=2, rebuilt=0, answers=False)
    told: list[str] = []
    run(tmp_path / "one", question)
    before = digests(tmp_path / "one")
    assert json.loads((tmp_path / "one" / "tolerance.json").read_text(encoding="utf-8"))["layers"] is None
    run(tmp_path / "one", question, progress=told.append)
    assert digests(tmp_path / "one") == before
    run(tmp_path / "two", question)
    assert digests(tmp_path / "two") == before
    with pytest.raises(StudyError, match="belongs to another study: its seed"):
        run(tmp_path / "one", Question(process="cnc-5axis", variants=512, seed=1, samples=2, answers=False))


@pytest.mark.slow
def test_a_printed_part_is_built_of_layers_too(tmp_path: Path) -> None:
    """Layers of 0.2 mm hold a small primary on many steps, far from its rest."""
    small = tmp_path / "small.toml"
    small.write_text('[body]\nname = "primary"\ndiameter_mm = 40.0\n', encoding="utf-8")
    question = Question(process="fdm", variants=1, samples=2, rebuilt=0, answers=False)
    found = run(tmp_path / "out", question, str(small))
    layers = found["layers"]
    assert layers["height_mm"] == pytest.approx(0.2, abs=0.15)
    assert layers["dead_zone_mm"] > layers["height_mm"]
    assert layers["dead_zone_deg"] > 5.0
    assert all(built["verdict"] == "multistable" for built in layers["built"])


def test_a_body_of_ones_own_is_studied_too(tmp_path: Path) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text('[body]\nname = "tolerant-1"\ndiameter_mm = 60.0\n', encoding="utf-8")
    question = Question(process="cnc-5axis", variants=1, samples=2, rebuilt=0, answers=False)
    found = run(tmp_path / "out", question, str(mine))
    assert found["subject"] == "tolerant-1"
    assert found["s_margin_mm"]["largest"] == pytest.approx(0.0074 * 30.0, rel=0.1)


def test_without_an_executor_nothing_is_designed_or_written(tmp_path: Path) -> None:
    told: list[str] = []
    with pytest.raises(StudyError, match="There is no executor 'foo'"):
        study_tolerances("imu-housing", tmp_path / "out", SMALL, executor="foo", progress=told.append)
    assert told == []
    assert list(tmp_path.iterdir()) == []


def test_other_files_of_a_folder_are_not_buried(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(OutputError, match="--force"):
        run(tmp_path, SMALL)
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize(
    ("subject", "change", "error", "said"),
    [
        ("primry", {}, GombocError, "did you mean primary"),
        ("absent.toml", {}, SpecError, "no file absent.toml"),
        ("primary", {"process": "fmd"}, SpecError, "no process 'fmd'"),
        ("primary", {"variants": 0}, StudyError, "1 to"),
        ("primary", {"good_share": 1.5}, StudyError, "above 0 and below 1"),
        ("primary", {"max_tilt_deg": -1.0}, StudyError, "largest tilt"),
        ("primary", {"rolling_mm": -1.0}, StudyError, "rolling-resistance"),
        ("primary", {"rows_format": "xls"}, StudyError, "csv"),
        ("second", {}, GombocError, "convex"),
    ],
)
def test_what_cannot_be_studied_is_one_sentence(
    tmp_path: Path, subject: str, change: dict[str, Any], error: type[GombocError], said: str
) -> None:
    question = Question(**{"process": "cnc-5axis", "variants": 512, "answers": False, **change})
    with pytest.raises(error, match=said):
        run(tmp_path / "out", question, subject)
    assert list(tmp_path.iterdir()) == []
