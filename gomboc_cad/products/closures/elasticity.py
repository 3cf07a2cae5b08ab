"""How far the materials of a joint may be strained and stressed, as data."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Annotated

from pydantic import Field

from gomboc_cad.errors import SpecError
from gomboc_cad.products.toml_model import Number, Text, TomlModel, parse_model, read_toml

SINGLE_ASSEMBLY_SHARE = 0.7
"""Of the yield strain, permissible once and briefly (Bayer, "Snap-Fit Joints for Plastics")."""

SUSTAINED_SHARE = 0.5
"""Of the yield stress, permissible for long."""


class Elasticity(TomlModel):
    """Elastic properties of an isotropic material.

    Attributes:
        modulus_mpa: Modulus of elasticity in tension.
        poisson: Poisson's ratio.
        yield_mpa: Tensile stress at yield.
        yield_strain_percent: Strain at yield.
        source: Where the figures come from.
    """

    modulus_mpa: Annotated[Number, Field(gt=0.0, le=1e6)]
    poisson: Annotated[Number, Field(ge=0.0, lt=0.5)]
    yield_mpa: Annotated[Number, Field(gt=0.0, le=5000.0)]
    yield_strain_percent: Annotated[Number, Field(gt=0.0, le=100.0)]
    source: Text

    @property
    def strain_limit(self) -> float:
        """Strain that a snap may have once, while it is closed."""
        return 0.01 * SINGLE_ASSEMBLY_SHARE * self.yield_strain_percent

    @property
    def stress_limit_mpa(self) -> float:
        """Equivalent stress that a press fit may keep up."""
        return SUSTAINED_SHARE * self.yield_mpa


def load_elasticity(material: str) -> Elasticity:
    """Look a material up by its name in `materials.toml`.

    Raises:
        SpecError: If there are no elastic properties of it.
    """
    path = Path(str(resources.files(__package__) / "elasticity.toml"))
    known = read_toml(path)
    if material not in known:
        raise SpecError(
            f"There are no elastic properties of the material {material!r} for a snap or press fit; close "
            f"with dowels, screws or a thread ring, or take one of {', '.join(known)}."
        )
    return parse_model(Elasticity, known[material], path.name)
