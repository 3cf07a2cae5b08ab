"""The report of a folder: `report.html`, its JSON twin, and every figure as a file of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from gomboc_cad.report.document import completed, merged
from gomboc_cad.report.figure_list import NamedFigure, report_figures
from gomboc_cad.report.folder import (
    CALIBRATION,
    HYDROSTATICS,
    REPORT,
    TOLERANCE,
    VERDICT,
    Results,
    read_results,
    report_of,
)
from gomboc_cad.report.page import render_page
from gomboc_cad.report.scene import scene_of
from gomboc_cad.report.style import figure_bytes, svg_text
from gomboc_cad.reproducible import one_blas_thread
from gomboc_cad.solid.output import json_bytes, write_bytes, writing_to

PAGE, FIGURES = "report.html", "figures"
_INDENT = 1
"""Of `report.json`, which has many short lines."""

_NOT_INLINED = ("curvature",)
"""The view in space shows it, and nobody needs it on paper."""


@one_blas_thread()
def write_report(folder: Path, beside: Path | None = None) -> dict[str, Any]:
    """Write the report of a folder from the JSON files in it, and nothing else.

    Args:
        folder: What `gomboc-cad build` or `gomboc-cad tolerance` wrote, or both into the same one.
        beside: Where files are read that are not in the folder: the one that its files are to go to.

    Returns:
        The JSON document of `gomboc-cad report`: the folder and the files written, relative to it.

    Raises:
        InspectionError: If the folder or a file in it is not usable.
        OutputError: If the files cannot be written.
    """
    found = read_results(folder, beside)
    report = completed(found)
    results = replace(found, documents={**found.documents, REPORT: report})
    scene = scene_of(results)
    # Without figures at first: the page names file and key of whatever is wrong.
    render_page(results, {}, None)
    figures = _figures(results)
    inlined = {
        named.name: svg_text(named.figure, named.name) for named in figures if named.name not in _NOT_INLINED
    }
    page = render_page(results, inlined, scene)
    files = {REPORT: json_bytes(report, _INDENT), PAGE: page.encode()}
    for named in figures:
        for kind in ("svg", "png"):
            files[f"{FIGURES}/{named.name}.{kind}"] = figure_bytes(named.figure, kind)
    with writing_to(folder):
        (folder / FIGURES).mkdir(exist_ok=True)
    for name, content in files.items():
        write_bytes(folder / name, content)
    return {"folder": str(folder), "files": list(files)}


def add_to_report(folder: Path, records: Mapping[str, Any], beside: Path | None = None) -> dict[str, Any]:
    """Put what a build or a study found into the `report.json` of a folder, and write the report.

    Raises:
        InspectionError, OutputError: As `write_report`.
    """
    before = report_of(folder if beside is None else beside)
    write_bytes(folder / REPORT, json_bytes(merged(before, records), _INDENT))
    return write_report(folder, beside)


def _figures(results: Results) -> list[NamedFigure]:
    """All figures that the documents of a folder give."""
    return report_figures(
        results.documents[REPORT],
        verdict=results.plain(VERDICT),
        calibration=results.plain(CALIBRATION),
        hydrostatics=results.plain(HYDROSTATICS),
        tolerance=results.plain(TOLERANCE),
    )
