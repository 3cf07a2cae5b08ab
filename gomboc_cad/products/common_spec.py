"""Tables that the specs of all products share."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from gomboc_cad.products.body_spec import BodySpec
from gomboc_cad.products.toml_model import Coordinate, Count, Number, Point, Text, TomlModel

Direction = Literal["auto", "rest"] | Point
"""A place on the outer surface: chosen by the drill map, at the rest, or the outward normal that is given."""


class ShellSpec(TomlModel):
    """The wall and how it is made.

    Attributes:
        wall_mm: Nominal thickness.
        min_wall_mm: The least that may be left of it; the minimum of the process if not given.
        material: Material, as in `materials.toml`.
        process: How the parts are made, as in `templates/processes/`.
    """

    wall_mm: Annotated[Number, Field(gt=0.0, le=200.0)] = 3.0
    min_wall_mm: Annotated[Number, Field(gt=0.0, le=50.0)] | None = None
    material: Text = "PLA"
    process: Text = "fdm"

    @model_validator(mode="after")
    def _ordered(self) -> ShellSpec:
        if self.min_wall_mm is not None and self.min_wall_mm > self.wall_mm:
            raise ValueError(f"min_wall_mm = {self.min_wall_mm:g} is more than wall_mm = {self.wall_mm:g}")
        return self


class SplitSpec(TomlModel):
    """The seam: a plane square to the resting direction.

    Attributes:
        height_mm: Height over the middle of the body.
        gap_mm: How far the upper part stands off the lower one, as with a layer of glue.
        step_mm: How far the upper part is displaced across the vertical, along first and second.
    """

    height_mm: Annotated[Number, Field(ge=-1000.0, le=1000.0)] = 0.0
    gap_mm: Annotated[Number, Field(ge=0.0, le=5.0)] = 0.0
    step_mm: tuple[Coordinate, Coordinate] = (0.0, 0.0)


class ComSpec(TomlModel):
    """Where the assembly's centre of mass is to be.

    Attributes:
        target: `best`: the best place of the loading zone near the centroid; `centroid` of the homogeneous
            body; or a point in mm in the body's frame.
        max_residual_um: Largest distance from the target that is accepted.
    """

    target: Literal["best", "centroid"] | Point = "best"
    max_residual_um: Annotated[Number, Field(gt=0.0, le=1e5)] = 1.0


class TrimSpec(TomlModel):
    """Trim masses and pockets that help the cavity's place to bring the centre of mass to its target.

    Attributes:
        kind: `none`, `balls` (metric balls of ISO 3290-1 in closed pockets), `set-screws` (ISO 4026 in
            tapped holes) or `pockets` (material taken away).
        material: Material of the masses.
        max_diameter_mm: Largest ball or screw to be tried.
    """

    kind: Literal["none", "balls", "set-screws", "pockets"] = "none"
    material: Text = "steel"
    max_diameter_mm: Annotated[Number, Field(gt=0.0, le=100.0)] = 10.0


class MarkSpec(TomlModel):
    """A mark of small drilled dots: an arrow and a part id.

    Attributes:
        text: The part id, up to 12 characters of A to Z, 0 to 9, dash and dot; empty for no mark.
        dot_mm: Diameter of a dot.
        depth_mm: Its depth.
        direction: Where it goes.
    """

    text: Annotated[str, Field(strict=True, max_length=12, pattern=r"^[A-Z0-9.\-]*$")] = ""
    dot_mm: Annotated[Number, Field(gt=0.0, le=10.0)] = 0.8
    depth_mm: Annotated[Number, Field(gt=0.0, le=5.0)] = 0.4
    direction: Literal["auto"] | Point = "auto"


class PlateSpec(TomlModel):
    """The plate to print: a bed with all made parts, several times over.

    Attributes:
        bed_mm: Size of the bed.
        spacing_mm: Free space between parts and around them.
        copies: How many products.
    """

    bed_mm: tuple[
        Annotated[Number, Field(gt=0.0, le=5000.0)], Annotated[Number, Field(gt=0.0, le=5000.0)]
    ] = (250.0, 210.0)
    spacing_mm: Annotated[Number, Field(ge=0.0, le=100.0)] = 5.0
    copies: Annotated[Count, Field(ge=1, le=500)] = 1


class MeshSpec(TomlModel):
    """How fine STL and 3MF are: the largest distance of a facet from the true surface."""

    sag_um: Annotated[Number, Field(ge=0.5, le=1000.0)] = 10.0


class ProductSpec(TomlModel):
    """What the spec of every product has."""

    product: str
    body: BodySpec
    shell: ShellSpec = ShellSpec()
    com: ComSpec = ComSpec()
    plate: PlateSpec = PlateSpec()
    mesh: MeshSpec = MeshSpec()
