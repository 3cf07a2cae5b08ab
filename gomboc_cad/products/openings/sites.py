"""Places for openings: where they cannot become a rest, at the rest itself, where a user wants them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, BoolArray, fibonacci_directions, tangent_frame
from gomboc_cad.body.support import support_about, touching_directions
from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.equilibria.rim import hole_rims_mm, inside, mouths_mm, rim_clearance_mm
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.common_spec import Direction
from gomboc_cad.products.openings.cylinder_gaps import gaps_mm
from gomboc_cad.products.openings.placed_opening import (
    PlacedOpening,
    State,
    gap_mm,
    judged_opening,
    openings_document,
    require_apart,
)
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.solid.hollow import Cylinder

__all__ = [
    "OpeningRequest",
    "PlacedOpening",
    "Side",
    "State",
    "judged_opening",
    "openings_document",
    "place_around",
    "place_openings",
    "require_apart",
]

Side = Literal["lower", "upper", "any"]

SIDE_NAMES = {"lower": "the lower side", "upper": "the upper side", "any": "the whole surface"}

_SITES = 4000
_TRIED = 24
"""Of all sites, those with the largest |∇h| whose true rims are tried."""

_NEARBY, _NEARBY_ANGLE = 200, 0.06
_START_ANGLES = 90


@dataclass(frozen=True)
class OpeningRequest:
    """A hole that is wanted somewhere in the outer surface, along its normal.

    Attributes:
        name: Name, as in `the filling port`.
        radius_mm: Radius where it meets the surface, with any counterbore.
        depth_mm: Depth under the surface at its middle.
        direction: Where: `auto` by the drill map, at the `rest`, or the outward normal of a place.
        side: Half of the body for `auto`, seen from the seam or, without one, from the body's origin.
        plug: Whether it is closed by a plug whose outer face is the body's own surface.
    """

    name: str
    radius_mm: float
    depth_mm: float
    direction: Direction = "auto"
    side: Side = "any"
    plug: bool = False


def place_openings(
    body: Body,
    com_mm: Sequence[float] | Array,
    requests: Sequence[OpeningRequest],
    *,
    frame: RestFrame,
    wall_mm: float,
    seam_height_mm: float | None = None,
    keep_out: Sequence[Cylinder] = (),
    others: Sequence[PlacedOpening] = (),
) -> tuple[PlacedOpening, ...]:
    """Place openings: first those whose place is given, then the others, the widest first.

    Args:
        body: A strictly convex body.
        com_mm: Centre of mass of the finished product.
        requests: What is wanted.
        frame: Frame of the resting pose.
        wall_mm: Least material between an opening and another one, the seam, or what it must keep clear of.
        seam_height_mm: Height of the seam over the body's origin, if there is one.
        keep_out: Bosses and other cylinders that openings must stay clear of.
        others: Openings that are there already.

    Returns:
        The openings in the order of the requests.

    Raises:
        GeometryError: If an opening meets another one, the seam or a boss, or has no place.
    """
    ground = _Ground(body, np.asarray(com_mm, dtype=float), frame, wall_mm, seam_height_mm, tuple(keep_out))
    placed: dict[int, PlacedOpening] = {}
    # Of those without a place the widest first, as there are the fewest places for it.
    order = sorted(
        range(len(requests)), key=lambda i: (requests[i].direction == "auto", -requests[i].radius_mm)
    )
    for index in order:
        request, before = requests[index], (*others, *placed.values())
        normal = (
            ground.best_normal(request, before) if request.direction == "auto" else ground.normal(request)
        )
        tool = ground.tool(request, normal)
        opening = judged_opening(body, com_mm, request.name, tool, frame=frame, plug=request.plug)
        ground.require_clear(opening)
        require_apart(opening, before, wall_mm)
        placed[index] = opening
    return tuple(placed[index] for index in range(len(requests)))


def place_around(
    body: Body,
    com_mm: Sequence[float] | Array,
    name: str,
    count: int,
    *,
    radius_mm: float,
    from_axis_mm: float,
    base_height_mm: float,
    outwards: Literal["up", "down"],
    frame: RestFrame,
    wall_mm: float,
    keep_out: Sequence[Cylinder] = (),
    others: Sequence[PlacedOpening] = (),
    first_angle_deg: float | None = None,
    plug: bool = False,
) -> tuple[PlacedOpening, ...]:
    """Place equal vertical holes evenly around the vertical through the body's origin, as for screws.

    Args:
        body: A strictly convex body.
        com_mm: Centre of mass of the finished product.
        name: Their name; a number is added.
        count: How many.
        radius_mm: Radius of each.
        from_axis_mm: Distance of their axes from the vertical.
        base_height_mm: Height of their inner ends over the body's origin.
        outwards: The way they leave the body.
        frame: Frame of the resting pose.
        wall_mm: Least material between them and everything that they must keep clear of.
        keep_out: Cylinders that they must stay clear of.
        others: Openings that are there already.
        first_angle_deg: Angle of the first one about the vertical; the one with the largest least clearance
            of the COM if it is not given.
        plug: Whether they are closed flush.

    Raises:
        GeometryError: If there is no room for them, or no starting angle at which none is a rest.
    """
    circle = _Circle(body, frame, count, radius_mm, from_axis_mm, base_height_mm, outwards)
    if first_angle_deg is None:
        tools = (*keep_out, *(other.tool for other in others))
        start = circle.best_start(name, np.asarray(com_mm, dtype=float), tools, wall_mm, plug)
    else:
        start = math.radians(first_angle_deg)
    placed: list[PlacedOpening] = []
    for number, tool in enumerate(circle.tools(name, start), start=1):
        opening = judged_opening(body, com_mm, f"{name} {number}", tool, frame=frame, plug=plug)
        require_apart(opening, (*others, *placed), wall_mm)
        placed.append(opening)
    return tuple(placed)


def cap_directions(middle: Array, angle_rad: float, count: int) -> Array:
    """Directions spread evenly over the cap around one, shape (count, 3)."""
    height = 1.0 - (1.0 - math.cos(angle_rad)) * (np.arange(count) + 0.5) / count
    turn = np.pi * (1.0 + math.sqrt(5.0)) * np.arange(count)
    across = np.sqrt(1.0 - height**2)[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    result: Array = across @ np.concatenate(tangent_frame(middle[None])) + height[:, None] * middle
    return result


@dataclass(frozen=True, eq=False)
class _Ground:
    """Where openings may go."""

    body: Body
    com_mm: Array
    frame: RestFrame
    wall_mm: float
    seam_height_mm: float | None
    keep_out: tuple[Cylinder, ...]

    def normal(self, request: OpeningRequest) -> Array:
        """The outward normal that a request names.

        Raises:
            GeometryError: If it has no length.
        """
        given = -np.array(self.frame.up) if request.direction == "rest" else np.array(request.direction)
        length = float(np.linalg.norm(given))
        if not length > 0.0:
            raise GeometryError(f"The direction of {request.name} has no length; give an outward normal.")
        result: Array = given / length
        return result

    def tool(self, request: OpeningRequest, normal: Array) -> Cylinder:
        """The hole along a normal, running on outside."""
        mouth = self.body.position_mm(touching_directions(self.body, normal[None]))[0]
        length = request.depth_mm + self.body.radius_mm
        return Cylinder(
            as_vector(mouth - request.depth_mm * normal), as_vector(normal), request.radius_mm, length
        )

    def require_clear(self, opening: PlacedOpening) -> None:
        """Refuse an opening too near to the seam or to a boss.

        Raises:
            GeometryError: If it is.
        """
        if self.seam_height_mm is not None:
            above = float(np.dot(opening.position_mm, self.frame.up)) - self.seam_height_mm
            if abs(above) < opening.tool.radius_mm + self.wall_mm:
                raise GeometryError(
                    f"{opening.name}, {abs(above):.3g} mm from the seam with a radius of "
                    f"{opening.tool.radius_mm:.3g} mm, meets the seam; move it or split.height_mm."
                )
        for boss in self.keep_out:
            gap = gap_mm(opening, boss)
            if gap < self.wall_mm:
                raise GeometryError(
                    f"{opening.name} meets a boss: {max(0.0, gap):.3g} mm is left between them and "
                    f"{self.wall_mm:.3g} mm is needed; move one of them or make the opening smaller."
                )

    def best_normal(self, request: OpeningRequest, others: Sequence[PlacedOpening]) -> Array:
        """The free place with the largest clearance of the COM.

        Raises:
            GeometryError: If no place is free, or the best one does not allow the hole.
        """
        what = f"{request.name} of radius {request.radius_mm:.4g} mm"
        found = self._best_of(request, others, fibonacci_directions(_SITES))
        if found is None:
            raise GeometryError(
                f"There is no room for {what}: every place on {SIDE_NAMES[request.side]} is too near to the "
                "seam, a boss or another opening; make it smaller or move the others."
            )
        near = self._best_of(request, others, cap_directions(found[0], _NEARBY_ANGLE, _NEARBY))
        best, clearance = max((found, near or found), key=lambda place: place[1])
        if clearance <= 0.0 and not request.plug:
            raise GeometryError(
                f"No free place on {SIDE_NAMES[request.side]} allows {what} without adding a rest; make it "
                "smaller, plug it, or put it at the rest."
            )
        normal: Array = self.body.normal(best[None])[0]
        return normal

    def _best_of(
        self, request: OpeningRequest, others: Sequence[PlacedOpening], directions: Array
    ) -> tuple[Array, float] | None:
        """Of surface parameters (n, 3) the free one with the largest clearance, and that clearance."""
        points = self.body.surface(directions)
        slope = np.linalg.norm(support_about(points, self.com_mm)[1], axis=1)
        rows = np.flatnonzero(self._free(request, others, points.position_mm, points.normal))
        rows = rows[np.argsort(-slope[rows], kind="stable")[:_TRIED]]
        if len(rows) == 0:
            return None
        radii = np.full(len(rows), request.radius_mm)
        rims = hole_rims_mm(self.body, points.position_mm[rows], points.normal[rows], radii)
        clearances = [rim_clearance_mm(rim, self.com_mm) for rim in rims]
        best = int(np.argmax(clearances))
        return directions[rows[best]], clearances[best]

    def _free(
        self, request: OpeningRequest, others: Sequence[PlacedOpening], places: Array, normals: Array
    ) -> BoolArray:
        """Which places keep clear of the seam, the bosses and the other openings, shape (n,)."""
        free = np.ones(len(places), dtype=bool)
        above = places @ np.array(self.frame.up) - (self.seam_height_mm or 0.0)
        if self.seam_height_mm is not None:
            free &= np.abs(above) >= request.radius_mm + self.wall_mm
        if request.side != "any":
            free &= (above > 0.0) == (request.side == "upper")
        bases = places - request.depth_mm * normals
        for tool in (*self.keep_out, *(other.tool for other in others)):
            free &= gaps_mm(bases, places, request.radius_mm, tool) >= self.wall_mm
        return free


@dataclass(frozen=True)
class _Circle:
    """Equal vertical holes on a circle about the vertical."""

    body: Body
    frame: RestFrame
    count: int
    radius_mm: float
    from_axis_mm: float
    base_height_mm: float
    outwards: Literal["up", "down"]

    @property
    def axis(self) -> Array:
        """Unit vector out of the body."""
        return np.array(self.frame.up) * (1.0 if self.outwards == "up" else -1.0)

    def bases_mm(self, starts: Array) -> Array:
        """Inner ends for starting angles (n,), shape (n, count, 3)."""
        angles = starts[:, None] + 2.0 * np.pi * np.arange(self.count) / self.count
        across = self.from_axis_mm * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        heights = np.full((*angles.shape, 1), self.base_height_mm)
        result: Array = np.concatenate([across, heights], axis=-1) @ self.frame.matrix()
        return result

    def tools(self, name: str, start: float) -> list[Cylinder]:
        """The holes from a starting angle, running on outside."""
        bases = self.bases_mm(np.array([start]))[0]
        self._require_inside(name, bases)
        length = 4.0 * self.body.radius_mm
        return [Cylinder(as_vector(base), as_vector(self.axis), self.radius_mm, length) for base in bases]

    def best_start(
        self, name: str, com: Array, tools: Sequence[Cylinder], wall_mm: float, plug: bool
    ) -> float:
        """The starting angle with the largest least clearance of the COM among those with room.

        Raises:
            GeometryError: If there is none.
        """
        starts = 2.0 * np.pi * np.arange(_START_ANGLES) / (_START_ANGLES * self.count)
        bases = self.bases_mm(starts).reshape(-1, 3)
        self._require_inside(name, bases)
        axes = np.tile(self.axis, (len(bases), 1))
        mouths = mouths_mm(self.body, bases, axes)
        free = np.ones(len(bases), dtype=bool)
        for tool in tools:
            free &= gaps_mm(bases, mouths, self.radius_mm, tool) >= wall_mm
        room = free.reshape(-1, self.count).all(axis=1)
        what = f"{self.count} x {name}, {self.from_axis_mm:.4g} mm from the vertical,"
        if not room.any():
            raise GeometryError(
                f"{what} meet something else at every angle; use fewer or smaller ones, or another distance."
            )
        rims = hole_rims_mm(self.body, mouths, axes, np.full(len(bases), self.radius_mm))
        each = np.array([rim_clearance_mm(rim, com) for rim in rims])
        clearance = np.where(room, each.reshape(-1, self.count).min(axis=1), -1.0)
        if clearance.max() <= 0.0 and not plug:
            raise GeometryError(
                f"{what} with a radius of {self.radius_mm:.4g} mm add a rest at every angle; make them "
                "smaller, change their number or distance, or plug them."
            )
        return float(starts[clearance.argmax()])

    def _require_inside(self, name: str, bases: Array) -> None:
        if not inside(self.body, bases).all():
            raise GeometryError(
                f"{name} cannot start {self.from_axis_mm:.4g} mm from the vertical at a height of "
                f"{self.base_height_mm:.4g} mm: that is not inside the body; move it inwards."
            )
