"""The typed spec of the IMU calibration housing."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from gomboc_cad.products.body_spec import BodySpec
from gomboc_cad.products.toml_model import Coordinate, Count, Number, Point, Text, TomlModel


class ShellSpec(TomlModel):
    """The wall: nominal thickness, the least that may be left of it, and the material of both halves."""

    wall_mm: Annotated[Number, Field(gt=0.0, le=200.0)] = 3.0
    min_wall_mm: Annotated[Number, Field(gt=0.0, le=50.0)] = 1.2
    material: Text = "PLA"

    @model_validator(mode="after")
    def _ordered(self) -> ShellSpec:
        if self.min_wall_mm > self.wall_mm:
            raise ValueError(f"min_wall_mm = {self.min_wall_mm:g} is more than wall_mm = {self.wall_mm:g}")
        return self


class SplitSpec(TomlModel):
    """The seam: a plane square to the resting direction, at a height over the middle of the body."""

    height_mm: Annotated[Number, Field(ge=-500.0, le=500.0)] = 0.0


class MountSpec(TomlModel):
    """Where the board sits in the lower half.

    Attributes:
        type: Name of a board template or path of a user's own file.
        seat_mm: Height of the board's underside over the cavity floor below its middle.
        offset_mm: Shift of the board's middle across the vertical, along its length and width.
        clearance_mm: Least free space between board and wall.
    """

    type: Text = "adafruit-bno055"
    seat_mm: Annotated[Number, Field(gt=0.0, le=500.0)] = 10.0
    offset_mm: tuple[Coordinate, Coordinate] = (0.0, 0.0)
    clearance_mm: Annotated[Number, Field(ge=0.0, le=50.0)] = 1.0


class StandoffSpec(TomlModel):
    """Standoffs with heat-set inserts, and the screws that hold the board.

    Attributes:
        diameter_mm: Outer diameter of a standoff.
        insert: Size of the heat-set insert in bd_warehouse's spelling.
        insert_maker: Maker or standard of the insert in bd_warehouse's spelling.
        screw: Thread of the pan-head screws in bd_warehouse's spelling.
        screw_standard: Standard of the screws.
        screw_length_mm: Length under the head.
    """

    diameter_mm: Annotated[Number, Field(gt=0.0, le=50.0)] = 6.0
    insert: Text = "M2-0.4-3"
    insert_maker: Text = "CNCKitchen"
    screw: Text = "M2-0.4"
    screw_standard: Text = "iso14583"
    screw_length_mm: Annotated[Number, Field(gt=0.0, le=50.0)] = 4.0


class ClosureSpec(TomlModel):
    """How the halves are closed: parallel pins across the seam, in bosses along the wall.

    Attributes:
        kind: `dowels`: pressed or glued pins; the outer surface stays whole.
        count: Number of pins, evenly around the vertical.
        diameter_mm: Pin diameter.
        length_mm: Pin length, half in each part.
        boss_wall_mm: Material around the hole.
        end_gap_mm: Free length at each end of a pin.
        angle_deg: Angle of the first pin about the vertical.
        material: Material of the pins.
    """

    kind: Literal["dowels"] = "dowels"
    count: Annotated[Count, Field(ge=2, le=8)] = 3
    diameter_mm: Annotated[Number, Field(gt=0.0, le=20.0)] = 3.0
    length_mm: Annotated[Number, Field(gt=0.0, le=100.0)] = 12.0
    boss_wall_mm: Annotated[Number, Field(ge=0.5, le=20.0)] = 2.0
    end_gap_mm: Annotated[Number, Field(ge=0.0, le=5.0)] = 0.5
    angle_deg: Annotated[Number, Field(ge=-360.0, le=360.0)] = 0.0
    material: Text = "steel"

    @property
    def boss_radius_mm(self) -> float:
        """Radius of the boss around a pin."""
        return 0.5 * self.diameter_mm + self.boss_wall_mm

    @property
    def half_hole_mm(self) -> float:
        """Depth of a pin's hole on each side of the seam."""
        return 0.5 * self.length_mm + self.end_gap_mm


class ComSpec(TomlModel):
    """Where the assembly's centre of mass is to be.

    Attributes:
        target: `centroid` of the homogeneous body, or a point in mm in the body's frame.
        max_residual_um: Largest distance from the target that is accepted.
    """

    target: Literal["centroid"] | Point = "centroid"
    max_residual_um: Annotated[Number, Field(gt=0.0, le=1e5)] = 1.0


class MeshSpec(TomlModel):
    """How fine STL and 3MF are: the largest distance of a facet from the true surface."""

    sag_um: Annotated[Number, Field(ge=0.5, le=1000.0)] = 10.0


class ImuHousingSpec(TomlModel):
    """A two-part housing that always rests the same way up, with a sensor board on standoffs."""

    product: Literal["imu-housing"]
    body: BodySpec
    shell: ShellSpec = ShellSpec()
    split: SplitSpec = SplitSpec()
    board: MountSpec = MountSpec()
    standoffs: StandoffSpec = StandoffSpec()
    closure: ClosureSpec = ClosureSpec()
    com: ComSpec = ComSpec()
    mesh: MeshSpec = MeshSpec()
