"""An opening in its place, judged on its true rim about the centre of mass (COM) of the finished product."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, unit
from gomboc_cad.body.support import touching_directions
from gomboc_cad.equilibria import find_equilibria
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.equilibria.rim import (
    RimRest,
    hole_rims_mm,
    inside,
    least_slope_mm,
    mouths_mm,
    rim_clearance_mm,
    rim_rest,
)
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.openings.cylinder_gaps import gaps_mm
from gomboc_cad.products.placement import Parting, RestFrame
from gomboc_cad.solid.hollow import Cylinder

State = Literal["allowed", "rest", "plugged", "forced"]

OVERRUN_SHARE = 1e-2
"""How far a tool reaches out of the body, in units of R₀."""

_BISECTION = 2e-3
_LARGEST_SHARE = 0.5
"""Largest hole looked for, in units of the smaller radius of curvature."""


@dataclass(frozen=True)
class PlacedOpening:
    """A hole in its place.

    Attributes:
        name: Its name.
        tool: What is taken away; its base is the inner end, its other end is just outside the body.
        rim_radius_mm: Radius of the circle around the rim, seen along the normal: that of the hole where
            it is drilled along the normal, more where it is oblique.
        allowed_radius_mm: The same for the largest hole along this axis that is no rest; None at the rest.
        direction: Outward normal at the middle of the mouth.
        position_mm: Middle of the mouth.
        state: `allowed` by the drill map, the `rest` itself, `plugged` flush, or `forced`: it is a rest
            besides the body's own.
        com_clearance_mm: How far the COM may move before a second rest appears in the hole or, at the
            rest, beside it; None for a plugged one.
        sentence: What a user should know about it; all of a group have the same.
        group: What it is one of many of, such as the dots of a mark.
        shift_mm: How a step or a gap of the seam displaces it; its place is given without that.
    """

    name: str
    tool: Cylinder
    rim_radius_mm: float
    allowed_radius_mm: float | None
    direction: Vector
    position_mm: Vector
    state: State
    com_clearance_mm: float | None
    sentence: str
    group: str | None = None
    shift_mm: Vector = (0.0, 0.0, 0.0)


def judged_opening(
    body: Body,
    com_mm: Sequence[float] | Array,
    name: str,
    tool: Cylinder,
    *,
    frame: RestFrame,
    plug: bool = False,
) -> PlacedOpening:
    """Judge a hole where it is, whatever its axis.

    Args:
        body: A strictly convex body.
        com_mm: Centre of mass of the finished product.
        name: Name of the opening.
        tool: The hole; its base inside the body, its axis outwards. It is cut off just outside the body.
        frame: Frame of the resting pose, in which places are named.
        plug: Whether it is closed flush.

    Raises:
        GeometryError: If the hole does not start inside the body, or only grazes it.
    """
    com = np.asarray(com_mm, dtype=float)
    hole = _Hole.of(body, name, tool)
    rest = rim_rest(hole.rim_mm, com)
    replaces_rest = rest is not None and hole.holds(body, find_equilibria(body, com)[0].direction)
    slope = least_slope_mm(body, hole.mouth_mm, hole.axis, tool.radius_mm, com)
    clearance = slope if replaces_rest else rim_clearance_mm(hole.rim_mm, com)
    allowed = None if replaces_rest else hole.allowed_radius_mm(body, com)
    state: State = "rest" if replaces_rest else "allowed" if rest is None else "forced"
    sentence = f"{name} at {frame_place(frame, hole.mouth_mm)} "
    if plug:
        state = "plugged"
        sentence += f"is closed flush; a joint around it up to {2.0 * slope:.3g} mm wide adds no rest."
    else:
        at_rest = hole.holds(body, as_vector(-np.array(frame.up)))
        sentence += _said_of_open(hole.circumscribed_mm(hole.rim_mm), allowed, clearance, rest, at_rest)
    return PlacedOpening(
        name=name,
        tool=hole.trimmed(body),
        rim_radius_mm=hole.circumscribed_mm(hole.rim_mm),
        allowed_radius_mm=allowed,
        direction=as_vector(hole.normal),
        position_mm=as_vector(hole.mouth_mm),
        state=state,
        com_clearance_mm=None if plug else clearance,
        sentence=sentence,
    )


def _said_of_open(
    radius: float, allowed: float | None, clearance: float, rest: RimRest | None, at_rest: bool
) -> str:
    """The end of the sentence about an opening that is not plugged."""
    if allowed is None:
        return (
            "is the rest itself: the product stands on its rim, and nowhere else as long as the centre of "
            f"mass is off by less than {1e3 * clearance:.3g} µm."
        )
    sizes = f"has a rim of radius {radius:.3g} mm where {allowed:.3g} mm is allowed"
    if rest is None:
        return f"{sizes}; it adds no rest until the centre of mass is off by {clearance:.3g} mm."
    barrier = f"with a barrier of {1e3 * rest.barrier_mm:.3g} µm"
    if at_rest:
        return (
            f"does not hold the rest about this centre of mass: the product rests on its rim, {barrier}, and "
            "beside it; bring the centre of mass nearer to the vertical through it, or make it wider."
        )
    return f"{sizes}: the product also rests on that rim, {barrier}; move it, make it smaller or plug it."


def displaced(openings: Sequence[PlacedOpening], parting: Parting) -> tuple[PlacedOpening, ...]:
    """Openings of a product whose upper part sits where the seam's step and gap have put it."""
    places = np.array([opening.position_mm for opening in openings]).reshape(-1, 3)
    return tuple(
        replace(opening, shift_mm=parting.shift_mm) if above else opening
        for opening, above in zip(openings, parting.above(places), strict=True)
    )


