"""Fixtures that every test may use: outside programs, optional modules, the repository's root."""

from __future__ import annotations

import os

# Workers run side by side; with a BLAS thread for every processor in each of them, all wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests.external import FreeCAD, PrusaSlicer, require_module, require_program

# A test that uses one of these fixtures gets the marker, so `-m "not freecad"` needs nobody's memory.
MARKER_OF_FIXTURE = {
    "freecadcmd": "freecad",
    "prusa_slicer": "prusaslicer",
    "cadquery": "cadquery",
    "pymeshlab": "audit",
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark each test by the outside things its fixtures need."""
    for item in items:
        for fixture, marker in MARKER_OF_FIXTURE.items():
            if fixture in getattr(item, "fixturenames", ()):
                item.add_marker(marker)


@pytest.fixture(scope="session")
def root() -> Path:
    """The folder of pyproject.toml."""
    return Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def freecadcmd() -> str:
    """Path of FreeCAD's command-line program."""
    return require_program("freecadcmd", "FreeCADCmd", "freecad.cmd", package="freecad-python3")


@pytest.fixture
def run_in_freecad(
    freecadcmd: str, tmp_path_factory: pytest.TempPathFactory
) -> Callable[..., dict[str, Any]]:
    """`run_in_freecad(script_text, name=value, ...)` returns what the script reported: see FreeCAD.run."""
    return FreeCAD(freecadcmd, tmp_path_factory.mktemp("freecad")).run


@pytest.fixture
def prusa_slicer(tmp_path_factory: pytest.TempPathFactory) -> PrusaSlicer:
    """PrusaSlicer: `.info(file)` and `.slice(file, gcode)`."""
    executable = require_program("prusa-slicer", "PrusaSlicer", package="prusa-slicer")
    return PrusaSlicer(executable, tmp_path_factory.mktemp("prusaslicer"))


@pytest.fixture(scope="session")
def cadquery() -> ModuleType:
    """The module cadquery."""
    return require_module("cadquery", "cadquery")


@pytest.fixture(scope="session")
def pymeshlab() -> ModuleType:
    """The module pymeshlab."""
    return require_module("pymeshlab", "audit")
