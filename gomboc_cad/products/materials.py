"""Materials as data."""

from __future__ import annotations

import difflib
from typing import Annotated

from pydantic import Field

from gomboc_cad.errors import SpecError
from gomboc_cad.products.toml_model import Number, Text, TomlModel, parse_model, read_toml
from gomboc_cad.resources import template_folder


class Material(TomlModel):
    """A homogeneous material.

    Attributes:
        name: What it is called in reports.
        density_g_cm3: Density.
        source: Where the density comes from.
    """

    name: Text
    density_g_cm3: Annotated[Number, Field(ge=0.01, le=25.0)]
    source: Text

    def mass_g(self, volume_mm3: float) -> float:
        """Mass of a volume of it."""
        return self.density_g_cm3 * volume_mm3 * 1e-3


def material_names() -> tuple[str, ...]:
    """Names of the materials that come with the package."""
    return tuple(read_toml(template_folder() / "materials.toml"))


def load_material(name: str) -> Material:
    """Look a material up in `materials.toml`.

    Raises:
        SpecError: If there is none of that name; the sentence offers the names.
    """
    path = template_folder() / "materials.toml"
    materials = read_toml(path)
    if name not in materials:
        near = difflib.get_close_matches(name, materials, n=3, cutoff=0.4) or list(materials)
        raise SpecError(f"There is no material {name!r}; did you mean {', '.join(near)}?")
    return parse_model(Material, materials[name], path.name)
