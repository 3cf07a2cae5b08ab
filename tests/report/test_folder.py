"""Bad input: one sentence for each, and nothing that crashes, hangs or fills memory."""

from __future__ import annotations

import json
import random
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from gomboc_cad import __version__
from gomboc_cad.errors import GombocError, InspectionError
from gomboc_cad.report.document import completed
from gomboc_cad.report.folder import REPORT, read_results
from gomboc_cad.report.page import render_page
from gomboc_cad.report.write import write_report
from tests.report.conftest import DATA, MakeResults, copied

HOSTILE: list[Any] = [
    None,
    True,
    -1,
    1e308,
    10**400,
    "",
    "<b>",
    "x" * 10_000,
    [],
    {},
    [[[[[]]]]],
    [None] * 3,
    {"a": None},
    [1e-320],
]


def refused(folder: Path) -> str:
    before = {path.name for path in folder.iterdir()} if folder.is_dir() else set()
    with pytest.raises(InspectionError) as caught:
        write_report(folder)
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert len(sentence) < 400
    assert before == ({path.name for path in folder.iterdir()} if folder.is_dir() else set())
    return sentence


def test_a_folder_that_is_not_there_or_is_a_file_or_is_empty(tmp_path: Path) -> None:
    assert "There is no folder" in refused(tmp_path / "nowhere")
    (tmp_path / "file").write_text("x", encoding="utf-8")
    assert "is a file" in refused(tmp_path / "file")
    (tmp_path / "empty").mkdir()
    assert "neither verdict.json nor tolerance.json" in refused(tmp_path / "empty")


@pytest.mark.parametrize("rows", ["variants.csv.journal", "variants.csv"])
def test_a_half_written_study_says_how_to_finish_it(tmp_path: Path, rows: str) -> None:
    (tmp_path / "variants.csv.study.json").write_text("{}", encoding="utf-8")
    (tmp_path / rows).write_bytes(b"x")
    assert "run the same `gomboc-cad tolerance` command again" in refused(tmp_path)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{",
        b"\xff\xfe",
        b'{"a": NaN}',
        b"[" * 100_000,
        b'{"a": 1e9999}',
        b"\x00" * 50,
        b"[1, 2]",
        b"7",
    ],
)
def test_damaged_json_is_named(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "verdict.json").write_bytes(content)
    assert refused(tmp_path).startswith("verdict.json")


def test_json_of_another_program_is_refused(tmp_path: Path) -> None:
    (tmp_path / "verdict.json").write_text('{"name": "package"}', encoding="utf-8")
    assert "is not a document of gomboc-cad" in refused(tmp_path)
    folder = copied(tmp_path / "other", "housing")
    (folder / "report.json").write_text('{"program": "other"}', encoding="utf-8")
    assert "report.json is not a document of gomboc-cad" in refused(folder)


@pytest.mark.parametrize(
    ("name", "key", "value"),
    [
        ("verdict.json", "version", "999.0"),
        ("verdict.json", "version", "0.1.1"),
        ("verdict.json", "format", 2),
        ("tolerance.json", "format", 99),
    ],
)
def test_json_of_a_newer_version_asks_for_an_update(
    changed: MakeResults, name: str, key: str, value: Any
) -> None:
    sentence = refused(changed(name, lambda document: document.update({key: value})))
    assert sentence.startswith(name)
    assert __version__ in sentence
    assert "update gomboc-cad" in sentence


def test_a_missing_number_is_named_with_its_file_and_key(changed: MakeResults) -> None:
    def drop(document: dict[str, Any]) -> None:
        del document["assembly"]["mass_g"]

    folder = changed("verdict.json", drop)
    assert "verdict.json: assembly.mass_g is missing" in refused(folder)


def test_a_huge_file_is_not_read(tmp_path: Path) -> None:
    with (tmp_path / "verdict.json").open("wb") as stream:
        stream.truncate(10_000_000_000)
    assert "is larger than any" in refused(tmp_path)


def leaves(document: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    items = document.items() if isinstance(document, dict) else enumerate(document)
    found = []
    for key, value in items:
        found.append((*path, key))
        if isinstance(value, dict | list) and value:
            found += leaves(value, (*path, key))
    return found


def replaced(document: Any, path: tuple[Any, ...], value: Any) -> None:
    for key in path[:-1]:
        document = document[key]
    document[path[-1]] = value


def outcome(folder: Path) -> str:
    """What is said of a folder that no page can be made of; nothing if one can."""
    try:
        results = read_results(folder)
        report = completed(results)
        render_page(replace(results, documents={**results.documents, REPORT: report}), {}, None)
    except GombocError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("source", "name"),
    [("housing", "verdict.json"), ("housing", "calibration.json"), ("study", "tolerance.json")],
)
def test_no_single_wrong_value_does_more_than_one_sentence(
    tmp_path: Path, source: str, name: str, seed: int
) -> None:
    """Any key replaced by something hostile gives a page or one of our errors."""
    chance = random.Random(seed)
    folder = copied(tmp_path / "hostile", "housing", "study")
    text = (DATA / source / name).read_text(encoding="utf-8")
    places = leaves(json.loads(text))
    for _ in range(12):
        document = json.loads(text)
        path, value = chance.choice(places), chance.choice(HOSTILE)
        replaced(document, path, value)
        (folder / name).write_text(json.dumps(document), encoding="utf-8")
        said = outcome(folder)
        assert "\n" not in said, (path, value)
        assert len(said) < 1000, (path, value)


@pytest.mark.parametrize("key", ["surface", "landscape", "parts"])
@pytest.mark.parametrize("value", [7, {}, [7], {"positions_mm": {"dtype": "uint16", "shape": [10**9, 3]}}])
def test_damaged_shapes_are_refused(housing: Path, tmp_path: Path, key: str, value: Any) -> None:
    folder = copied(tmp_path / "out", "housing")
    report = json.loads((housing / "report.json").read_text(encoding="utf-8"))
    report[key] = value
    (folder / "report.json").write_text(json.dumps(report), encoding="utf-8")
    assert refused(folder)
