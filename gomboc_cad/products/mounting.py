"""The board as a solid, and the checks that it can be mounted."""

from __future__ import annotations

import math

import numpy as np
from build123d import Axis, Box, Cylinder, Location, Solid, fillet

from gomboc_cad.body import Body, depth_mm
from gomboc_cad.body.sphere import Array
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.boards import Board
from gomboc_cad.products.fasteners import Insert, Screw
from gomboc_cad.products.imu_housing_spec import ImuHousingSpec
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
    if float(spec.standoffs.insert.split("-")[0].lstrip("M")) != screw.thread_mm:
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


def check_board_fits(
    spec: ImuHousingSpec,
    body: Body,
    frame: RestFrame,
    board: Board,
    corner_mm: tuple[float, float],
    seat_mm: float,
    tallest_mm: float,
    seam_mm: float,
) -> None:
    """Check that the board's box keeps its clearance from the wall and passes the open seam.

    The cavity of a convex body is convex, so the box lies in it when the points of its outline do.

    Raises:
        GeometryError: With the clearance that is there and the one that is asked for.
    """
    outline = board_outline_mm(board) + corner_mm
    levels = (seat_mm - board.below_mm, seat_mm + tallest_mm)
    box = np.array([frame.point(first, second, level) for level in levels for first, second in outline])
    clearance = depth_mm(body, box) - spec.shell.wall_mm
    opening = np.array([frame.point(first, second, seam_mm) for first, second in outline])
    worst = float(clearance.min())
    if worst < spec.board.clearance_mm:
        side = "lower" if int(clearance.argmin()) < len(outline) else "upper"
        remedy = "raise" if side == "lower" else "lower"
        state = f"only {worst:.2f} mm" if worst >= 0.0 else f"{-worst:.2f} mm too little"
        raise GeometryError(
            f"The board {board.name!r} does not fit: at its {side} side there is {state} of room to the "
            f"wall, and board.clearance_mm asks for {spec.board.clearance_mm:g} mm; {remedy} "
            "board.seat_mm, or take a larger diameter, a thinner wall or a smaller board."
        )
    if float(depth_mm(body, opening).min()) < spec.shell.wall_mm:
        raise GeometryError(
            f"The board {board.name!r} does not pass through the open lower half, whose mouth at the seam "
            "is narrower than the cavity around the board; lower split.height_mm."
        )
