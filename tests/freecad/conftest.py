"""What tests of the FreeCAD workbench share."""

from __future__ import annotations

import sys
from pathlib import Path

WORKBENCH = Path(__file__).resolve().parents[2] / "freecad_workbench"

# FreeCAD finds the package by its folder Mod/; tests that need no FreeCAD import it from here.
sys.path.insert(0, str(WORKBENCH))
