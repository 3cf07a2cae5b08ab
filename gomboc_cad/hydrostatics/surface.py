"""The outer surface of a floating part: a closed triangle mesh that has been checked and integrated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gomboc_cad.body.arrays import triangle_mesh
from gomboc_cad.body.sphere import Array, IntArray, cross, lengths
from gomboc_cad.errors import GeometryError


@dataclass(frozen=True, eq=False)
class WettedSurface:
    """A closed, outward oriented mesh about a pivot amid it, and the integrals of its facets.

    Attributes:
        pivot_mm: Origin of everything here, shape (3,).
        corners_mm: Vertices that facets use, less the pivot, shape (n, 3).
        faces: Indices of the corners of each triangle, shape (m, 3).
        integrals: Of each facet, shape (m, 7): volume in mm³ and first moment in mm⁴ (3) of the
            tetrahedron from the pivot to it, and its area vector in mm² (3).
        volume_mm3: Volume inside.
        centroid_mm: Centroid of the volume, less the pivot, shape (3,).
    """

    pivot_mm: Array
    corners_mm: Array
    faces: IntArray
    integrals: Array
    volume_mm3: float
    centroid_mm: Array

    @property
    def size_mm(self) -> float:
        """Largest distance of a corner from the pivot."""
        return float(lengths(self.corners_mm).max())


def wetted_surface(vertices: Array, faces: IntArray) -> WettedSurface:
    """Check a mesh and integrate it facet by facet.

    Args:
        vertices: Corners in mm, shape (n, 3).
        faces: Indices of the corners of each triangle, counter-clockwise from outside, shape (m, 3).

    Raises:
        GeometryError: If the arrays are no mesh, the mesh has an open edge, or it is turned inside out.
    """
    points, triangles = _as_mesh(vertices, faces)
    if not _is_closed(triangles, len(points)):
        raise GeometryError(
            "The outer surface is not watertight: some edge does not join two facets of the same "
            "orientation; repair the mesh."
        )
    used, triangles = np.unique(triangles, return_inverse=True)
    pivot = points[used].mean(axis=0)
    corners = points[used] - pivot
    triangles = triangles.reshape(-1, 3)
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    volumes = np.einsum("nx,nx->n", a, cross(b, c)) / 6.0
    moments = np.column_stack([volumes, volumes[:, None] * (a + b + c) / 4.0])
    integrals = np.column_stack([moments, 0.5 * cross(b - a, c - a)])
    total = moments.sum(axis=0)
    if not total[0] > 0.0:
        raise GeometryError(
            "The outer surface encloses no volume or is turned inside out; orient it outwards."
        )
    return WettedSurface(pivot, corners, triangles, integrals, float(total[0]), total[1:] / total[0])


def _as_mesh(vertices: Array, faces: IntArray) -> tuple[Array, IntArray]:
    points, triangles = triangle_mesh(vertices, faces, GeometryError)
    if not np.all(np.isfinite(points)):
        raise GeometryError("A vertex of the outer surface is not a finite point; repair the mesh.")
    return points, triangles


def _is_closed(faces: IntArray, count: int) -> bool:
    """Whether each edge is run through as often forth as back: all that the divergence theorem needs."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    _, edge = np.unique(np.minimum(start, end) * count + np.maximum(start, end), return_inverse=True)
    return not np.any(np.bincount(edge, weights=np.sign(end - start)))
