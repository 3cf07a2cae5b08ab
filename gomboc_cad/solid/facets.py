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
    """Find the nearest points of triangles.

    Args:
        points: Shape (n, 3).
        corners: Corners of the triangles, shape (m, 3, 3), or (n, m, 3, 3) with some for each point.

    Returns:
        The nearest point for each (n, 3), and which of the triangles it is on (n,).
    """
    count = 1 + len(points) * corners.shape[-3] // _MOST_PAIRS
    if corners.ndim == 3:
        facets = Facets(corners)
        found = [facets.nearest(block) for block in np.array_split(points, count)]
    else:
        blocks = zip(np.array_split(points, count), np.array_split(corners, count), strict=True)
        found = [Facets(own).nearest(block) for block, own in blocks]
    return np.concatenate([place for place, _ in found]), np.concatenate([facet for _, facet in found])


class Facets:
    """Triangles made ready to be asked again and again for the nearest of them.

    The components of vectors come first, which is much the fastest for numpy.
    """

    def __init__(self, corners: Array):
        """Take triangles by their corners, shape (m, 3, 3), or (n, m, 3, 3) with some for each point."""
        each = corners if corners.ndim == 4 else corners[None]
        sides = np.roll(each, -1, axis=2) - each
        normal = np.cross(sides[:, :, 0], sides[:, :, 1])
        normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-300)
        inwards = np.cross(normal[:, :, None], sides)
        self._corners, self._sides, self._normal, self._inwards = (
            np.ascontiguousarray(np.moveaxis(vectors, -1, 0)) for vectors in (each, sides, normal, inwards)
        )
        self._squares = np.maximum(_dot(self._sides, self._sides), 1e-300)

    def nearest(self, points: Array) -> tuple[Array, IntArray]:
        """Nearest point of the triangles to each of the points (n, 3), and which triangle it is on (n,).

        It lies under the point, on the plane of a triangle, or else on a side.
        """
        arms = points.T[:, :, None, None] - self._corners
        along = np.clip(_dot(arms, self._sides) / self._squares, 0.0, 1.0)
        over = np.all(_dot(arms, self._inwards) >= 0.0, axis=2)
        to_sides = along * self._sides - arms
        to_plane = -_dot(arms[..., 0], self._normal) * self._normal
        square = np.empty((*over.shape, 4))
        square[..., :3] = _dot(to_sides, to_sides)
        square[..., 3] = np.where(over, _dot(to_plane, to_plane), np.inf)
        row = np.arange(len(points))
        facet, way = np.divmod(square.reshape(len(points), -1).argmin(axis=1), 4)
        to_side = to_sides[:, row, facet, np.minimum(way, 2)]
        return points + np.where(way == 3, to_plane[:, row, facet], to_side).T, facet

    def nearest_points(self, points: Array) -> Array:
        """Nearest point of the triangles to each of the points (n, 3), shape (n, 3)."""
        return self.nearest(points)[0]


def _dot(a: Array, b: Array) -> Array:
    """Scalar products of vectors, their components along the first axis."""
    result: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return result
