"""Support function of a body, and the distance of a point from its surface."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray, IntArray, geodesic_triangulation, unit
from gomboc_cad.body.surface import Body, SurfacePoints
from gomboc_cad.errors import NotConvexError

_NEWTON_STEPS = 60
_START_LEVEL = 4
_STARTS = 4
_APART = 0.1
"""Angle in radians between vertices that count as different places."""

_GRID_LOSS = 5e-3
"""How much lower than its peak the nearest vertex may be, in units of R₀."""

_CHUNK = 2048


class SupportJet(NamedTuple):
    """Support function about a centre, with derivatives on the sphere of normals.

    Attributes:
        height_mm: h(n) = max (x − c)·n, shape (n,).
        gradient_mm: ∇h as a tangent vector in space, shape (n, 3).
        hessian_mm: ∇²h in the tangent basis, shape (n, 2, 2).
        tangents: That basis as rows, shape (n, 2, 3).
        directions: The surface parameter u of the touching point, shape (n, 3).
    """

    height_mm: Array
    gradient_mm: Array
    hessian_mm: Array
    tangents: Array
    directions: Array


def support_about(points: SurfacePoints, center_mm: Array) -> tuple[Array, Array, Array]:
    """Height, gradient (in the tangent basis) and Hessian of the support function at surface points.

    With x the point and n its normal: `h = (x − c)·n`, `∇h = (x − c)_T` and
    `∇²h = W − h I`, W the inverse of the shape operator.
    """
    arm = points.position_mm - center_mm
    height = np.einsum("nx,nx->n", arm, points.normal)
    gradient = np.einsum("nax,nx->na", points.tangents, arm)
    hessian: Array = np.linalg.inv(points.shape_operator_per_mm) - height[:, None, None] * np.eye(2)
    return height, gradient, hessian


def touching_directions(body: Body, normals: Array) -> Array:
    """Find the surface parameter u at which the plane with each outward normal touches the body.

    The global maximum of `x(u)·n` is sought by a safeguarded Newton ascent from the best of 2,562
    surface points and from up to three others, apart from it and nearly as high, so the result is the
    support point of the convex hull too: over a dent two places far apart compete.

    Args:
        body: The body.
        normals: Unit vectors, shape (n, 3).
    """
    vertices = geodesic_triangulation(_START_LEVEL)[0]
    cloud = body.position_mm(vertices)
    near = vertices @ vertices.T > np.cos(_APART)
    starts = np.concatenate(
        [_highest(normals[i : i + _CHUNK] @ cloud.T, near, body) for i in range(0, len(normals), _CHUNK)]
    )
    u = _climb(body, vertices[starts[:, 0]], normals)
    height = np.einsum("nx,nx->n", body.position_mm(u), normals)
    for column in starts.T[1:]:
        rows = np.flatnonzero(column >= 0)
        rival = _climb(body, vertices[column[rows]], normals[rows])
        rival_height = np.einsum("nx,nx->n", body.position_mm(rival), normals[rows])
        better = rival_height > height[rows]
        u[rows[better]], height[rows[better]] = rival[better], rival_height[better]
    return u


def _highest(heights: Array, near: BoolArray, body: Body) -> IntArray:
    """Pick the highest vertex of each row and then the highest apart from those; −1 where too low."""
    picks = np.empty((len(heights), _STARTS), dtype=np.int64)
    rows = np.arange(len(heights))
    for k in range(_STARTS):
        picks[:, k] = heights.argmax(axis=1)
        value = heights[rows, picks[:, k]]
        if k == 0:
            floor = value - _GRID_LOSS * body.radius_mm
        picks[value < floor, k] = -1
        heights[near[picks[:, k]]] = -np.inf
    return picks


def _climb(body: Body, directions: Array, normals: Array) -> Array:
    """Newton ascent of `x(u)·n` along the surface, halved where it does not climb."""
    u = directions.copy()
    height = np.einsum("nx,nx->n", body.position_mm(u), normals)
    active = np.arange(len(u))
    for _ in range(_NEWTON_STEPS):
        points = body.surface(u[active])
        gradient = np.einsum("nax,nx->na", points.tangents, normals[active])
        slant = np.einsum("nx,nx->n", points.normal, normals[active])
        stiffness, basis = np.linalg.eigh(points.shape_operator_per_mm * slant[:, None, None])
        # Reflecting negative stiffness makes every step an ascent; the floor limits its length.
        stiffness = np.maximum(np.abs(stiffness), 0.02 / body.radius_mm)
        local = np.einsum("nab,na->nb", basis, gradient) / stiffness
        step = np.einsum("nab,nb,nax->nx", basis, local, points.tangents)
        length = np.linalg.norm(step, axis=1)
        step *= np.minimum(1.0, 0.2 * body.radius_mm / np.maximum(length, 1e-300))[:, None]
        scale = np.ones(len(active))
        for _ in range(30):
            trial = unit(points.position_mm + scale[:, None] * step)
            value = np.einsum("nx,nx->n", body.position_mm(trial), normals[active])
            worse = value < height[active] - 1e-14 * body.radius_mm
            if not worse.any():
                break
            scale[worse] *= 0.5
        u[active] = trial
        height[active] = value
        active = active[length > 1e-13 * body.radius_mm]
        if len(active) == 0:
            break
    return u


def support_jet(body: Body, normals: Array, center_mm: Array | None = None) -> SupportJet:
    """Support function with gradient and Hessian at unit normals (n, 3), about `center_mm`.

    Raises:
        NotConvexError: If the touching point has no positive curvature, where the Hessian does
            not exist.
    """
    center = np.zeros(3) if center_mm is None else np.asarray(center_mm, dtype=float)
    u = touching_directions(body, normals)
    points = body.surface(u)
    if np.any(points.principal_curvatures_per_mm()[:, 1] <= 0.0):
        raise NotConvexError(
            f"The support function of {body.name!r} has no Hessian: the body is not strictly convex."
        )
    height, gradient, hessian = support_about(points, center)
    in_space = np.einsum("na,nax->nx", gradient, points.tangents)
    return SupportJet(height, in_space, hessian, points.tangents, u)


def support_height_mm(body: Body, normals: Array) -> Array:
    """Support function h(n) of the convex hull about the origin at unit normals (n, 3)."""
    u = touching_directions(body, normals)
    result: Array = np.einsum("nx,nx->n", body.position_mm(u), normals)
    return result


def depth_mm(body: Body, points_mm: Array) -> Array:
    """Distance of inner points from the surface (negative outside), for a convex body.

    The distance is `min over n of h(n) − p·n`; it is found among the feet of perpendiculars by Newton
    iteration from the nearest of 10,242 surface points.

    Args:
        body: A strictly convex body.
        points_mm: Shape (n, 3).
    """
    points_mm = np.atleast_2d(np.asarray(points_mm, dtype=float))
    surface = _dense_surface(body)
    result = np.empty(len(points_mm))
    for index, point in enumerate(points_mm):
        gaps = np.einsum("nx,nx->n", surface.position_mm - point, surface.normal)
        nearest = np.argsort(gaps)[:8]
        result[index] = _descend_gap(body, surface.directions[nearest], point).min()
    return result


@lru_cache(maxsize=4)
def _dense_surface(body: Body) -> SurfacePoints:
    """Surface points to start from; kept, because a study asks about one body thousands of times."""
    return body.surface(geodesic_triangulation(_START_LEVEL + 1)[0])


def _descend_gap(body: Body, directions: Array, point_mm: Array) -> Array:
    """Minimise (x − p)·n over the surface by Newton on the sphere of normals."""
    u = directions.copy()
    gap = np.full(len(u), np.inf)
    for _ in range(_NEWTON_STEPS):
        points = body.surface(u)
        height, gradient, hessian = support_about(points, point_mm)
        gap = np.minimum(gap, height)
        values, basis = np.linalg.eigh(hessian)
        values = np.maximum(np.abs(values), 1e-3 * body.radius_mm)
        turn = -np.einsum("nab,nb->na", basis, np.einsum("nab,na->nb", basis, gradient) / values)
        angle = np.linalg.norm(turn, axis=1)
        turn *= np.minimum(1.0, 0.1 / np.maximum(angle, 1e-300))[:, None]
        move = np.linalg.solve(points.shape_operator_per_mm, turn[:, :, None])[:, :, 0]
        u = unit(points.position_mm + np.einsum("na,nax->nx", move, points.tangents))
        if angle.max() < 1e-13:
            break
    return gap
