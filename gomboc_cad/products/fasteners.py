"""Bought fasteners from bd_warehouse: geometry and the holes they need."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from bd_warehouse.fastener import (
    CheeseHeadScrew,
    HeatSetNut,
    PanHeadScrew,
    SocketHeadCapScrew,
)
from bd_warehouse.fastener import Screw as CataloguedScrew
from build123d import Cylinder, Shape, Solid

from gomboc_cad.errors import SpecError

_HOLE_BELOW_INSERT_MM = 1.0

SCREW_CLASSES: tuple[type[CataloguedScrew], ...] = (PanHeadScrew, SocketHeadCapScrew, CheeseHeadScrew)
"""Screws with a flat seat under a cylindrical or nearly cylindrical head."""


@dataclass(frozen=True)
class Insert:
    """A heat-set insert, its top at z = 0.

    Attributes:
        solid: Simplified solid without knurls.
        hole_diameter_mm: Recommended hole.
        length_mm: Length.
        min_wall_mm: Recommended least material around the hole.
        standard: Maker and part number.
    """

    solid: Solid
    hole_diameter_mm: float
    length_mm: float
    min_wall_mm: float
    standard: str

    @property
    def hole_depth_mm(self) -> float:
        """Depth of the hole, with room under the insert for melted plastic and the screw's tip."""
        return self.length_mm + _HOLE_BELOW_INSERT_MM


@dataclass(frozen=True)
class Screw:
    """A screw with a flat seat, the underside of its head at z = 0 and its shank downwards.

    Attributes:
        solid: Simplified solid without thread and recess.
        head_diameter_mm: Diameter of the head.
        head_height_mm: Height of the head.
        length_mm: Length under the head.
        thread_mm: Nominal thread diameter.
        clearance_mm: Diameter of the hole that it passes through (ISO 273, medium).
        tap_drill_mm: Diameter of the core hole for a tapped thread in plastic or another soft material.
        standard: Standard and size.
    """

    solid: Solid
    head_diameter_mm: float
    head_height_mm: float
    length_mm: float
    thread_mm: float
    clearance_mm: float
    tap_drill_mm: float
    standard: str

    @property
    def counterbore_mm(self) -> float:
        """Diameter of the recess for the head: as much wider than the head as the hole is than the thread."""
        return self.head_diameter_mm + self.clearance_mm - self.thread_mm


def heat_set_insert(size: str, maker: str) -> Insert:
    """Look a heat-set insert up in bd_warehouse's tables.

    Args:
        size: Size in bd_warehouse's spelling, such as `M3-0.5-4`.
        maker: Maker in bd_warehouse's spelling, such as `CNCKitchen`.

    Raises:
        SpecError: If the maker or the size is not in the tables.
    """
    _check_known(f"There is no maker {maker!r} of heat-set inserts", maker, HeatSetNut.types())
    _check_known(f"The insert {size!r} is not made by {maker}", size, HeatSetNut.sizes(maker))
    nut = HeatSetNut(size, maker, simple=True)
    data = nut.nut_data
    length = float(data["m"])
    return Insert(
        solid=_solid(nut).translate((0.0, 0.0, -length)),
        hole_diameter_mm=float(data["dc"]),
        length_mm=length,
        min_wall_mm=float(data.get("material_thickness", 0.0)),
        standard=f"{maker} {size}",
    )


def screw(size: str, length_mm: float, standard: str) -> Screw:
    """Look a pan, socket or cheese head screw up in bd_warehouse's tables.

    Args:
        size: Thread in bd_warehouse's spelling, such as `M3-0.5`.
        length_mm: Length under the head.
        standard: Standard in bd_warehouse's spelling, such as `iso4762`.

    Raises:
        SpecError: If the standard, the thread or the length is not in the tables.
    """
    lengths = screw_lengths_mm(size, standard)
    if length_mm not in lengths:
        shown = ", ".join(f"{value:g}" for value in lengths)
        raise SpecError(
            f"A screw {standard.upper()} {size} has no standard length {length_mm:g} mm; choose one of "
            f"{shown}."
        )
    made = _screw_class(standard)(size, length_mm, standard, simple=True)
    return Screw(
        solid=_solid(made),
        head_diameter_mm=float(made.screw_data["dk"]),
        head_height_mm=float(made.screw_data["k"]),
        length_mm=length_mm,
        thread_mm=made.thread_diameter,
        clearance_mm=made.clearance_hole_diameters["Normal"],
        tap_drill_mm=made.tap_hole_diameters["Soft"],
        standard=f"{standard.upper()} {size} x {length_mm:g}",
    )


def screw_lengths_mm(size: str, standard: str) -> tuple[float, ...]:
    """Standard lengths under the head of a screw, in rising order.

    Raises:
        SpecError: If the standard or the thread is not in bd_warehouse's tables.
    """
    screw_class = _screw_class(standard)
    _check_known(f"There is no thread {size!r} in {standard}", size, screw_class.sizes(standard))
    shortest_known = screw_class(size, 10.0, standard, simple=True)
    return tuple(sorted(shortest_known.nominal_lengths))


def dowel_pin(diameter_mm: float, length_mm: float) -> Solid:
    """A parallel pin (ISO 8734 without its small chamfers), its middle at the origin, its axis along z."""
    return Cylinder(0.5 * diameter_mm, length_mm).solid()


def thread_of(size: str) -> float:
    """Nominal diameter in mm of a metric size such as `M3-0.5` or of an insert such as `M3-0.5-4`.

    Raises:
        SpecError: If it does not begin like a metric thread.
    """
    try:
        return float(size.split("-")[0].removeprefix("M"))
    except ValueError:
        raise SpecError(f"{size!r} is no metric thread; write it like M3-0.5.") from None


def _screw_class(standard: str) -> type[CataloguedScrew]:
    """The class of bd_warehouse that has a standard."""
    classes = {name: screw_class for screw_class in SCREW_CLASSES for name in screw_class.types()}
    _check_known(f"There are no screws of the standard {standard!r}", standard, classes)
    return classes[standard]


def _check_known(complaint: str, value: str, known: Iterable[str]) -> None:
    """Refuse a name that bd_warehouse's tables do not have."""
    names = sorted(known)
    if value not in names:
        raise SpecError(f"{complaint}; choose one of {', '.join(names)}.")


def _solid(part: Shape) -> Solid:
    """The single solid of a bd_warehouse part."""
    solids = part.solids()
    if len(solids) != 1:
        raise SpecError("The fastener is not a single solid; choose another size.")
    return solids[0]
