"""Facets of a mesh by the many: normals, points spread over them, and the nearest of them."""

from __future__ import annotations

import numpy as np

from gomboc_cad.body.sphere import Array, IntArray, cross, lengths
from gomboc_cad.solid.mesh import Mesh

_MOST_PAIRS = 200_000


def facet_normals(mesh: Mesh) -> tuple[Array, Array]:
    """Outward unit normals of the facets (m, 3), and their areas in mm² (m,)."""
    corners = mesh.vertices_mm[mesh.faces]
    doubled = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = lengths(doubled)
    return doubled / np.maximum(twice, 1e-300)[:, None], 0.5 * twice


def spread_points(mesh: Mesh, count: int) -> tuple[Array, IntArray]:
    """Spread points over a mesh, each for an equal share of its area; the same ones each time.

    Within the facets they follow the R2 sequence (Roberts, 2018), folded onto the triangle.

    Returns:
        Points (count, 3) and the facets that they are on (count,).
    """
    area = np.cumsum(facet_normals(mesh)[1])
    row = np.arange(count)
    facets = np.searchsorted(area, (row + 0.5) / count * area[-1]).clip(max=len(area) - 1)
    plastic = 1.32471795724474602596
    u, v = ((0.5 + row / plastic**power) % 1.0 for power in (1, 2))
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
    a, b, c = np.moveaxis(mesh.vertices_mm[mesh.faces[facets]], 1, 0)
    points: Array = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    return points, facets


def nearest_on_facets(points: Array, corners: Array) -> tuple[Array, IntArray]:
    """Find the nearest points of triangles: over their plane, or else on a side.

    Args:
        points: Shape (n, 3).
        corners: Corners of the triangles, shape (m, 3, 3), or (n, m, 3, 3) with some for each point.

    Returns:
        The nearest point for each (n, 3), and which of the triangles it is on (n,).
    """
    count = 1 + len(points) * corners.shape[-3] // _MOST_PAIRS
    each = np.array_split(corners, count) if corners.ndim == 4 else [corners[None]] * count
    found = [_nearest(*block) for block in zip(np.array_split(points, count), each, strict=True)]
    return np.concatenate([place for place, _ in found]), np.concatenate([facet for _, facet in found])


def _nearest(points: Array, corners: Array) -> tuple[Array, IntArray]:
    """As `nearest_on_facets`, for corners (n or 1, m, 3, 3)."""
    sides = np.roll(corners, -1, axis=2) - corners
    arms = points[:, None, None] - corners
    along = np.clip(np.vecdot(arms, sides) / np.maximum(np.vecdot(sides, sides), 1e-300), 0.0, 1.0)
    normal = np.cross(sides[..., 0, :], sides[..., 1, :])
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-300)
    inwards = np.cross(normal[..., None, :], sides)
    over = np.all(np.vecdot(arms, inwards) >= 0.0, axis=2)
    # From the point to each candidate: three sides and the plane.
    to_sides = along[..., None] * sides - arms
    to_plane = -np.vecdot(arms[..., 0, :], normal)[..., None] * normal
    steps = np.concatenate([to_sides, to_plane[..., None, :]], axis=2)
    square = np.vecdot(steps, steps)
    square[..., 3] = np.where(over, square[..., 3], np.inf)
    best = square.reshape(len(points), -1).argmin(axis=1)
    facet = best // 4
    return points + steps[np.arange(len(points)), facet, best % 4], facet
