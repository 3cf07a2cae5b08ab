"""Batteries as data: size, mass and where the figures come from."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

from build123d import Align, Box, Cylinder, Solid
from pydantic import Field, model_validator

from gomboc_cad.body.sphere import Array
from gomboc_cad.products.data_files import data_names, load_data
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.products.toml_model import Number, Text, TomlModel

Size = Annotated[Number, Field(gt=0.0, le=1000.0)]
Source = Annotated[str, Field(strict=True, min_length=1, max_length=800)]

_SIZES = {"cylinder": (2, "diameter and length"), "box": (3, "length, width and height")}


_FOLDER = "batteries"


class Battery(TomlModel):
    """A cell or a block, taken as homogeneous.

    Its own frame has the origin in the middle of the underside, z along the axis of a cylinder or the height
    of a box, and x along the box's length.

    Attributes:
        name: Full name.
        shape: `cylinder` or `box`.
        size_mm: Largest size: diameter and length, or length, width and height without terminals.
        terminals_mm: How far the terminals stand out at the top.
        mass_g: Mass.
        mass_tolerance_g: How far the mass may be off.
        com_tolerance_mm: How far the centre of mass may be off the middle along each axis.
        source: Where the sizes come from.
        mass_source: Where mass and tolerances come from.
    """

    name: Text
    shape: Literal["cylinder", "box"]
    size_mm: Annotated[tuple[Size, ...], Field(min_length=2, max_length=3)]
    terminals_mm: Annotated[Number, Field(ge=0.0, le=100.0)] = 0.0
    mass_g: Annotated[Number, Field(gt=0.0, le=1e5)]
    mass_tolerance_g: Annotated[Number, Field(ge=0.0, le=1e4)]
    com_tolerance_mm: Annotated[Number, Field(ge=0.0, le=100.0)] = 0.0
    source: Source
    mass_source: Source

    @model_validator(mode="after")
    def _sized(self) -> Battery:
        count, meaning = _SIZES[self.shape]
        if len(self.size_mm) != count:
            raise ValueError(f"size_mm of a {self.shape} is its {meaning} in mm")
        return self

    @property
    def height_mm(self) -> float:
        """Height of the body without terminals."""
        return self.size_mm[-1]

    @property
    def outline_radius_mm(self) -> float:
        """Radius of the circle around the outline, seen along the height."""
        if self.shape == "cylinder":
            return 0.5 * self.size_mm[0]
        return 0.5 * math.hypot(self.size_mm[0], self.size_mm[1])

    def solid(self, frame: RestFrame, seat_mm: Array) -> Solid:
        """The battery standing on a point (3,), its height along the frame's up."""
        base = (Align.CENTER, Align.CENTER, Align.MIN)
        shape = (
            Cylinder(0.5 * self.size_mm[0], self.height_mm, align=base)
            if self.shape == "cylinder"
            else Box(*self.size_mm, align=base)
        )
        return shape.solid().moved(frame.location(seat_mm))


def battery_names() -> tuple[str, ...]:
    """Names of the batteries that come with the package."""
    return data_names(_FOLDER)


def load_battery(name: str, beside: Path | None = None) -> Battery:
    """Read a battery by the name of a template or by the path of a user's own file.

    Args:
        name: `18650`, or a path that ends in `.toml`.
        beside: Folder that a relative path starts from, usually that of the spec.

    Raises:
        SpecError: If there is no such battery or its file is wrong.
    """
    return load_data(Battery, _FOLDER, name, beside)
