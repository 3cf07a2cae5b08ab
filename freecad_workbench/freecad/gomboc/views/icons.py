"""The icons of the workbench, plain and with a mark for the state of an object."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

from freecad.gomboc import door

FOLDER = Path(__file__).parents[1] / "icons"

PIXELS = 64

OF_KIND = {
    "body": "gomboc-body",
    "imu-housing": "gomboc-imu-housing",
    "seed-pod": "gomboc-seed-pod",
    "buoy": "gomboc-buoy",
    "check": "gomboc-check",
    "zone": "gomboc-loading-zone",
    "drillmap": "gomboc-drill-map",
    "tolerance": "gomboc-tolerance",
}
"""Icon of each kind of object."""


def path(name: str) -> str:
    """The file of an icon, as FreeCAD wants it."""
    return str(FOLDER / f"{name}.svg")


@lru_cache(maxsize=None)
def marked(name: str, mark: str) -> Any:
    """An icon with the mark of a state (pass, fail, outdated, running) in its corner, or without."""
    pixmap = door.QtGui.QPixmap(PIXELS, PIXELS)
    pixmap.fill(door.QtCore.Qt.transparent)
    painter = door.QtGui.QPainter(pixmap)
    for layer in [name, *([f"state-{mark}"] if mark else [])]:
        painter.drawPixmap(0, 0, door.QtGui.QIcon(path(layer)).pixmap(PIXELS, PIXELS))
    painter.end()
    return door.QtGui.QIcon(pixmap)
