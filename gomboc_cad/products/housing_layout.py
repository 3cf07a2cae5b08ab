"""Where everything is in the housing, in the frame of the resting pose."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gomboc_cad.body import Body, mass_properties
from gomboc_cad.body.sphere import Array, geodesic_triangulation
from gomboc_cad.equilibria import convexity, find_equilibria
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.boards import Board
from gomboc_cad.products.fasteners import Insert, Screw
from gomboc_cad.products.imu_housing_spec import ImuHousingSpec
from gomboc_cad.products.mounting import (
    board_outline_mm,
    check_board_fits,
    check_fasteners,
)
from gomboc_cad.products.placement import RestFrame, boss_radius_from_axis_mm, cavity_floor_mm
from gomboc_cad.solid.hollow import Cylinder, HollowBody
from gomboc_cad.solid.offset import InsetSurface

Place = tuple[float, float]


@dataclass(frozen=True)
class HousingLayout:
    """The interior of a housing.

    Attributes:
        frame: Frame of the resting pose.
        hollow: Outer surface, cavity, bosses and holes.
        seat_height_mm: Height of the board's underside over the body's origin.
        seam_height_mm: Height of the seam over the body's origin.
        board_corner_mm: The board's own origin across the vertical (along first, second).
        hole_places_mm: Mounting holes across the vertical.
        pin_places_mm: Pins across the vertical.
    """

    frame: RestFrame
    hollow: HollowBody
    seat_height_mm: float
    seam_height_mm: float
    board_corner_mm: Place
    hole_places_mm: tuple[Place, ...]
    pin_places_mm: tuple[Place, ...]

    @property
    def seam_point_mm(self) -> Vector:
        """The point of the seam's plane over the body's origin."""
        return as_vector(self.frame.point(0.0, 0.0, self.seam_height_mm))

    def moved(self, shift_mm: Array) -> HousingLayout:
        """The same interior as one rigid core moved by a vector of the body's frame, shape (3,)."""
        first, second, up = (float(value) for value in self.frame.matrix() @ shift_mm)

        def across(place: Place) -> Place:
            return place[0] + first, place[1] + second

        return replace(
            self,
            hollow=replace(self.hollow, core_shift_mm=as_vector(shift_mm)),
            seat_height_mm=self.seat_height_mm + up,
            seam_height_mm=self.seam_height_mm + up,
            board_corner_mm=across(self.board_corner_mm),
            hole_places_mm=tuple(across(place) for place in self.hole_places_mm),
            pin_places_mm=tuple(across(place) for place in self.pin_places_mm),
        )


def lay_out(spec: ImuHousingSpec, body: Body, board: Board, insert: Insert, screw: Screw) -> HousingLayout:
    """Place board, standoffs, seam and pins, and check that they fit.

    Raises:
        GeometryError: If something does not fit.
    """
    check_fasteners(spec, board, insert, screw)
    # Refuses a wall at which the cavity would fold, before anything is placed in it.
    InsetSurface(body, spec.shell.wall_mm)
    frame = RestFrame.from_rest(_down(body))
    offset = spec.board.offset_mm
    corner = (offset[0] - 0.5 * board.length_mm, offset[1] - 0.5 * board.width_mm)
    seat = cavity_floor_mm(body, frame, spec.shell.wall_mm, *offset) + spec.board.seat_mm
    seam = spec.split.height_mm
    if seat >= seam:
        raise GeometryError(
            f"The board's seat at {seat:.4g} mm is not below the seam at {seam:.4g} mm (heights over the "
            "middle of the body); lower board.seat_mm or raise split.height_mm."
        )
    check_board_fits(spec, body, frame, board, corner, seat, _tallest(board, screw), seam)
    holes = tuple((corner[0] + hole.x_mm, corner[1] + hole.y_mm) for hole in board.holes)
    _check_standoff_heights(spec, body, frame, holes, seat, insert)
    pins = _pin_places(spec, body, frame, seam)
    _check_pins_clear_board(spec, board, corner, pins)
    hollow = HollowBody(
        body,
        spec.shell.wall_mm,
        bosses=_bosses(spec, body, frame, holes, seat, pins),
        holes=_holes(spec, frame, holes, seat, pins, seam, insert),
    )
    return HousingLayout(frame, hollow, seat, seam, corner, holes, pins)


