"""The rim of a hole: what a body stands on where it has been drilled.

The hull of a drilled convex body is that of its surface without the mouths of the holes. Over a mouth it
is the outer side of the hull of the rim: flat facets and ruled strips. The body rests there exactly when
the foot of the perpendicular from the centre of mass (COM) on one of these facets lies inside it. So the
COM must move by the distance of the nearest foot from its facet before a hole becomes a rest. Nothing is
assumed of the curvature or of the size of the hole.

A hole that holds the body's own rest replaces it by one on its rim. The body rests beside the hole as well
as soon as its own rest, moving with the COM, leaves the mouth. The COM then crosses the normal of the
surface at a point of the rim, whose distance is `|∇h|` there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize.elementwise import find_minimum, find_root
from scipy.spatial import ConvexHull

from gomboc_cad.body.sphere import Array, BoolArray, geodesic_triangulation, tangent_frame, unit
from gomboc_cad.body.support import support_about
from gomboc_cad.body.surface import Body
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import GeometryError

RIM_POINTS = 60
_SLOPE_POINTS = 360
_NEWTON_STEPS = 40
_ON_SURFACE = 1e-12
"""Distance from the surface, in units of R₀, at which a point of a rim lies on it."""


@dataclass(frozen=True)
class RimRest:
    """A rest on the rim of a hole.

    Attributes:
        direction: Body direction that points down.
        height_mm: Height of the COM over the table.
        barrier_mm: How far the COM has to rise to roll over the nearest place of the rim; where the body's
            own slope goes on rising beyond it, the barrier is higher.
    """

    direction: Vector
    height_mm: float
    barrier_mm: float


def hole_rims_mm(
    body: Body, places_mm: Array, axes: Array, radii_mm: Array, count: int = RIM_POINTS
) -> Array:
    """Curves in which cylinders meet the surface of a convex body.

    Args:
        body: The body.
        places_mm: Points of the axes, on the surface or near it, shape (n, 3).
        axes: Unit vectors out of the body along the axes, oblique to the surface or not, shape (n, 3).
        radii_mm: Radii of the cylinders, shape (n,).
        count: Points per rim.

    Returns:
        Points around each rim, shape (n, count, 3).

    Raises:
        GeometryError: If a cylinder only grazes the body, so that its rim is no closed curve around the axis.
    """
    angles = 2.0 * np.pi * np.arange(count) / count
    return _rims_at_mm(body, places_mm, axes, radii_mm, angles)


def least_slope_mm(body: Body, place_mm: Array, axis: Array, radius_mm: float, com_mm: Array) -> float:
    """Least |∇h| on the rim of one hole: how far the COM may move before the body's own rest is on the rim.

    It is sought between sampled angles, because |∇h| has narrow valleys where the curvatures differ.

    Args:
        body: The body.
        place_mm: A point of the axis, shape (3,).
        axis: Unit vector along it, out of the body, shape (3,).
        radius_mm: Radius of the hole.
        com_mm: The COM, shape (3,).
    """

    def slope(angles: NDArray[Any]) -> Array:
        rim = _rims_at_mm(body, place_mm[None], axis[None], np.array([radius_mm]), np.ravel(angles))[0]
        foot: Array = np.linalg.norm(support_about(body.surface(unit(rim)), com_mm)[1], axis=1)
        return foot.reshape(np.shape(angles))

    step = 2.0 * np.pi / _SLOPE_POINTS
    angles = step * np.arange(_SLOPE_POINTS)
    values = slope(angles)
    lows = angles[(values <= np.roll(values, 1)) & (values <= np.roll(values, -1))]
    found = find_minimum(slope, (lows - step, lows, lows + step))
    return float(min(values.min(), found.f_x.min(initial=np.inf)))


def _rims_at_mm(body: Body, places_mm: Array, axes: Array, radii_mm: Array, angles: Array) -> Array:
    """Points of rims at given angles (k,) around their axes, shape (n, k, 3)."""
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=-1) @ np.stack(tangent_frame(axes), axis=1)
    start = places_mm[:, None] + radii_mm[:, None, None] * circle
    axis, rim = np.repeat(axes, len(angles), axis=0), start.reshape(-1, 3)
    for _ in range(_NEWTON_STEPS):
        surface = body.surface(unit(rim))
        gap = np.einsum("nx,nx->n", rim - surface.position_mm, surface.normal)
        slant = np.einsum("nx,nx->n", axis, surface.normal)
        if np.any(slant <= 0.0):
            break
        rim = rim - (gap / slant)[:, None] * axis
        if np.abs(gap).max(initial=0.0) < _ON_SURFACE * body.radius_mm:
            found: Array = rim.reshape(start.shape)
            return found
    raise GeometryError(
        f"A hole of radius {radii_mm.max():.3g} mm would only graze the surface of the body; make it "
        "smaller, steeper, or move it farther inside."
    )


def mouths_mm(body: Body, origins_mm: Array, directions: Array) -> Array:
    """Where rays from inner points (n, 3) along unit vectors (n, 3) leave a convex body, shape (n, 3)."""
    length = ray_lengths_mm(body, origins_mm, directions)
    result: Array = origins_mm + length[:, None] * directions
    return result


def ray_lengths_mm(body: Body, origins_mm: Array, directions: Array) -> Array:
    """Length of rays from inner points (n, 3) along unit vectors (n, 3) inside a convex body, shape (n,)."""

    def beyond_surface(length: Array, x: Array, y: Array, z: Array, a: Array, b: Array, c: Array) -> Array:
        place = np.stack([x, y, z], axis=-1) + length[:, None] * np.stack([a, b, c], axis=-1)
        reach = np.linalg.norm(place, axis=1)
        result: Array = reach - body.radius_at(place / reach[:, None])
        return result

    origins = np.broadcast_to(origins_mm, directions.shape)
    # Not from the body's origin itself, which has no direction.
    start = np.full(len(directions), _ON_SURFACE * body.radius_mm)
    far = np.full(len(directions), 4.0 * float(body.radius_at(geodesic_triangulation(3)[0]).max()))
    result: Array = find_root(beyond_surface, (start, far), args=(*origins.T, *directions.T)).x
    return result


def inside(body: Body, points_mm: Array) -> BoolArray:
    """Whether points (n, 3) lie inside a body, shape (n,)."""
    reach = np.linalg.norm(points_mm, axis=1)
    # Any direction will do for the body's origin.
    directions = np.where(reach[:, None] > 0.0, points_mm, [[0.0, 0.0, 1.0]])
    result: BoolArray = reach < body.radius_at(unit(directions))
    return result


def rim_rest(rim_mm: Array, com_mm: Array) -> RimRest | None:
    """The lowest rest on a rim, shape (k, 3), about a COM, shape (3,), or None if there is none."""
    facets = _outer_facets(rim_mm - com_mm)
    inside = np.flatnonzero(facets.hold_foot())
    if len(inside) == 0:
        return None
    lowest = inside[facets.heights[inside].argmin()]
    height = float(facets.heights[lowest])
    nearest = float(np.linalg.norm(rim_mm - com_mm, axis=1).min())
    return RimRest(as_vector(facets.normals[lowest]), height, max(0.0, nearest - height))


def rim_clearance_mm(rim_mm: Array, com_mm: Array) -> float:
    """How far a COM, shape (3,), may move before a rim, shape (k, 3), has a rest; 0 if it has one."""
    facets = _outer_facets(rim_mm - com_mm)
    if np.any(facets.hold_foot()):
        return 0.0
    start, edge = facets.corners, np.roll(facets.corners, -1, axis=1) - facets.corners
    share = -np.einsum("nax,nax->na", start, edge) / np.einsum("nax,nax->na", edge, edge)
    nearest = start + np.clip(share, 0.0, 1.0)[:, :, None] * edge
    return float(np.linalg.norm(nearest, axis=2).min())


class _Facets(NamedTuple):
    """Outer facets of the hull of a rim.

    Attributes:
        normals: Outward unit normals, shape (m, 3).
        heights: Distances of their planes from the COM, shape (m,).
        corners: Corners as seen from the feet of the perpendiculars from the COM, shape (m, 3, 3).
    """

    normals: Array
    heights: Array
    corners: Array

    def hold_foot(self) -> BoolArray:
        """Whether each facet holds the foot of the perpendicular from the COM, shape (m,)."""
        sides = np.cross(self.corners, np.roll(self.corners, -1, axis=1))
        turns = np.einsum("nax,nx->na", sides, self.normals)
        result: BoolArray = np.all(turns >= 0.0, axis=1) | np.all(turns <= 0.0, axis=1)
        return result


def _outer_facets(rim: Array) -> _Facets:
    """The facets of the hull of a rim (k, 3) and the origin that do not touch the origin."""
    hull = ConvexHull(np.vstack([rim, np.zeros(3)]))
    outer = np.all(hull.simplices < len(rim), axis=1)
    normals, heights = hull.equations[outer, :3], -hull.equations[outer, 3]
    return _Facets(normals, heights, rim[hull.simplices[outer]] - (heights[:, None] * normals)[:, None])
