"""Points of a part as made, as dense as a census of their convex hull needs them.

A triangle of points bounds the hull from inside, so what it misses is at most its sag s, and the facets of
the hull over it reach no farther than the cap that a plane cuts off at the depth s: in the metric of the
curvature, `|y|² = yᵀ A y`, A the shape operator, a disc of radius sqrt(2 s). The points can make a rest, a
saddle or a top only where the foot of the perpendicular from the COM comes into that cap. So only those
triangles are split, until their sag is small enough; elsewhere neither the part nor the hull of the points,
nor any function between the two heights, has an equilibrium. On the way from one to the other each birth and
death of a basin then moves by no more than the largest sag of the triangles that were split to the end,
which bounds the error of every barrier.

Over a step of the surface the part also rests on strips that bridge it. Their ruling lines are conjugate to
the step, which is square to it in that metric.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from gomboc_cad.body.sphere import Array, BoolArray, IntArray, geodesic_triangulation, subdivide
from gomboc_cad.errors import CensusError
from gomboc_cad.tolerance.geometry import MadePart, PartPoints

MAX_POINTS = 100_000
CURVATURE_SAFETY = 1.1
"""The metric of a triangle is that of its corners, which changes a little over it."""

_SAG_SAFETY = 1.25
"""The sag of a triangle is told from its corners; a third derivative of the surface adds to it."""

_START_LEVEL = 5
_FLATTEST = 1e-9
"""Smallest curvature that is told from none, over the largest at the same place."""

_FOLDED = -1e-12
"""Turn of the normals against the displacement, over the square of the size, that is no rounding."""

_TINY = float(np.finfo(float).tiny)


class SampledPart(NamedTuple):
    """Points of a part whose convex hull stands for it.

    Attributes:
        part: The part; `dented` where it is no convex solid.
        surface: Points of the smooth surface.
        points_mm: All points, shape (n, 3): of the surface, of the rims of seam and holes, of layers.
        sag_mm: What the hull of the points may falsify the barrier of an equilibrium by.
        mouths_mm: The rim of each hole, shapes (k, 3); none of a part in layers.
    """

    part: MadePart
    surface: PartPoints
    points_mm: Array
    sag_mm: float
    mouths_mm: tuple[Array, ...] = ()


class Patches(NamedTuple):
    """Flat triangles seen in the metric of curvature: a point is y, a cap of depth s is |y|² ≤ 2 s.

    Attributes:
        triangles: Indices of their corners, shape (m, 3).
        sag_mm: What each may miss of the surface, shape (m,).
        feet: Feet of the COM in the plane, at the corners, shape (m, 3, 2), in sqrt(mm).
        to_metric: Takes coordinates along two sides to y, shape (m, 2, 2).
    """

    triangles: IntArray
    sag_mm: Array
    feet: Array
    to_metric: Array

    @property
    def cap(self) -> Array:
        """How far facets of the hull may reach over each triangle, shape (m,)."""
        return np.sqrt(2.0 * self.sag_mm)

    @property
    def imbalance(self) -> Array:
        """Distance of the feet over each triangle from the origin; 0 where it balances, shape (m,)."""
        sides = np.roll(self.feet, -1, axis=1) - self.feet
        square = np.einsum("mkx,mkx->mk", sides, sides)
        share = -np.einsum("mkx,mkx->mk", self.feet, sides) / np.maximum(square, _TINY)
        nearest = self.feet + np.clip(share, 0.0, 1.0)[:, :, None] * sides
        around = self.feet[:, :, 0] * sides[:, :, 1] - self.feet[:, :, 1] * sides[:, :, 0]
        inside = np.all(around >= 0.0, axis=1) | np.all(around <= 0.0, axis=1)
        distance = np.sqrt(np.einsum("mkx,mkx->mk", nearest, nearest).min(axis=1))
        return np.where(inside, 0.0, distance)


class Ruling(NamedTuple):
    """Directions in which strips bridge the steps of a surface, which follow the contour lines of a height.

    Attributes:
        steepness: Climb of the height along the ruling lines, shape (m,).
        direction: Unit vectors along them, shape (m, 2).
    """

    steepness: Array
    direction: Array

    @classmethod
    def across(cls, patches: Patches, height_mm: Array) -> Ruling:
        """Ruling lines for a height at the corners of the triangles, shape (m, 3)."""
        climb = height_mm[:, 1:] - height_mm[:, :1]
        gradient = np.linalg.solve(patches.to_metric.transpose(0, 2, 1), climb[:, :, None])[:, :, 0]
        steepness = np.sqrt(np.einsum("ma,ma->m", gradient, gradient))
        return cls(steepness, gradient / np.maximum(steepness, _TINY)[:, None])

    def distance(self, patches: Patches, half_length: Array | float) -> Array:
        """Distance of the feet from strips to both sides of the triangles along the ruling lines, (m,)."""
        along = np.einsum("mka,ma->mk", patches.feet, self.direction)
        across = patches.feet[:, :, 0] * self.direction[:, 1:] - patches.feet[:, :, 1] * self.direction[:, :1]
        beyond = np.maximum(_distance_from_zero(along) - half_length, 0.0)
        result: Array = np.hypot(beyond, _distance_from_zero(across))
        return result


class Refined(NamedTuple):
    """Triangles of a part's surface, fine where they matter.

    Attributes:
        part: The part; `dented` where it is no convex solid.
        points: Their corners.
        fine: Triangles where the part could balance, shape (m, 3).
        coarse: The others, shape (k, 3).
        sag_mm: Largest sag of the fine ones.
    """

    part: MadePart
    points: PartPoints
    fine: IntArray
    coarse: IntArray
    sag_mm: float


def sample_part(part: MadePart, sag_mm: float, max_points: int = MAX_POINTS) -> SampledPart:
    """Choose points of a part so that their hull has a small sag wherever the part could balance.

    Args:
        part: The part.
        sag_mm: The sag.
        max_points: Where more would be needed, the sag is larger.

    Raises:
        CensusError: If the sag is not a positive length.
        GeometryError: If the parting plane or a hole does not cut the part as it should.
    """
    refined = refine(part, sag_mm, could_balance, max_points)
    part, points = refined.part, refined.points
    rims = [rim.position_mm for rim in part.rims(refined.sag_mm)]
    cloud = np.concatenate([points.position_mm[~part.in_mouth(points.part_mm)], *rims])
    return SampledPart(part, points, cloud, refined.sag_mm, tuple(rims[: len(part.holes)]))


def refine(
    part: MadePart,
    sag_mm: float,
    critical: Callable[[MadePart, PartPoints, Patches], BoolArray],
    max_points: int = MAX_POINTS,
) -> Refined:
    """Split triangles of a part until all that are critical have a small sag.

    Args:
        part: The part.
        sag_mm: The sag.
        critical: Says which triangles may hold an equilibrium. A part with dents is fine all over.
        max_points: Where more would be needed, the sag is larger.

    Raises:
        CensusError: If the sag is not a positive length.
    """
    if not 0.0 < sag_mm < np.inf:
        raise CensusError(f"The sag of a part's points must be a positive length, not {sag_mm!r}.")
    directions, triangles = geodesic_triangulation(_START_LEVEL)
    points = part.at(directions)
    if not part.dented and _folds(points, triangles):
        part = replace(part, dented=True)
        points = part.at(directions)
    fine, coarse, reached = [], [], 0.0
    while True:
        patches = _patches(points, triangles)
        chosen = np.full(len(triangles), True) if part.dented else critical(part, points, patches)
        split = chosen & (patches.sag_mm > sag_mm)
        if len(points.directions) + 2 * int(split.sum()) > max_points:
            split[:] = False
        done = chosen & ~split
        fine.append(triangles[done])
        coarse.append(triangles[~chosen])
        reached = max(reached, float(patches.sag_mm[done].max(initial=0.0)))
        if not split.any():
            return Refined(part, points, np.concatenate(fine), np.concatenate(coarse), reached)
        known = len(directions)
        directions, triangles = subdivide(directions, triangles[split])
        points = points.and_also(part.at(directions[known:]))


def could_balance(part: MadePart, points: PartPoints, patches: Patches) -> BoolArray:
    """Which triangles may hold an equilibrium of the smooth surface, or one end of a bridge over the seam."""
    critical: BoolArray = patches.imbalance <= patches.cap
    if part.has_step:
        # Where a surface falls away from a plane, a gap of d is as wide as sqrt(2 d) in the metric.
        bridge = CURVATURE_SAFETY * np.sqrt(2.0 * float(np.linalg.norm(part.upper_shift_mm)))
        height = part.seam_height_mm(points.part_mm)[patches.triangles]
        ruling = Ruling.across(patches, height)
        near = np.abs(height).min(axis=1) <= ruling.steepness * (bridge + patches.cap)
        critical |= near & (ruling.distance(patches, bridge) <= patches.cap)
    return critical


def hull_mesh(points_mm: Array) -> tuple[Array, IntArray]:
    """The convex hull of points as a closed mesh.

    Args:
        points_mm: Shape (n, 3).

    Returns:
        Vertices, shape (k, 3), and triangles, counter-clockwise seen from outside, shape (m, 3).
    """
    hull = ConvexHull(points_mm)
    used, faces = np.unique(hull.simplices, return_inverse=True)
    vertices, faces = points_mm[used], faces.reshape(-1, 3)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    inwards = np.einsum("nx,nx->n", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    return vertices, np.where(inwards[:, None], faces[:, ::-1], faces).astype(np.int64)


def _folds(points: PartPoints, triangles: IntArray) -> bool:
    """Whether normals turn against the displacement anywhere: there is no convex surface like that."""
    return bool(_turns(points, triangles).min() < _FOLDED * np.ptp(points.own_mm[:, 0]) ** 2)


def _turns(points: PartPoints, triangles: IntArray) -> Array:
    """Displacement times turn of the normal along each side, `κ l²` for a length l, shape (m, 3)."""
    corners, normals = points.own_mm[triangles], points.normal[triangles]
    sides, turns = (np.roll(array, -1, axis=1) - array for array in (corners, normals))
    result: Array = np.einsum("mkx,mkx->mk", sides, turns)
    return result


def _patches(points: PartPoints, triangles: IntArray) -> Patches:
    """Sags and metric of triangles."""
    bulges = 0.125 * np.maximum(_turns(points, triangles), 0.0)
    # Inside, the bulges of the three sides add up, to 4/9 of their sum in the middle.
    sag = _SAG_SAFETY * np.maximum(bulges.max(axis=1), 4.0 / 9.0 * bulges.sum(axis=1))
    corners, normals = points.own_mm[triangles], points.normal[triangles]
    sides, turns = corners[:, 1:] - corners[:, :1], normals[:, 1:] - normals[:, :1]
    metric = sides @ turns.transpose(0, 2, 1)
    values, axes = np.linalg.eigh(0.5 * (metric + metric.transpose(0, 2, 1)))
    # A dent has no such metric, and is not asked for it.
    values = np.maximum(values, _FLATTEST * values[:, 1:])
    to_metric = np.sqrt(np.maximum(values, _TINY))[:, :, None] * axes.transpose(0, 2, 1)
    gram = sides @ sides.transpose(0, 2, 1)
    feet = np.linalg.solve(gram, sides @ points.foot_mm[triangles].transpose(0, 2, 1))
    return Patches(triangles, sag, (to_metric @ feet).transpose(0, 2, 1), to_metric)


def _distance_from_zero(values: Array) -> Array:
    """Distance of the ranges of rows of values (m, k) from zero, shape (m,)."""
    low, high = values.min(axis=1), values.max(axis=1)
    result: Array = np.maximum(np.maximum(low, -high), 0.0)
    return result
