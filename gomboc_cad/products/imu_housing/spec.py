"""The typed spec of the IMU calibration housing."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from gomboc_cad.products.closures import ClosureSpec
from gomboc_cad.products.closures.spec import DowelsSpec
from gomboc_cad.products.common_spec import (
    Direction,
    MarkSpec,
    ProductSpec,
    SplitSpec,
    TrimSpec,
)
from gomboc_cad.products.toml_model import Coordinate, Number, Text, TomlModel

NONE = "none"
"""What a battery's type or a cable's thread says where there is none."""


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


class BatterySpec(TomlModel):
    """A battery on a pedestal of its own, its length along the board's.

    Attributes:
        type: Name of a battery template, path of a user's own file, or `none`.
        height_mm: Height of its middle over the middle of the body. Above the board it hangs from the upper
            half, below the board it stands in the lower one.
        offset_mm: Shift of its middle across the vertical, along the board's length and width.
        clearance_mm: Least free space between the battery and anything but its pedestal.
        pedestal_mm: Size of the pedestal along and across the battery.
    """

    type: Text = NONE
    height_mm: Coordinate = 20.0
    offset_mm: tuple[Coordinate, Coordinate] = (0.0, 0.0)
    clearance_mm: Annotated[Number, Field(ge=0.0, le=50.0)] = 1.0
    pedestal_mm: tuple[
        Annotated[Number, Field(gt=0.0, le=200.0)], Annotated[Number, Field(gt=0.0, le=200.0)]
    ] = (12.0, 8.0)


class CableSpec(TomlModel):
    """A port for a cable gland with a metric thread.

    Attributes:
        thread: Metric thread of the gland (EN 60423, as used by EN 62444), or `none`.
        thread_length_mm: Length of thread that the gland needs.
        boss_wall_mm: Material around the thread.
        direction: Where it goes.
        plug: Whether the hole is closed by a flush plug, made with the housing.
    """

    thread: Literal["none", "M6x1", "M8x1", "M10x1", "M12x1.5", "M16x1.5", "M20x1.5", "M25x1.5"] = "none"
    thread_length_mm: Annotated[Number, Field(gt=0.0, le=50.0)] = 6.0
    boss_wall_mm: Annotated[Number, Field(ge=0.5, le=20.0)] = 2.0
    direction: Direction = "auto"
    plug: bool = False


class ToleranceSpec(TomlModel):
    """How far a finished part and its place of rest may be off, as half-widths; 0 is taken as exact.

    Attributes:
        com_error_um: Centre of mass of the assembly along each axis, beyond what the tolerances of board and
            battery do to it.
        seating_deg: Tilt of the board on its standoffs about each level axis.
        table_level_deg: Tilt of the table about each level axis.
        rolling_resistance_um: Rolling-resistance length: the part stops wherever the height's gradient is
            smaller.
    """

    com_error_um: Annotated[Number, Field(ge=0.0, le=1e4)] = 10.0
    seating_deg: Annotated[Number, Field(ge=0.0, le=45.0)] = 0.2
    table_level_deg: Annotated[Number, Field(ge=0.0, le=45.0)] = 0.01
    rolling_resistance_um: Annotated[Number, Field(ge=0.0, le=1e4)] = 1.0


class ImuHousingSpec(ProductSpec):
    """A two-part housing that always rests the same way up, with a sensor board on standoffs."""

    product: Literal["imu-housing"]
    split: SplitSpec = SplitSpec()
    board: MountSpec = MountSpec()
    standoffs: StandoffSpec = StandoffSpec()
    closure: ClosureSpec = DowelsSpec()
    battery: BatterySpec = BatterySpec()
    cable: CableSpec = CableSpec()
    trim: TrimSpec = TrimSpec()
    mark: MarkSpec = MarkSpec(text="A1")
    tolerances: ToleranceSpec = ToleranceSpec()
