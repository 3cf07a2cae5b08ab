"""The board as a solid, and the checks that it can be mounted."""

from __future__ import annotations

import math

import numpy as np
from build123d import Axis, Box, Cylinder, Location, Solid, fillet

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.envelope import Envelope
from gomboc_cad.products.fasteners import Insert, Screw, thread_of
from gomboc_cad.products.imu_housing.boards import Board
from gomboc_cad.products.imu_housing.spec import ImuHousingSpec
from gomboc_cad.products.placement import RestFrame

_ARC_POINTS = 5


def board_solid(board: Board) -> Solid:
    """The laminate with its mounting holes, in the board's frame."""
    plate = Box(board.length_mm, board.width_mm, board.thickness_mm).moved(
        Location((0.5 * board.length_mm, 0.5 * board.width_mm, 0.5 * board.thickness_mm))
    )
    if board.corner_radius_mm > 0.0:
        plate = fillet(plate.edges().filter_by(Axis.Z), board.corner_radius_mm)
    for hole in board.holes:
        drill = Cylinder(0.5 * hole.diameter_mm, 3.0 * board.thickness_mm)
        plate = plate - drill.moved(Location((hole.x_mm, hole.y_mm, 0.0)))
    return plate.solid()


def check_fasteners(spec: ImuHousingSpec, board: Board, insert: Insert, screw: Screw) -> None:
    """Check that screw, board hole, insert and standoff go together.

    Raises:
        GeometryError: If one of them is too large, too long or too short.
    """
    narrowest = min(hole.diameter_mm for hole in board.holes)
    if screw.thread_mm > narrowest:
        raise GeometryError(
            f"The screw {screw.standard} does not pass the board's {narrowest:g} mm holes; choose a "
            "thinner one in standoffs.screw, with an insert to match."
        )
    if thread_of(spec.standoffs.insert) != screw.thread_mm:
        raise GeometryError(
            f"The insert {insert.standard} and the screw {screw.standard} have different threads; make "
            "standoffs.insert and standoffs.screw match."
        )
    least = insert.hole_diameter_mm + 2.0 * insert.min_wall_mm
    if spec.standoffs.diameter_mm < least:
        raise GeometryError(
            f"standoffs.diameter_mm = {spec.standoffs.diameter_mm:g} leaves too little around the insert "
            f"{insert.standard}; it needs at least {least:g} mm."
        )
    depth = insert.hole_depth_mm
    reach = screw.length_mm - board.thickness_mm
    if reach <= 0.0 or reach > depth:
        raise GeometryError(
            f"The screw {screw.standard} reaches {reach:g} mm below the board, but its boss takes more "
            f"than 0 and at most {depth:g} mm; choose another standoffs.screw_length_mm."
        )


def board_outline_mm(board: Board) -> Array:
    """Points of the outline in the board's frame, corners rounded, shape (4·5, 2)."""
    r = board.corner_radius_mm
    points = []
    for corner, (x, y) in enumerate(
        [(board.length_mm - r, board.width_mm - r), (r, board.width_mm - r), (r, r), (board.length_mm - r, r)]
    ):
        for step in range(_ARC_POINTS):
            angle = 0.5 * math.pi * (corner + step / (_ARC_POINTS - 1))
            points.append((x + r * math.cos(angle), y + r * math.sin(angle)))
    return np.array(points)


def board_envelope(
    board: Board, corner_mm: tuple[float, float], seat_mm: float, tallest_mm: float
) -> Envelope:
    """The room that a board needs on its seat.

    Args:
        board: The board.
        corner_mm: Its own origin across the vertical.
        seat_mm: Height of its underside over the body's origin.
        tallest_mm: Height of what stands on it, over its underside.
    """
    outline = board_outline_mm(board) + corner_mm
    return Envelope(f"the board {board.name!r}", outline, seat_mm - board.below_mm, seat_mm + tallest_mm)


def check_board_fits(
    spec: ImuHousingSpec, body: Body, frame: RestFrame, board: Board, envelope: Envelope, seam_mm: float
) -> None:
    """Check that the board keeps its clearance from the wall and passes the open seam.

    Raises:
        GeometryError: With the clearance that is there and the one that is asked for.
    """
    lower, upper = envelope.wall_clearances_mm(body, frame, spec.shell.wall_mm)
    worst = min(lower, upper)
    if worst < spec.board.clearance_mm:
        side, remedy = ("lower", "raise") if lower <= upper else ("upper", "lower")
        state = f"only {worst:.2f} mm" if worst >= 0.0 else f"{-worst:.2f} mm too little"
        raise GeometryError(
            f"The board {board.name!r} does not fit: at its {side} side there is {state} of room to the "
            f"wall, and board.clearance_mm asks for {spec.board.clearance_mm:g} mm; {remedy} "
            "board.seat_mm, or take a larger diameter, a thinner wall or a smaller board."
        )
    if not envelope.passes(seam_mm, body, frame, spec.shell.wall_mm):
        raise GeometryError(
            f"The board {board.name!r} does not pass through the open lower half, whose mouth at the seam "
            "is narrower than the cavity around the board; lower split.height_mm."
        )
