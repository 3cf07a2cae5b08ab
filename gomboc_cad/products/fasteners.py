"""Bought fasteners from bd_warehouse: geometry, mass and the holes they need."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from bd_warehouse.fastener import HeatSetNut, PanHeadScrew
from build123d import Cylinder, Shape, Solid

from gomboc_cad.errors import SpecError
from gomboc_cad.products.imu_housing_spec import ClosureSpec, StandoffSpec

_HOLE_BELOW_INSERT_MM = 1.0


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
    """A pan-head screw, the underside of its head at z = 0 and its shank downwards.

    Attributes:
        solid: Simplified solid without thread and recess.
        head_diameter_mm: Diameter of the head.
        head_height_mm: Height of the head.
        length_mm: Length under the head.
        thread_mm: Nominal thread diameter.
        standard: Standard and size.
    """

    solid: Solid
    head_diameter_mm: float
    head_height_mm: float
    length_mm: float
    thread_mm: float
    standard: str


def heat_set_insert(spec: StandoffSpec) -> Insert:
    """Look the insert up in bd_warehouse's tables.

    Raises:
        SpecError: If the maker or the size is not in the tables.
    """
    _check_known("insert_maker", spec.insert_maker, HeatSetNut.types())
    _check_known("insert", spec.insert, HeatSetNut.sizes(spec.insert_maker), f"made by {spec.insert_maker}")
    nut = HeatSetNut(spec.insert, spec.insert_maker, simple=True)
    data = nut.nut_data
    length = float(data["m"])
    return Insert(
        solid=_solid(nut).translate((0.0, 0.0, -length)),
        hole_diameter_mm=float(data["dc"]),
        length_mm=length,
        min_wall_mm=float(data.get("material_thickness", 0.0)),
        standard=f"{spec.insert_maker} {spec.insert}",
    )


def pan_head_screw(spec: StandoffSpec) -> Screw:
    """Look the screw up in bd_warehouse's tables.

    Raises:
        SpecError: If the standard, the thread or the length is not in the tables.
    """
    _check_known("screw_standard", spec.screw_standard, PanHeadScrew.types())
    _check_known("screw", spec.screw, PanHeadScrew.sizes(spec.screw_standard), f"in {spec.screw_standard}")
    screw = PanHeadScrew(spec.screw, spec.screw_length_mm, spec.screw_standard, simple=True)
    lengths = screw.nominal_lengths
    if spec.screw_length_mm not in lengths:
        shown = ", ".join(f"{value:g}" for value in lengths)
        raise SpecError(
            f"standoffs.screw_length_mm = {spec.screw_length_mm:g} is no standard length; choose one of "
            f"{shown}."
        )
    return Screw(
        solid=_solid(screw),
        head_diameter_mm=float(screw.screw_data["dk"]),
        head_height_mm=float(screw.screw_data["k"]),
        length_mm=spec.screw_length_mm,
        thread_mm=screw.thread_diameter,
        standard=f"{spec.screw_standard.upper()} {spec.screw} x {spec.screw_length_mm:g}",
    )


def dowel_pin(spec: ClosureSpec) -> Solid:
    """A parallel pin (ISO 8734 without its small chamfers), its middle at the origin, its axis along z."""
    return Cylinder(0.5 * spec.diameter_mm, spec.length_mm).solid()


def _check_known(key: str, value: str, known: Iterable[str], where: str = "known") -> None:
    """Refuse a name that bd_warehouse's tables do not have."""
    names = sorted(known)
    if value not in names:
        raise SpecError(f"standoffs.{key} = {value!r} is not {where}; choose one of {', '.join(names)}.")


def _solid(part: Shape) -> Solid:
    """The single solid of a bd_warehouse part."""
    solids = part.solids()
    if len(solids) != 1:
        raise SpecError("The fastener is not a single solid; choose another size.")
    return solids[0]
