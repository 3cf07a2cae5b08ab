"""The typed spec of the seed pod."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from gomboc_cad.products.closures.spec import DowelsSpec, PressSpec, SnapSpec
from gomboc_cad.products.common_spec import ProductSpec, SplitSpec, TrimSpec
from gomboc_cad.products.toml_model import Number, Text, TomlModel

SMALLEST_MM, LARGEST_MM = 10.0, 60.0


class SeedSpec(TomlModel):
    """The seed and the room around it.

    Attributes:
        species: Name of a seed template or path of a user's own file.
        clearance_mm: Room between the seed and the wall of its chamber, all around.
        play_mm: How far the middle of the seed may be off its place.
    """

    species: Text = "helianthus-annuus"
    clearance_mm: Annotated[Number, Field(gt=0.0, le=30.0)] = 4.0
    play_mm: Annotated[Number, Field(ge=0.0, le=30.0)] = 0.5


class SubstrateSpec(TomlModel):
    """What fills the room between seed and wall.

    Attributes:
        material: Material, as in `materials.toml`, or `none`.
        density_g_cm3: Bulk density as it is packed, where it was weighed; that of the material if not given.
        fill: Share of the room that is filled.
        mass_scatter: How far the mass of the filling may be off, as a share of it.
    """

    material: Text = "coir"
    density_g_cm3: Annotated[Number, Field(ge=0.01, le=3.0)] | None = None
    fill: Annotated[Number, Field(ge=0.0, le=1.0)] = 1.0
    mass_scatter: Annotated[Number, Field(ge=0.0, lt=1.0)] = 0.1

    @property
    def used(self) -> bool:
        """Whether there is any."""
        return self.material != "none" and self.fill > 0.0


class ExitSpec(TomlModel):
    """The way out for the root, at the rest point.

    Attributes:
        diameter_mm: Its diameter; what the seed's data ask for if not given.
    """

    diameter_mm: Annotated[Number, Field(gt=0.0, le=30.0)] | None = None


class PlugSpec(TomlModel):
    """The pod is one piece with an opening at the top, closed by a plug whose top is the pod's own surface.

    Attributes:
        kind: `plug`.
        passage_mm: Free space around the seed on its way in.
        shoulder_mm: Width of the ledge that the plug sits on.
        gap_mm: Free space around the plug.
    """

    kind: Literal["plug"]
    passage_mm: Annotated[Number, Field(ge=0.0, le=10.0)] = 0.5
    shoulder_mm: Annotated[Number, Field(gt=0.0, le=10.0)] = 1.2
    gap_mm: Annotated[Number, Field(gt=0.0, le=1.0)] = 0.1


PodClosureSpec = Annotated[PlugSpec | SnapSpec | PressSpec | DowelsSpec, Field(discriminator="kind")]
"""How a pod is closed: one piece with a plug, or two halves; nothing of it opens the outer surface."""


class SeedPodSpec(ProductSpec):
    """A pod that comes to rest with the root of its seed pointing down."""

    product: Literal["seed-pod"]
    seed: SeedSpec = SeedSpec()
    substrate: SubstrateSpec = SubstrateSpec()
    exit: ExitSpec = ExitSpec()
    split: SplitSpec = SplitSpec()
    closure: PodClosureSpec = SnapSpec(kind="snap", height_mm=4.0)
    trim: TrimSpec = TrimSpec()

    @model_validator(mode="after")
    def _small(self) -> SeedPodSpec:
        if not SMALLEST_MM <= self.body.diameter_mm <= LARGEST_MM:
            raise ValueError(
                f"body.diameter_mm = {self.body.diameter_mm:g} is not allowed for a seed pod "
                f"({SMALLEST_MM:g} to {LARGEST_MM:g})"
            )
        if self.seed.play_mm > self.seed.clearance_mm:
            raise ValueError(
                f"seed.play_mm = {self.seed.play_mm:g} is more than seed.clearance_mm = "
                f"{self.seed.clearance_mm:g}, which is all the room there is"
            )
        return self
