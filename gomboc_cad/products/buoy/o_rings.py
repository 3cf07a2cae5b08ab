"""O-rings and the housings of face seals, from tables of standard sizes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from build123d import Align, Cylinder, Solid
from pydantic import Field

from gomboc_cad.errors import GeometryError, SpecError
from gomboc_cad.products.toml_model import Count, Number, Text, TomlModel, parse_model, read_toml
from gomboc_cad.resources import template_folder

Size = Annotated[Number, Field(gt=0.0, le=2000.0)]

_FILE = "o-rings.toml"


class Series(TomlModel):
    """Rings of one thickness, and the housing that they need as a face seal.

    Attributes:
        cross_section_mm: Thickness of the ring.
        groove_depth_mm: Depth of the housing.
        groove_width_mm: Width of the housing.
        first_code: Size code of the first ring; the others follow without gaps.
        inside_diameters_mm: Inside diameters, rising.
    """

    cross_section_mm: Size
    groove_depth_mm: Size
    groove_width_mm: Size
    first_code: Annotated[Count, Field(ge=1, le=999)]
    inside_diameters_mm: Annotated[tuple[Size, ...], Field(min_length=1, max_length=200)]


class Table(TomlModel):
    """All thicknesses.

    Attributes:
        size_source: Where the sizes come from.
        housing_source: Where the housings come from.
        series: The rings.
    """

    size_source: Text
    housing_source: Text
    series: tuple[Series, ...]


@dataclass(frozen=True)
class FaceSeal:
    """An O-ring in the housing of a face seal with the pressure outside: it lies against the inner wall.

    Attributes:
        cross_section_mm: Thickness of the ring.
        inside_diameter_mm: Inside diameter of the ring and of the groove.
        groove_depth_mm: Depth of the groove.
        groove_width_mm: Width of the groove.
        standard: What to order.
    """

    cross_section_mm: float
    inside_diameter_mm: float
    groove_depth_mm: float
    groove_width_mm: float
    standard: str

    @property
    def inner_radius_mm(self) -> float:
        """Inner radius of the groove."""
        return 0.5 * self.inside_diameter_mm

    @property
    def outer_radius_mm(self) -> float:
        """Outer radius of the groove."""
        return self.inner_radius_mm + self.groove_width_mm

    @property
    def squeeze(self) -> float:
        """Share of the thickness by which the closed seam compresses the ring."""
        return 1.0 - self.groove_depth_mm / self.cross_section_mm

    def squeezed_solid(self) -> Solid:
        """The ring as it lies in the closed groove: its own volume at the depth of the groove, from z = 0."""
        base = (Align.CENTER, Align.CENTER, Align.MIN)
        middle = 0.5 * (self.inside_diameter_mm + self.cross_section_mm)
        volume = 0.5 * math.pi**2 * middle * self.cross_section_mm**2
        inner = self.inner_radius_mm
        outer = math.sqrt(inner**2 + volume / (math.pi * self.groove_depth_mm))
        ring = Cylinder(outer, self.groove_depth_mm, align=base) - Cylinder(
            inner, 3.0 * self.groove_depth_mm, align=(Align.CENTER, Align.CENTER, Align.CENTER)
        )
        return ring.solid()


def load_series(cross_section_mm: float) -> Series:
    """The rings of one thickness.

    Raises:
        SpecError: If there are none; the sentence offers the thicknesses.
    """
    table = parse_model(Table, read_toml(template_folder() / _FILE), _FILE)
    for series in table.series:
        if math.isclose(series.cross_section_mm, cross_section_mm):
            return series
    known = ", ".join(f"{series.cross_section_mm:g}" for series in table.series)
    raise SpecError(
        f"flange.cross_section_mm = {cross_section_mm:g} is no thickness of ISO 3601-1; choose one of "
        f"{known}."
    )


def largest_face_seal(cross_section_mm: float, outer_radius_mm: float, inner_radius_mm: float) -> FaceSeal:
    """The largest ring whose groove lies between two radii; made from cord where no standard size does.

    Args:
        cross_section_mm: Thickness of the ring.
        outer_radius_mm: Largest outer radius of the groove.
        inner_radius_mm: Least inner radius of a standard ring's groove; less makes the flange too wide.

    Raises:
        SpecError: If there are no rings of that thickness.
    """
    series = load_series(cross_section_mm)
    widest = 2.0 * (outer_radius_mm - series.groove_width_mm)
    fitting = [size for size in series.inside_diameters_mm if 2.0 * inner_radius_mm <= size <= widest]
    return _seal(series, max(fitting) if fitting else math.floor(widest))


def face_seal(cross_section_mm: float, inside_diameter_mm: float, outer_radius_mm: float) -> FaceSeal:
    """A ring of a given inside diameter.

    Raises:
        SpecError: If there are no rings of that thickness.
        GeometryError: If its groove reaches beyond the largest outer radius.
    """
    seal = _seal(load_series(cross_section_mm), inside_diameter_mm)
    if seal.outer_radius_mm > outer_radius_mm:
        raise GeometryError(
            f"The groove of the {seal.standard} reaches {seal.outer_radius_mm:.1f} mm from the vertical, but "
            f"the flange leaves room up to {outer_radius_mm:.1f} mm inside wall and screws; choose a smaller "
            'flange.inside_diameter_mm or "auto".'
        )
    return seal


def _seal(series: Series, inside_diameter_mm: float) -> FaceSeal:
    size = f"{inside_diameter_mm:g} x {series.cross_section_mm:g}"
    codes = {diameter: series.first_code + index for index, diameter in enumerate(series.inside_diameters_mm)}
    code = codes.get(inside_diameter_mm)
    return FaceSeal(
        series.cross_section_mm,
        inside_diameter_mm,
        series.groove_depth_mm,
        series.groove_width_mm,
        f"O-ring ISO 3601-1 {code:03d}A {size}" if code else f"O-ring from vulcanised cord {size}",
    )
