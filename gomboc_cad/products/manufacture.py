"""What a process makes of the parts: the walls that are measured on them, and what a mould cannot release."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from gomboc_cad.equilibria.records import Vector
from gomboc_cad.products.assembly import Assembly
from gomboc_cad.products.process import Process
from gomboc_cad.solid.undercuts import Undercuts, undercuts
from gomboc_cad.solid.wall import WallThickness, thinnest_wall


@dataclass(frozen=True)
class MadePart:
    """What was measured on a part.

    Attributes:
        name: Its name.
        wall: Its thinnest wall.
        undercuts: What a two-part tool along the parting direction does not reach.
    """

    name: str
    wall: WallThickness
    undercuts: Undercuts


@dataclass(frozen=True)
class Manufacture:
    """How a process copes with the made parts.

    Attributes:
        process: The process.
        parts: What was measured on each.
        problems: What the process cannot make, one sentence each.
        notes: What a user should know, one sentence each.
    """

    process: Process
    parts: tuple[MadePart, ...]
    problems: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def min_wall_mm(self) -> float | None:
        """The thinnest wall of all parts; None if none has walls."""
        walls = (part.wall.min_mm for part in self.parts if math.isfinite(part.wall.min_mm))
        return min(walls, default=None)


def manufacture(assembly: Assembly, process: Process, parting_direction: Vector) -> Manufacture:
    """Measure the made parts of an assembly on their meshes and compare with what a process can make.

    Args:
        assembly: The parts.
        process: How they are made.
        parting_direction: Direction in which a two-part mould opens.
    """
    parts = tuple(
        MadePart(part.name, thinnest_wall(part.mesh), undercuts(part.mesh, parting_direction))
        for part in assembly.parts
        # A thread has no walls of its own; its ring's follow from the closure.
        if part.made and part.mesh is not None and part.boundary is not None
    )
    problems = tuple(_too_thin(part, process) for part in parts if part.wall.min_mm < process.min_wall_mm)
    undercut = [part for part in parts if part.undercuts.area_mm2 > 0.0]
    notes = tuple(_does_not_release(part) for part in undercut if process.undercuts_matter)
    return Manufacture(process, parts, problems, notes)


def manufacture_document(made: Manufacture) -> dict[str, Any]:
    """The key `manufacture` of `verdict.json`."""
    return {
        "process": made.process.name,
        "process_min_wall_mm": made.process.min_wall_mm,
        "min_wall_mm": made.min_wall_mm,
        "parts": [
            {
                "name": part.name,
                "min_wall_mm": part.wall.min_mm if math.isfinite(part.wall.min_mm) else None,
                "min_wall_error_mm": part.wall.error_mm,
                "min_wall_at_mm": list(part.wall.place_mm),
                "undercut_area_mm2": part.undercuts.area_mm2,
                "undercut_share": part.undercuts.share,
                "undercut_depth_mm": part.undercuts.deepest_mm,
            }
            for part in made.parts
        ],
    }


def _too_thin(part: MadePart, process: Process) -> str:
    x, y, z = part.wall.place_mm
    return (
        f"{part.name} is {part.wall.min_mm:.3g} mm thin at ({x:.1f}, {y:.1f}, {z:.1f}) mm, and the process "
        f"{process.name} needs {process.min_wall_mm:g} mm; make it thicker there or choose another process."
    )


def _does_not_release(part: MadePart) -> str:
    return (
        f"{part.name} has {part.undercuts.area_mm2:.3g} mm² of undercuts along the parting direction, up to "
        f"{part.undercuts.deepest_mm:.3g} mm deep: a two-part mould does not release it; use slides or "
        "cores, or drill these places afterwards."
    )