def require_apart(opening: PlacedOpening, others: Sequence[PlacedOpening], wall_mm: float) -> None:
    """Refuse an opening that leaves less than a wall of material to another one.

    Raises:
        GeometryError: If two openings meet.
    """
    for other in others:
        gap = gap_mm(opening, other.tool)
        if gap < wall_mm:
            raise GeometryError(
                f"{opening.name} and {other.name} meet: {max(0.0, gap):.3g} mm of material is left between "
                f"them and {wall_mm:.3g} mm is needed; move one of them or make it smaller."
            )


def gap_mm(opening: PlacedOpening, tool: Cylinder) -> float:
    """Material between an opening and a cylinder, negative where they meet."""
    base, mouth = np.array([opening.tool.base_mm]), np.array([opening.position_mm])
    return float(gaps_mm(base, mouth, opening.tool.radius_mm, tool)[0])


def frame_place(frame: RestFrame, position_mm: Array) -> str:
    """Name a place by its height over the body's origin and its angle about the vertical."""
    first, second, up = frame.matrix() @ position_mm
    across = math.hypot(first, second)
    if across <= 1e-6 * abs(up):
        return f"height {up:+.3g} mm on the vertical"
    angle = math.degrees(math.atan2(second, first))
    return f"height {up:+.3g} mm, {across:.3g} mm from the vertical at {angle:.0f}°"


def openings_document(openings: Sequence[PlacedOpening]) -> list[dict[str, Any]]:
    """Openings for JSON; a group is one entry, that of the member that allows the COM the least."""
    groups: dict[str, list[PlacedOpening]] = {}
    for opening in openings:
        groups.setdefault(opening.group or opening.name, []).append(opening)
    return [_entry(name, members) for name, members in groups.items()]


def _entry(name: str, members: Sequence[PlacedOpening]) -> dict[str, Any]:
    worst = min(members, key=lambda m: math.inf if m.com_clearance_mm is None else m.com_clearance_mm)
    return {
        "name": name,
        "count": len(members),
        "state": worst.state,
        "direction": list(worst.direction),
        "position_mm": list(worst.position_mm),
        "rim_radius_mm": worst.rim_radius_mm,
        "allowed_radius_mm": worst.allowed_radius_mm,
        "com_clearance_mm": worst.com_clearance_mm,
        "sentence": worst.sentence,
    }


@dataclass(frozen=True, eq=False)
class _Hole:
    """A hole with the middle of its mouth, the outward normal there, and its rim (k, 3)."""

    tool: Cylinder
    mouth_mm: Array
    normal: Array
    rim_mm: Array

    @classmethod
    def of(cls, body: Body, name: str, tool: Cylinder) -> _Hole:
        base, axis = np.array([tool.base_mm]), np.array([tool.direction])
        if not inside(body, base)[0]:
            raise GeometryError(
                f"{name} has its inner end outside the body; make it deeper or move it inwards."
            )
        mouth = mouths_mm(body, base, axis)
        rim = hole_rims_mm(body, mouth, axis, np.array([tool.radius_mm]))[0]
        return cls(tool, mouth[0], body.normal(unit(mouth))[0], rim)

    @property
    def axis(self) -> Array:
        """Unit vector outwards, shape (3,)."""
        return np.array(self.tool.direction)

    def circumscribed_mm(self, rim_mm: Array) -> float:
        """Radius of the circle around a rim, seen along the normal."""
        arm = rim_mm - self.mouth_mm
        return float(np.linalg.norm(arm - np.outer(arm @ self.normal, self.normal), axis=1).max())

    def holds(self, body: Body, direction: Vector) -> bool:
        """Whether the surface point with that outward normal lies in the mouth."""
        arm = body.position_mm(touching_directions(body, np.array([direction])))[0] - self.mouth_mm
        beside = np.linalg.norm(arm - (arm @ self.axis) * self.axis)
        return bool(beside < self.tool.radius_mm and np.dot(direction, self.normal) > 0.0)

    def allowed_radius_mm(self, body: Body, com: Array) -> float:
        """Circumscribed radius of the largest hole along this axis whose rim has no rest."""

        def rim(radius: float) -> Array:
            return hole_rims_mm(body, self.mouth_mm[None], self.axis[None], np.array([radius]))[0]

        def harmless(radius: float) -> bool:
            try:
                return rim_rest(rim(radius), com) is None
            except GeometryError:
                # It would only graze the body.
                return False

        own = self.tool.radius_mm
        low, high = 0.0, own
        if harmless(own):
            curvature = body.surface(unit(self.mouth_mm[None])).principal_curvatures_per_mm()[0, 0]
            low, high = own, max(_LARGEST_SHARE / float(curvature), 2.0 * own)
            if harmless(high):
                low = high
        while high - low > _BISECTION * high and high > 1e-6 * body.radius_mm:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if harmless(middle) else (low, middle)
        return self.circumscribed_mm(rim(low)) if low > 0.0 else 0.0

    def trimmed(self, body: Body) -> Cylinder:
        """The tool, ending just outside the body."""
        reach = (np.vstack([self.rim_mm, self.mouth_mm]) - np.array(self.tool.base_mm)) @ self.axis
        length = float(reach.max()) + OVERRUN_SHARE * body.radius_mm
        return Cylinder(self.tool.base_mm, as_vector(self.axis), self.tool.radius_mm, length)
