"""Folders of results to report on: JSON as gomboc-cad wrote it, with shapes that are quick to make."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.equilibria import smooth_census
from gomboc_cad.report.document import body_document, body_of, completed
from gomboc_cad.report.folder import REPORT, read_results
from gomboc_cad.report.landscape import height_landscape
from gomboc_cad.report.packing import packed, packed_integers
from gomboc_cad.report.page import render_page
from gomboc_cad.report.surface_fields import surface_fields
from gomboc_cad.report.write import add_to_report, json_bytes
from tests.external import require_program

DATA = Path(__file__).parent / "data"
"""What `gomboc-cad build` and `gomboc-cad tolerance` 0.1.0 wrote for the templates."""

MakeResults = Callable[..., Path]


def copied(folder: Path, *sources: str) -> Path:
    """A folder with the JSON of some of the sources: housing, buoy, study."""
    folder.mkdir(parents=True, exist_ok=True)
    for source in sources:
        for path in (DATA / source).iterdir():
            shutil.copy(path, folder / path.name)
    return folder


def shapes(folder: Path) -> dict[str, Any]:
    """What a build puts into report.json, with two balls for parts."""
    found = body_of(read_results(folder))
    assert found is not None
    body, com_mm = found
    census = smooth_census(body, com_mm)
    corners, faces = geodesic_triangulation(2)
    parts = [
        {
            "name": name,
            "color": color,
            "made": made,
            "positions_mm": packed(size * body.radius_mm * corners),
            "faces": packed_integers(faces),
        }
        for name, size, made, color in (
            ("shell", 0.93, True, [0.8, 0.7, 0.2]),
            ("<script>alert(1)</script>", 0.3, False, [0.1, 0.6, 0.3]),
        )
    ]
    return {
        "body": body_document(body, com_mm),
        "parts": parts,
        "surface": surface_fields(body, com_mm, census.rest, level=4).document(),
        "landscape": height_landscape(census).document(),
    }


def write_page(folder: Path) -> None:
    """The page of a folder and its JSON twin without figures, which take most of the time."""
    found = read_results(folder)
    report = completed(found)
    results = replace(found, documents={**found.documents, REPORT: report})
    (folder / REPORT).write_bytes(json_bytes(report))
    (folder / "report.html").write_text(render_page(results, {}, None), encoding="utf-8")


@pytest.fixture(scope="session")
def housing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of a housing with its study."""
    folder = copied(tmp_path_factory.mktemp("report") / "housing", "housing", "study")
    add_to_report(folder, shapes(folder))
    return folder


@pytest.fixture(scope="session")
def buoy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of a buoy without a study, written from an old folder without report.json."""
    folder = copied(tmp_path_factory.mktemp("report") / "buoy", "buoy")
    add_to_report(folder, {})
    return folder


@pytest.fixture
def changed(tmp_path: Path) -> MakeResults:
    """`changed("verdict.json", change)` gives the housing's folder with one document changed in place."""

    def make(name: str, change: Callable[[dict[str, Any]], None], *sources: str) -> Path:
        folder = copied(tmp_path / "changed", *(sources or ("housing", "study")))
        path = folder / name
        document = json.loads(path.read_text(encoding="utf-8"))
        change(document)
        path.write_text(json.dumps(document), encoding="utf-8")
        return folder

    return make


@pytest.fixture(scope="session")
def chromium() -> str:
    """Path of the browser."""
    return require_program("chromium", "chromium-browser", package="chromium")