def _down(body: Body) -> Vector:
    """The direction that points down at rest, about the homogeneous centroid."""
    centroid = np.array(mass_properties(body).com_mm)
    if convexity(body).strictly_convex:
        return find_equilibria(body, centroid)[0].direction
    grid = geodesic_triangulation(5)[0]
    nearest = grid[np.linalg.norm(body.position_mm(grid) - centroid, axis=1).argmin()]
    return as_vector(body.normal(nearest[None])[0])


def _tallest(board: Board, screw: Screw) -> float:
    return max(board.height_mm, board.thickness_mm + screw.head_height_mm)


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


def _pin_places(spec: ImuHousingSpec, body: Body, frame: RestFrame, seam: float) -> tuple[Place, ...]:
    """Put the pins as far out as the wall behind their holes stays whole."""
    half = spec.closure.half_hole_mm
    depth = spec.shell.wall_mm + 0.5 * spec.closure.diameter_mm
    places = []
    for index in range(spec.closure.count):
        angle = math.radians(spec.closure.angle_deg) + 2.0 * math.pi * index / spec.closure.count
        radius = boss_radius_from_axis_mm(body, frame, angle, (seam - half, seam, seam + half), depth)
        places.append((radius * math.cos(angle), radius * math.sin(angle)))
    return tuple(places)


def _check_pins_clear_board(
    spec: ImuHousingSpec, board: Board, corner: Place, pins: tuple[Place, ...]
) -> None:
    """The bosses of the pins run along the wall over the whole height, so they must pass beside the board."""
    radius = spec.closure.boss_radius_mm
    outline = board_outline_mm(board) + corner
    low, high = outline.min(axis=0), outline.max(axis=0)
    for place in pins:
        gap = float(np.linalg.norm(np.maximum(0.0, np.maximum(low - place, place - high)))) - radius
        if gap < spec.board.clearance_mm:
            raise GeometryError(
                f"The boss of a closure pin at ({place[0]:.1f}, {place[1]:.1f}) mm comes within {gap:.2f} "
                "mm of the board; turn closure.angle_deg, use thinner pins or a larger diameter."
            )


def _bosses(
    spec: ImuHousingSpec,
    body: Body,
    frame: RestFrame,
    holes: tuple[Place, ...],
    seat: float,
    pins: tuple[Place, ...],
) -> tuple[Cylinder, ...]:
    # Bosses start outside the body; only what lies in the cavity counts.
    far = 1.5 * body.radius_mm
    standoffs = [
        Cylinder(as_vector(frame.point(*place, -far)), frame.up, 0.5 * spec.standoffs.diameter_mm, seat + far)
        for place in holes
    ]
    radius = spec.closure.boss_radius_mm
    columns = [Cylinder(as_vector(frame.point(*place, -far)), frame.up, radius, 2.0 * far) for place in pins]
    return (*standoffs, *columns)


def _holes(
    spec: ImuHousingSpec,
    frame: RestFrame,
    holes: tuple[Place, ...],
    seat: float,
    pins: tuple[Place, ...],
    seam: float,
    insert: Insert,
) -> tuple[Cylinder, ...]:
    depth = insert.hole_depth_mm
    for_inserts = [
        Cylinder(as_vector(frame.point(*place, seat - depth)), frame.up, 0.5 * insert.hole_diameter_mm, depth)
        for place in holes
    ]
    half = spec.closure.half_hole_mm
    for_pins = [
        Cylinder(
            as_vector(frame.point(*place, seam - half)), frame.up, 0.5 * spec.closure.diameter_mm, 2.0 * half
        )
        for place in pins
    ]
    return (*for_inserts, *for_pins)
