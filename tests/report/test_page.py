"""The page: every number stands in the JSON, text stays text, nothing is fetched, the same bytes again."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gomboc_cad.report.page import script_json
from gomboc_cad.report.write import write_report
from tests.report.conftest import MakeResults, copied, write_page
from tests.report.walker import read_page, untraced

MOST_BYTES = 8_000_000
ORDER = ["verdict", "asked", "view", "landscape", "zone", "tilt", "form-error", "yields", "sobol"]
LAST = ["method", "protocol"]
NASTY = "<script>alert(1)</script>"


def page_of(folder: Path) -> str:
    return (folder / "report.html").read_text(encoding="utf-8")


def contents(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def shown(folder: Path) -> str:
    return " ".join(" ".join(each.text for each in read_page(page_of(folder))[0]).split())


def test_every_number_of_the_page_stands_in_the_json_beside_it(housing: Path, buoy: Path) -> None:
    assert untraced(housing) == []
    assert untraced(buoy) == []


@pytest.mark.parametrize(
    "damage",
    [
        (r'(<data data-json="verdict.json#/s_margin_mm"[^>]*>)0\.382', r"\g<1>0.383"),
        (r"<h3>Why</h3>", "<h3>Why: 3 reasons</h3>"),
        (r'data-json="verdict.json#/reasons/0"', 'data-json="verdict.json#/reasons/1"'),
    ],
    ids=["another digit", "a number of its own", "another place"],
)
def test_a_number_that_does_not_stand_there_is_found(
    housing: Path, tmp_path: Path, damage: tuple[str, str]
) -> None:
    """The walk itself is put to the test."""
    for path in housing.glob("*.json"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    page, count = re.subn(*damage, page_of(housing))
    assert count >= 1
    (tmp_path / "report.html").write_text(page, encoding="utf-8")
    assert untraced(tmp_path)


def test_the_sections_stand_in_the_promised_order(housing: Path, buoy: Path) -> None:
    def sections(folder: Path) -> list[str]:
        return re.findall(r'<section id="([\w-]+)"', page_of(folder))

    assert sections(housing) == [*ORDER, "answers", *LAST]
    assert sections(buoy) == [*ORDER, "answers", "hydrostatics", *LAST]


def test_verdict_margin_and_every_reason_are_said(housing: Path) -> None:
    verdict = json.loads((housing / "verdict.json").read_text(encoding="utf-8"))
    text = shown(housing)
    assert verdict["reasons"]
    for reason in verdict["reasons"]:
        assert " ".join(reason.split()) in text
    for file in verdict["files"]:
        assert file["sha256"] in text
    study = json.loads((housing / "tolerance.json").read_text(encoding="utf-8"))
    assert study["recommend"]["sentence"] in text
    assert study["baseline"]["sentence"] in text


def test_what_is_not_there_yet_is_said_with_the_command_for_it(buoy: Path) -> None:
    text = shown(buoy)
    assert "gomboc-cad tolerance SPEC -o DIR" in text
    assert "not studied" in text
    assert "Floating in sea water" in text


def test_nothing_is_fetched_from_anywhere(housing: Path) -> None:
    page = page_of(housing)
    _, links = read_page(page)
    assert links
    assert all(link.startswith(("#", "data:")) for link in links)
    assert not re.search(r"url\((?!['\"]?(#|data:))", page)
    assert "@import" not in page
    addresses = set(re.findall(r"https?://[^\s\"'<>)]+", page))
    # Names of XML namespaces, which nobody opens.
    assert addresses <= {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"}


def test_it_stays_small(housing: Path) -> None:
    assert len(page_of(housing).encode()) < MOST_BYTES


def test_written_again_from_the_json_alone_it_has_the_same_bytes(housing: Path) -> None:
    before = contents(housing)
    document = write_report(housing)
    assert contents(housing) == before
    assert set(document["files"]) == {"report.json", "report.html"} | {
        f"figures/{path.name}" for path in (housing / "figures").iterdir()
    }


def test_every_figure_is_a_file_of_its_own_twice(housing: Path) -> None:
    names = {path.stem for path in (housing / "figures").iterdir()}
    assert {"surface", "landscape", "tilt", "form-error", "yields", "sobol"} <= names
    for name in names:
        assert (housing / "figures" / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert b"<svg" in (housing / "figures" / f"{name}.svg").read_bytes()


def rename_everything(document: dict[str, Any]) -> None:
    document["product"] = document["body"] = NASTY
    document["spec"]["board"]["type"] = document["manufacture"]["process"] = NASTY
    document["spec"]["shell"]["material"] = document["files"][0]["path"] = NASTY
    document["parts"][0]["name"] = document["parts"][1]["material"] = NASTY
    document["reasons"].append(f"\"'&{NASTY}")
    document["spec"]["board"][NASTY] = NASTY


def test_text_of_the_spec_stays_text(changed: MakeResults) -> None:
    folder = changed("verdict.json", rename_everything)
    write_page(folder)
    page = page_of(folder)
    assert NASTY not in page
    assert page.count("&lt;script&gt;alert(1)&lt;/script&gt;") > 8
    own = page.index('<script>\n"use strict";')
    assert "<script" not in page[:own]


def test_json_within_the_page_cannot_end_its_element() -> None:
    text = script_json({"a": "</script><!--<script> & \u2028\u2029"})
    assert not re.search(r"[<>&\u2028\u2029]", text)
    assert json.loads(text) == {"a": "</script><!--<script> & \u2028\u2029"}


def test_a_study_of_another_design_is_left_out_and_that_is_said(changed: MakeResults) -> None:
    def elsewhere(document: dict[str, Any]) -> None:
        document["com_mm"][0] += 0.001

    folder = changed("tolerance.json", elsewhere)
    write_page(folder)
    text = shown(folder)
    assert "The study in this folder is of another design" in text
    assert "not studied" in text
    assert untraced(folder) == []


def test_an_unfinished_study_beside_a_build_is_said(tmp_path: Path) -> None:
    folder = copied(tmp_path / "out", "housing")
    (folder / "variants.csv.study.json").write_text("{}", encoding="utf-8")
    write_page(folder)
    assert "A study in this folder is not finished" in shown(folder)


def test_a_study_alone_has_its_report_too(tmp_path: Path) -> None:
    folder = copied(tmp_path / "out", "study")
    write_page(folder)
    assert "This is a study without its build" in shown(folder)
    assert untraced(folder) == []


def no_census(document: dict[str, Any]) -> None:
    """As the verdict of a body that is not convex."""
    for key in ("s_margin_mm", "u_margin_mm", "stable", "unstable", "saddles", "rest", "transfer"):
        document[key] = None
    document["sensitivities"] = []
    document["verdict"] = "FAIL"


def short_study(document: dict[str, Any]) -> None:
    """As with --no-answers."""
    for key in ("processes", "baseline", "form_error", "budget", "budget_summary", "recommend"):
        del document[key]


def hopeless_study(document: dict[str, Any]) -> None:
    """As where no variant has one rest."""
    short_study(document)
    document["no_answer"] = "The design itself does not right itself."
    for key in ("tilt_deg", "dead_zone_deg", "s_margin_mm", "com_error_um", "layers"):
        document[key] = None
    document["sobol"] = document["sobol_s_margin"] = []


@pytest.mark.parametrize(
    ("name", "change"),
    [("verdict.json", no_census), ("tolerance.json", short_study), ("tolerance.json", hopeless_study)],
)
def test_less_fortunate_results_have_a_page_too(
    changed: MakeResults, name: str, change: Callable[[dict[str, Any]], None]
) -> None:
    folder = changed(name, change)
    write_page(folder)
    assert untraced(folder) == []


def test_what_can_be_drawn_of_the_worst_is_drawn(changed: MakeResults) -> None:
    folder = changed("verdict.json", no_census)
    study = json.loads((folder / "tolerance.json").read_text(encoding="utf-8"))
    hopeless_study(study)
    (folder / "tolerance.json").write_text(json.dumps(study), encoding="utf-8")
    assert "figures/yields.svg" in write_report(folder)["files"]
