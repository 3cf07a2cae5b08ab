"""Sensor boards as data: outline, mounting holes, mass and sensor."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from gomboc_cad.body.sphere import Array, unit
from gomboc_cad.products.data_files import data_names, load_data
from gomboc_cad.products.toml_model import Coordinate, Number, Point, Text, TomlModel

Size = Annotated[Number, Field(gt=0.0, le=500.0)]
Source = Annotated[str, Field(strict=True, min_length=1, max_length=800)]

_SQUARE = 1e-6
"""Largest cosine between two axes that count as square to each other."""


class MountingHole(TomlModel):
    """A mounting hole in the board's frame."""

    x_mm: Coordinate
    y_mm: Coordinate
    diameter_mm: Annotated[Number, Field(gt=0.0, le=10.0)]


class Sensor(TomlModel):
    """Where the sensor sits and how its axes lie in the board's frame.

    Attributes:
        part: Manufacturer's part name.
        position_mm: Centre of the package in the board's frame.
        x_axis: Direction of the accelerometer's x-axis in the board's frame, of any length.
        y_axis: Direction of its y-axis; z completes a right-handed frame.
        axes_note: What the axes rest on.
        misalignment_deg: How far each axis may be off its place on the board; None if nobody says.
        misalignment_source: Where that comes from.
    """

    part: Text
    position_mm: Point
    x_axis: Point
    y_axis: Point
    axes_note: Source
    misalignment_deg: Annotated[Number, Field(ge=0.0, le=45.0)] | None = None
    misalignment_source: Source | None = None

    @model_validator(mode="after")
    def _square(self) -> Sensor:
        directions = np.array([self.x_axis, self.y_axis])
        if not directions.any(axis=1).all():
            raise ValueError("x_axis and y_axis must not be zero")
        if abs(float(np.prod(unit(directions), axis=0).sum())) > _SQUARE:
            raise ValueError("x_axis and y_axis are not square to each other")
        if (self.misalignment_deg is None) != (self.misalignment_source is None):
            raise ValueError("misalignment_deg and misalignment_source go together")
        return self

    def axes(self) -> Array:
        """Rotation from the sensor's frame to the board's: its columns are x, y and z, shape (3, 3)."""
        x, y = unit(np.array([self.x_axis, self.y_axis]))
        return np.column_stack([x, y, np.cross(x, y)])


_FOLDER = "boards"


class Board(TomlModel):
    """A rectangular board: x along its length, y along its width, z out of the component side.

    The origin is a corner of the underside.

    Attributes:
        name: Full name.
        length_mm: Size along x.
        width_mm: Size along y.
        thickness_mm: Thickness of the laminate.
        corner_radius_mm: Radius of the corners.
        height_mm: From the underside to the top of the tallest component.
        below_mm: How far solder joints and parts stick out below the underside.
        holes: Mounting holes.
        mass_g: Mass with everything soldered to it.
        mass_tolerance_g: How far the mass may be off.
        com_mm: Centre of mass in the board's frame; it need not be over the middle.
        com_tolerance_mm: How far it may be off along each axis.
        sensor: The sensor.
        source: Where the dimensions come from.
        mass_source: Where mass, centre of mass and their tolerances come from.
    """

    name: Text
    length_mm: Size
    width_mm: Size
    thickness_mm: Annotated[Number, Field(gt=0.0, le=10.0)]
    corner_radius_mm: Annotated[Number, Field(ge=0.0, le=50.0)] = 0.0
    height_mm: Size
    below_mm: Annotated[Number, Field(ge=0.0, le=50.0)] = 0.0
    holes: Annotated[tuple[MountingHole, ...], Field(min_length=2, max_length=12)]
    mass_g: Annotated[Number, Field(gt=0.0, le=5000.0)]
    mass_tolerance_g: Annotated[Number, Field(ge=0.0, le=1000.0)]
    com_mm: Point
    com_tolerance_mm: Annotated[Number, Field(ge=0.0, le=100.0)] = 0.0
    sensor: Sensor
    source: Source
    mass_source: Source

    @model_validator(mode="after")
    def _consistent(self) -> Board:
        if self.height_mm < self.thickness_mm:
            raise ValueError(
                f"height_mm = {self.height_mm:g} is less than thickness_mm = {self.thickness_mm:g}"
            )
        if 2.0 * self.corner_radius_mm > min(self.length_mm, self.width_mm):
            raise ValueError(f"corner_radius_mm = {self.corner_radius_mm:g} does not fit the outline")
        for hole in self.holes:
            radius = 0.5 * hole.diameter_mm
            inside_x = radius <= hole.x_mm <= self.length_mm - radius
            if not (inside_x and radius <= hole.y_mm <= self.width_mm - radius):
                raise ValueError(f"the hole at ({hole.x_mm:g}, {hole.y_mm:g}) is not inside the outline")
        for key, (x, y, z) in (("com_mm", self.com_mm), ("sensor.position_mm", self.sensor.position_mm)):
            across = 0 <= x <= self.length_mm and 0 <= y <= self.width_mm
            if not (across and -self.below_mm <= z <= self.height_mm):
                raise ValueError(f"{key} = ({x:g}, {y:g}, {z:g}) is not inside the board's box")
        return self


def board_names() -> tuple[str, ...]:
    """Names of the boards that come with the package."""
    return data_names(_FOLDER)


def load_board(name: str, beside: Path | None = None) -> Board:
    """Read a board by the name of a template or by the path of a user's own file.

    Args:
        name: `adafruit-bno055`, or a path that ends in `.toml`.
        beside: Folder that a relative path starts from, usually that of the spec.

    Raises:
        SpecError: If there is no such board or its file is wrong.
    """
    return load_data(Board, _FOLDER, name, beside)
