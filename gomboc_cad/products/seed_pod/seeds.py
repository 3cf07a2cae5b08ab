"""Seeds as data: size, mass and scatter, and where the first root comes out."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from gomboc_cad.body.sphere import Array, unit
from gomboc_cad.products.data_files import data_names, load_data
from gomboc_cad.products.toml_model import Number, Point, Text, TomlModel

Size = Annotated[Number, Field(gt=0.0, le=100.0)]
Scatter = Annotated[Number, Field(ge=0.0, le=100.0)]
Source = Annotated[str, Field(strict=True, min_length=1, max_length=800)]

_DENSEST_G_CM3 = 1.6
"""No seed is denser: starch and cellulose without any pores have 1.5 to 1.55 g/cm³."""


_FOLDER = "seeds"


class Seed(TomlModel):
    """A seed as an ellipsoid: x along its length, y along its width, z along its thickness.

    Attributes:
        name: Species, and variety where it matters.
        length_mm: Mean size along x.
        width_mm: Mean size along y.
        thickness_mm: Mean size along z.
        size_scatter_mm: How much longer, wider or thicker than the mean a seed of the lot may be.
        mass_g: Mean mass.
        mass_scatter_g: How far the mass of a single seed may be off.
        radicle_direction: From the middle of the seed to where its first root, the radicle, comes out, of any
            length; it has to point down.
        radicle_diameter_mm: Diameter of the exit that the radicle needs.
        source: Where the sizes come from.
        mass_source: Where mass and scatter come from.
        radicle_source: Where the radicle's direction and diameter come from.
    """

    name: Text
    length_mm: Size
    width_mm: Size
    thickness_mm: Size
    size_scatter_mm: Scatter
    mass_g: Annotated[Number, Field(gt=0.0, le=500.0)]
    mass_scatter_g: Scatter
    radicle_direction: Point
    radicle_diameter_mm: Size
    source: Source
    mass_source: Source
    radicle_source: Source

    @model_validator(mode="after")
    def _consistent(self) -> Seed:
        if not any(self.radicle_direction):
            raise ValueError("radicle_direction must not be zero")
        if self.density_g_cm3 > _DENSEST_G_CM3:
            raise ValueError(
                f"mass_g = {self.mass_g:g} makes an ellipsoid of this size {self.density_g_cm3:.2g} g/cm³, "
                f"which no seed is; check the unit of mass_g and of the sizes"
            )
        if self.mass_scatter_g >= self.mass_g:
            raise ValueError(
                f"mass_scatter_g = {self.mass_scatter_g:g} is not less than mass_g = {self.mass_g:g}"
            )
        return self

    @property
    def semi_axes_mm(self) -> Array:
        """Half the length, width and thickness, shape (3,)."""
        return 0.5 * np.array([self.length_mm, self.width_mm, self.thickness_mm])

    @property
    def volume_mm3(self) -> float:
        """Volume of the ellipsoid."""
        return 4.0 / 3.0 * math.pi * float(np.prod(self.semi_axes_mm))

    @property
    def density_g_cm3(self) -> float:
        """Mass over the volume of the ellipsoid."""
        return 1e3 * self.mass_g / self.volume_mm3

    def axes_in(self, matrix: Array) -> Array:
        """Give the seed's x, y and z as rows in the body's frame, the radicle pointing down.

        Of the two axes left, the one that can lie most level goes along `first`.

        Args:
            matrix: Rows first, second, up of the resting frame, shape (3, 3).
        """
        down = unit(np.array(self.radicle_direction))
        # The axis that is most nearly square to the radicle gives the turn about the vertical.
        seed = np.eye(3)[int(np.argmin(np.abs(np.round(down, 9))))]
        level = unit(seed - (seed @ down) * down)
        own = np.array([level, np.cross(-down, level), -down])
        axes: Array = own.T @ matrix
        return axes


def seed_names() -> tuple[str, ...]:
    """Names of the seeds that come with the package."""
    return data_names(_FOLDER)


def load_seed(name: str, beside: Path | None = None) -> Seed:
    """Read a seed by the name of a template or by the path of a user's own file.

    Args:
        name: `quercus-robur`, or a path that ends in `.toml`.
        beside: Folder that a relative path starts from, usually that of the spec.

    Raises:
        SpecError: If there is no such seed or its file is wrong.
    """
    return load_data(Seed, _FOLDER, name, beside)
