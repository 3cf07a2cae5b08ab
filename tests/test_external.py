"""The functions that run outside programs notice failure; without this a broken check would pass."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.external import PrusaSlicer, missing, require_module, require_program

RunInFreeCAD = Callable[..., dict[str, Any]]

SIZE_MM = 20.0
SQUARE = ((0, 0), (SIZE_MM, 0), (SIZE_MM, SIZE_MM), (0, SIZE_MM))
CORNERS = [(x, y, z) for z in (0, SIZE_MM) for x, y in SQUARE]
SIDES = [(0, 3, 2, 1), (4, 5, 6, 7), *((k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4) for k in range(4))]
CUBE = [facet for a, b, c, d in SIDES for facet in ((a, b, c), (a, c, d))]


def write_stl(path: Path, facets: list[tuple[int, int, int]]) -> Path:
    """A binary STL of some facets of the cube."""
    coordinates = [[x for corner in facet for x in CORNERS[corner]] for facet in facets]
    records = b"".join(struct.pack("<12fH", 0, 0, 0, *nine, 0) for nine in coordinates)
    path.write_bytes(bytes(80) + struct.pack("<I", len(facets)) + records)
    return path


def test_freecad_reports_values(run_in_freecad: RunInFreeCAD) -> None:
    script = "import Part\nreport(volume=Part.makeBox(1, 2, inputs['height']).Volume)"
    assert run_in_freecad(script, height=3) == {"volume": pytest.approx(6)}


def test_freecad_script_that_raises_is_noticed(run_in_freecad: RunInFreeCAD) -> None:
    with pytest.raises(AssertionError, match="ZeroDivisionError"):
        run_in_freecad("1 / 0")


def test_freecad_that_ends_early_is_noticed(run_in_freecad: RunInFreeCAD) -> None:
    with pytest.raises(AssertionError, match="no outcome"):
        run_in_freecad("import os\nos._exit(0)")


def test_freecad_that_hangs_is_noticed(run_in_freecad: RunInFreeCAD) -> None:
    with pytest.raises(AssertionError, match="did not end"):
        run_in_freecad("import time\ntime.sleep(60)", timeout_s=3)


def test_slicer_tells_a_closed_mesh_from_an_open_one(prusa_slicer: PrusaSlicer, tmp_path: Path) -> None:
    closed = prusa_slicer.info(write_stl(tmp_path / "closed.stl", CUBE))
    assert closed["manifold"] is True
    assert closed["number_of_facets"] == 12
    assert prusa_slicer.info(write_stl(tmp_path / "open.stl", CUBE[1:]))["manifold"] is False


def test_slicer_slices(prusa_slicer: PrusaSlicer, tmp_path: Path) -> None:
    mesh = write_stl(tmp_path / "closed.stl", CUBE)
    assert "G1 X" in prusa_slicer.slice(mesh, tmp_path / "out.gcode")


def test_slicer_refuses_what_is_no_mesh(prusa_slicer: PrusaSlicer, tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match="PrusaSlicer"):
        prusa_slicer.info(tmp_path / "absent.stl")


def test_missing_thing_skips_at_home_and_fails_under_ci(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CI", raising=False)
    with pytest.raises(pytest.skip.Exception, match="no-such-program is missing"):
        require_program("no-such-program", package="nothing")
    monkeypatch.setenv("CI", "true")
    with pytest.raises(pytest.fail.Exception, match="no-such-program is missing"):
        require_program("no-such-program", package="nothing")
    with pytest.raises(pytest.fail.Exception, match=r"gomboc-cad\[audit\]"):
        require_module("no_such_module", "audit")
    with pytest.raises(pytest.fail.Exception, match="thing is missing: remedy"):
        missing("thing", "remedy")
