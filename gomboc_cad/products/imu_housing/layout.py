"""Where everything is in the housing, in the frame of the resting pose."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, geodesic_triangulation
from gomboc_cad.equilibria import convexity, find_equilibria
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.batteries import Battery, load_battery
from gomboc_cad.products.closures.layout import ClosureLayout, ClosureSite, lay_out_closure
from gomboc_cad.products.envelope import Envelope
from gomboc_cad.products.fasteners import Insert, Screw, heat_set_insert, screw
from gomboc_cad.products.imu_housing.battery_mount import BatteryMount, check_battery_fits, mount_battery
from gomboc_cad.products.imu_housing.boards import Board, load_board
from gomboc_cad.products.imu_housing.cable_port import CablePort
from gomboc_cad.products.imu_housing.mounting import board_envelope, check_board_fits, check_fasteners
from gomboc_cad.products.imu_housing.spec import NONE, ImuHousingSpec
from gomboc_cad.products.imu_housing.trim_columns import TrimColumns, place_trim_columns
from gomboc_cad.products.openings.marking import Mark, place_mark
from gomboc_cad.products.openings.sites import PlacedOpening, place_openings
from gomboc_cad.products.placement import RestFrame, cavity_floor_mm
from gomboc_cad.products.placing.trim import TrimSite
from gomboc_cad.solid.hollow import Cylinder, HollowBody, Tool
from gomboc_cad.solid.offset import InsetSurface

Place = tuple[float, float]


@dataclass(frozen=True)
class HousingContents:
    """What is bought for a housing, looked up once."""

    board: Board
    insert: Insert
    screw: Screw
    battery: Battery | None

    @classmethod
    def of(cls, spec: ImuHousingSpec, spec_folder: Path | None = None) -> HousingContents:
        """Look up what a spec names.

        Args:
            spec: The spec.
            spec_folder: Folder that the names of a user's own data files start from.

        Raises:
            SpecError: If something is not available.
        """
        standoffs = spec.standoffs
        return cls(
            board=load_board(spec.board.type, spec_folder),
            insert=heat_set_insert(standoffs.insert, standoffs.insert_maker),
            screw=screw(standoffs.screw, standoffs.screw_length_mm, standoffs.screw_standard),
            battery=None if spec.battery.type == NONE else load_battery(spec.battery.type, spec_folder),
        )


@dataclass(frozen=True)
class HousingLayout:
    """The interior of a housing, its core not moved, and what opens its outer surface.

    Attributes:
        frame: Frame of the resting pose.
        hollow: Outer surface, cavity, bosses, holes and openings.
        closure: How the halves are closed.
        seat_height_mm: Height of the board's underside over the body's origin.
        board_corner_mm: The board's own origin across the vertical (along first, second).
        hole_places_mm: Mounting holes across the vertical.
        battery: The battery, if there is one.
        port: Sizes of the cable port, if there is one.
        recess: The port's recess in the outer surface.
        mark: The mark, if there is one.
        trim_sites: Where trim may go.
    """

    frame: RestFrame
    hollow: HollowBody
    closure: ClosureLayout
    seat_height_mm: float
    board_corner_mm: Place
    hole_places_mm: tuple[Place, ...]
    battery: BatteryMount | None
    port: CablePort | None
    recess: PlacedOpening | None
    mark: Mark | None
    trim_sites: tuple[TrimSite, ...]

    @property
    def board_origin_mm(self) -> Array:
        """The board's own origin in the body's frame, shape (3,)."""
        return self.frame.point(*self.board_corner_mm, self.seat_height_mm)

    @property
    def fixed_openings(self) -> tuple[PlacedOpening, ...]:
        """Openings that stay where they are when the core moves."""
        recess = () if self.recess is None else (self.recess,)
        return (*recess, *(() if self.mark is None else self.mark.openings))


def lay_out(
    spec: ImuHousingSpec, body: Body, com_mm: Vector, contents: HousingContents, least_wall_mm: float
) -> HousingLayout:
    """Place closure, board, standoffs, battery, port and mark, and check that they fit.

    Args:
        spec: What is asked for.
        body: The outer shape.
        com_mm: Where the centre of mass is to be.
        contents: What is bought.
        least_wall_mm: What must be left of the wall.

    Raises:
        GeometryError: If something does not fit.
    """
    check_fasteners(spec, contents.board, contents.insert, contents.screw)
    # Refuses a wall at which the cavity would fold, before anything is placed in it.
    InsetSurface(body, spec.shell.wall_mm)
    frame = RestFrame.from_rest(resting_direction(body, com_mm))
    seam = spec.split.height_mm
    board = _place_board(spec, body, frame, contents, seam)
    # Of all closures, only screws look for their places.
    keep_out = board.way_in.posts(frame, spec.board.clearance_mm) if spec.closure.kind == "screws" else ()
    site = ClosureSite(body, frame, spec.shell, seam, com_mm, keep_out=keep_out, sag_um=spec.mesh.sag_um)
    closure = lay_out_closure(spec.closure, site)
    _check_way_in(spec, frame, board, closure)
    battery = _place_battery(spec, body, frame, contents, board, closure)
    contents_room = [board.envelope, *([battery.envelope] if battery else [])]
    trim = TrimColumns()
    if spec.trim.kind != NONE:
        trim = place_trim_columns(spec.trim, site, least_wall_mm, contents_room, closure.columns)
    columns = (*closure.columns, *trim.bosses, *(room.column(frame) for room in contents_room))
    port, recess = _place_port(spec, body, com_mm, frame, columns, closure, least_wall_mm)
    mark = _place_mark(spec, body, com_mm, frame, recess, closure, least_wall_mm)
    largest_shift = spec.shell.wall_mm - least_wall_mm
    return HousingLayout(
        frame=frame,
        hollow=HollowBody(
            body,
            spec.shell.wall_mm,
            bosses=(
                *_standoffs(spec, body, frame, board),
                *closure.bosses,
                *trim.bosses,
                *([battery.pedestal] if battery else []),
                *([port.boss(recess)] if port and recess else []),
            ),
            holes=(
                *_insert_holes(frame, board, contents.insert),
                *closure.holes,
                *([battery.cradle] if battery and battery.cradle else []),
            ),
            openings=_cuts(port, recess, mark, largest_shift),
        ),
        closure=closure,
        seat_height_mm=board.seat_mm,
        board_corner_mm=board.corner_mm,
        hole_places_mm=board.holes_mm,
        battery=battery,
        port=port,
        recess=recess,
        mark=mark,
        trim_sites=trim.sites,
    )


def resting_direction(body: Body, com_mm: Vector) -> Vector:
    """The direction that points down in the lowest rest about a centre of mass."""
    if convexity(body).strictly_convex:
        return find_equilibria(body, com_mm)[0].direction
    grid = geodesic_triangulation(5)[0]
    nearest = grid[np.linalg.norm(body.position_mm(grid) - np.array(com_mm), axis=1).argmin()]
    return as_vector(body.normal(nearest[None])[0])


@dataclass(frozen=True)
class _PlacedBoard:
    """The board on its seat; on its way in, it passes everything from there to the seam."""

    seat_mm: float
    corner_mm: Place
    holes_mm: tuple[Place, ...]
    envelope: Envelope
    way_in: Envelope


def _place_board(
    spec: ImuHousingSpec,
    body: Body,
    frame: RestFrame,
    contents: HousingContents,
    seam: float,
) -> _PlacedBoard:
    board, offset = contents.board, spec.board.offset_mm
    corner = (offset[0] - 0.5 * board.length_mm, offset[1] - 0.5 * board.width_mm)
    seat = cavity_floor_mm(body, frame, spec.shell.wall_mm, *offset) + spec.board.seat_mm
    if seat >= seam:
        raise GeometryError(
            f"The board's seat at {seat:.4g} mm is not below the seam at {seam:.4g} mm (heights over the "
            "middle of the body); lower board.seat_mm or raise split.height_mm."
        )
    tallest = max(board.height_mm, board.thickness_mm + contents.screw.head_height_mm)
    envelope = board_envelope(board, corner, seat, tallest)
    check_board_fits(spec, body, frame, board, envelope, seam)
    holes = tuple((corner[0] + hole.x_mm, corner[1] + hole.y_mm) for hole in board.holes)
    _check_standoff_heights(spec, body, frame, holes, seat, contents.insert)
    way_in = replace(envelope, high_mm=max(envelope.high_mm, seam))
    return _PlacedBoard(seat, corner, holes, envelope, way_in)


def _check_way_in(
    spec: ImuHousingSpec, frame: RestFrame, board: _PlacedBoard, closure: ClosureLayout
) -> None:
    """Refuse a closure whose bosses leave the board no way to its seat."""
    for column in closure.columns:
        gap = board.way_in.gap_to_column_mm(frame, column)
        if gap < spec.board.clearance_mm:
            first, second, _ = frame.matrix() @ np.array(column.base_mm)
            raise GeometryError(
                f"The boss of the closure at ({first:.1f}, {second:.1f}) mm comes within {gap:.2f} mm of the "
                "board; turn closure.angle_deg, use thinner pins or screws, or a larger diameter."
            )


def _check_standoff_heights(
    spec: ImuHousingSpec, body: Body, frame: RestFrame, holes: tuple[Place, ...], seat: float, insert: Insert
) -> None:
    needed = insert.hole_depth_mm
    for place in holes:
        height = seat - cavity_floor_mm(body, frame, spec.shell.wall_mm, *place)
        if height < needed:
            raise GeometryError(
                f"The standoff at ({place[0]:.2f}, {place[1]:.2f}) mm is {height:.2f} mm tall, but the "
                f"hole for the insert {insert.standard} needs {needed:g} mm; raise board.seat_mm by "
                f"{needed - height:.2f} mm or more."
            )


def _place_battery(
    spec: ImuHousingSpec,
    body: Body,
    frame: RestFrame,
    contents: HousingContents,
    board: _PlacedBoard,
    closure: ClosureLayout,
) -> BatteryMount | None:
    if contents.battery is None:
        return None
    mount = mount_battery(spec.battery, contents.battery, body, frame, board.seat_mm)
    columns = (*closure.columns, *_standoffs(spec, body, frame, board))
    check_battery_fits(
        mount,
        spec.battery,
        body,
        frame,
        spec.shell.wall_mm,
        spec.split.height_mm,
        board.envelope,
        columns,
    )
    return mount


def _place_port(
    spec: ImuHousingSpec,
    body: Body,
    com_mm: Vector,
    frame: RestFrame,
    columns: tuple[Cylinder, ...],
    closure: ClosureLayout,
    least_wall_mm: float,
) -> tuple[CablePort, PlacedOpening] | tuple[None, None]:
    if spec.cable.thread == NONE:
        return None, None
    largest_shift = spec.shell.wall_mm - least_wall_mm
    port = CablePort.of(spec.cable, largest_shift)
    (recess,) = place_openings(
        body,
        com_mm,
        [port.request(spec.cable)],
        frame=frame,
        # The boss behind the recess must be clear too, not only the recess.
        wall_mm=port.boss_wall_mm + least_wall_mm,
        seam_height_mm=spec.split.height_mm,
        keep_out=columns,
        others=closure.openings,
    )
    return port, recess


def _place_mark(
    spec: ImuHousingSpec,
    body: Body,
    com_mm: Vector,
    frame: RestFrame,
    recess: PlacedOpening | None,
    closure: ClosureLayout,
    least_wall_mm: float,
) -> Mark | None:
    # There is no drill map of a body that is not strictly convex.
    if not spec.mark.text or not convexity(body).strictly_convex:
        return None
    return place_mark(
        body,
        com_mm,
        spec.mark,
        frame=frame,
        wall_mm=spec.shell.wall_mm,
        min_wall_mm=least_wall_mm,
        pointing=frame.first,
        seam_height_mm=spec.split.height_mm,
        # Where it can be read while the part rests.
        side="upper",
        others=(*closure.openings, *(() if recess is None else (recess,))),
    )


def _cuts(
    port: CablePort | None, recess: PlacedOpening | None, mark: Mark | None, largest_shift_mm: float
) -> tuple[Tool, ...]:
    """What is cut at the end, wherever the core is."""
    of_port = (recess.tool, port.core_hole(recess, largest_shift_mm)) if port and recess else ()
    return (*of_port, *(() if mark is None else mark.dots))


def _standoffs(
    spec: ImuHousingSpec, body: Body, frame: RestFrame, board: _PlacedBoard
) -> tuple[Cylinder, ...]:
    # They start outside the body; only what lies in the cavity counts.
    far = 1.5 * body.radius_mm
    radius = 0.5 * spec.standoffs.diameter_mm
    return tuple(
        Cylinder(as_vector(frame.point(*place, -far)), frame.up, radius, board.seat_mm + far)
        for place in board.holes_mm
    )


def _insert_holes(frame: RestFrame, board: _PlacedBoard, insert: Insert) -> tuple[Cylinder, ...]:
    depth, radius = insert.hole_depth_mm, 0.5 * insert.hole_diameter_mm
    return tuple(
        Cylinder(as_vector(frame.point(*place, board.seat_mm - depth)), frame.up, radius, depth)
        for place in board.holes_mm
    )
