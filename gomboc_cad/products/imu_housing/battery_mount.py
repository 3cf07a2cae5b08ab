"""A battery in the housing: how it lies, the pedestal that carries it, and the checks that it fits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from build123d import Solid

from gomboc_cad.body import Body
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.batteries import Battery
from gomboc_cad.products.envelope import Envelope, rectangle_mm
from gomboc_cad.products.imu_housing.spec import BatterySpec
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.solid.hollow import Box, Cylinder

TAPE_MM = 0.5
"""Room for double-sided tape between the battery and its pedestal."""


@dataclass(frozen=True)
class BatteryMount:
    """A battery with its length along first.

    Attributes:
        battery: The battery.
        solid: It, in the unmoved core.
        com_mm: Its centre of mass there.
        envelope: The room it takes.
        pedestal: The boss that carries it, from its face to beyond the wall.
        cradle: What is taken out of the pedestal for a round cell; None for a flat battery.
        face_mm: Height of the pedestal's face over the body's origin.
        in_upper: Whether it hangs from the upper half.
    """

    battery: Battery
    solid: Solid
    com_mm: Vector
    envelope: Envelope
    pedestal: Box
    cradle: Cylinder | None
    face_mm: float
    in_upper: bool


def mount_battery(
    spec: BatterySpec, battery: Battery, body: Body, frame: RestFrame, board_height_mm: float
) -> BatteryMount:
    """Lay a battery down on its pedestal.

    Args:
        spec: Where it is wanted.
        battery: The battery.
        body: The outer shape.
        frame: Frame of the resting pose.
        board_height_mm: Height of the board over the body's origin; a battery above it hangs from the
            upper half.
    """
    length, width, height = _lying_mm(battery)
    in_upper = spec.height_mm > board_height_mm
    towards_wall = 1.0 if in_upper else -1.0
    middle = spec.height_mm
    # The pedestal of a round cell reaches to its axis, and the cradle is cut out of it.
    face = middle if battery.shape == "cylinder" else middle + towards_wall * (0.5 * height + TAPE_MM)
    far = towards_wall * 1.5 * body.radius_mm
    pedestal = Box(
        as_vector(frame.point(*spec.offset_mm, 0.5 * (face + far))),
        frame.first,
        frame.up,
        (*spec.pedestal_mm, abs(far - face)),
    )
    return BatteryMount(
        battery=battery,
        solid=_solid(battery, spec, frame),
        com_mm=as_vector(frame.point(*spec.offset_mm, middle)),
        envelope=Envelope(
            f"the battery {battery.name!r}",
            rectangle_mm(spec.offset_mm, length, width),
            middle - 0.5 * height,
            middle + 0.5 * height,
        ),
        pedestal=pedestal,
        cradle=_cradle(battery, spec, frame) if battery.shape == "cylinder" else None,
        face_mm=face,
        in_upper=in_upper,
    )


def check_battery_fits(
    mount: BatteryMount,
    spec: BatterySpec,
    body: Body,
    frame: RestFrame,
    wall_mm: float,
    seam_mm: float,
    board: Envelope,
    columns: Sequence[Cylinder],
) -> None:
    """Check that a battery keeps its clearance from the wall, the board and the columns, and can be put in.

    Raises:
        GeometryError: With what it meets and a remedy.
    """
    room = mount.envelope
    clearance = min(room.wall_clearances_mm(body, frame, wall_mm))
    if clearance < spec.clearance_mm:
        raise GeometryError(
            f"The battery {mount.battery.name!r} does not fit: there is {max(0.0, clearance):.2f} mm of room "
            f"to the wall, and battery.clearance_mm asks for {spec.clearance_mm:g} mm; bring "
            "battery.height_mm nearer to the middle, or take a smaller battery, a thinner wall or a larger "
            "diameter."
        )
    on_its_side = room.low_mm >= seam_mm if mount.in_upper else room.high_mm <= seam_mm
    if not on_its_side and not room.passes(seam_mm, body, frame, wall_mm):
        raise GeometryError(
            f"The battery {mount.battery.name!r} does not pass the seam at {seam_mm:.4g} mm; move "
            "split.height_mm or battery.height_mm."
        )
    if (mount.face_mm > seam_mm) != mount.in_upper:
        half = "upper" if mount.in_upper else "lower"
        raise GeometryError(
            f"The battery {mount.battery.name!r} is held by the {half} half, but its pedestal would end "
            f"beyond the seam at {seam_mm:.4g} mm; move split.height_mm or battery.height_mm."
        )
    if (gap := room.gap_mm(board)) < spec.clearance_mm:
        raise GeometryError(
            f"The battery {mount.battery.name!r} comes within {gap:.2f} mm of the board, and "
            f"battery.clearance_mm asks for {spec.clearance_mm:g} mm; change battery.height_mm or "
            "board.seat_mm."
        )
    gaps = [room.gap_to_column_mm(frame, column) for column in columns]
    if min(gaps, default=spec.clearance_mm) < spec.clearance_mm:
        raise GeometryError(
            f"The battery {mount.battery.name!r} comes within {min(gaps):.2f} mm of a boss, and "
            f"battery.clearance_mm asks for {spec.clearance_mm:g} mm; change battery.offset_mm, turn the "
            "closure, or take a smaller battery or a larger diameter."
        )


def _lying_mm(battery: Battery) -> tuple[float, float, float]:
    """Size along first, second and up, terminals at the end of a cell or the top of a block included."""
    if battery.shape == "cylinder":
        diameter, length = battery.size_mm
        return length + 2.0 * battery.terminals_mm, diameter, diameter
    length, width, height = battery.size_mm
    return length, width, height + 2.0 * battery.terminals_mm


def _along(frame: RestFrame) -> RestFrame:
    """The frame in which a lying cell stands."""
    return RestFrame(up=frame.first, first=frame.second, second=frame.up)


def _solid(battery: Battery, spec: BatterySpec, frame: RestFrame) -> Solid:
    half = 0.5 * battery.height_mm
    if battery.shape == "cylinder":
        start = frame.point(spec.offset_mm[0] - half, spec.offset_mm[1], spec.height_mm)
        return battery.solid(_along(frame), start)
    return battery.solid(frame, frame.point(*spec.offset_mm, spec.height_mm - half))


def _cradle(battery: Battery, spec: BatterySpec, frame: RestFrame) -> Cylinder:
    length = battery.height_mm + 2.0 * battery.terminals_mm + 2.0 * spec.clearance_mm
    start = frame.point(spec.offset_mm[0] - 0.5 * length, spec.offset_mm[1], spec.height_mm)
    return Cylinder(as_vector(start), frame.first, 0.5 * battery.size_mm[0] + TAPE_MM, length)
