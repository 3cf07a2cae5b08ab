"""What callers give as a point or as a mesh, turned into checked arrays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.errors import GombocError


def finite_vector(values: Sequence[float] | Array) -> Array | None:
    """Three finite numbers as an array of shape (3,); None if they are anything else."""
    try:
        vector = np.array(values, dtype=float)
    except (TypeError, ValueError):
        return None
    return vector if vector.shape == (3,) and np.all(np.isfinite(vector)) else None


def triangle_mesh(vertices: Array, faces: IntArray, error: type[GombocError]) -> tuple[Array, IntArray]:
    """Check the arrays of a triangle mesh; whether it is closed is another question.

    Args:
        vertices: Corners, shape (n, 3); those that no triangle uses may be anything.
        faces: Indices of the corners of each triangle, shape (m, 3).
        error: Raised if the arrays have other shapes, there is no triangle, or a triangle refers to a vertex
            that does not exist.
    """
    points, triangles = np.asarray(vertices, dtype=float), np.asarray(faces)
    if points.ndim != 2 or points.shape[1] != 3 or triangles.ndim != 2 or triangles.shape[1] != 3:
        raise error("A mesh needs vertices of shape (n, 3) and faces of shape (m, 3).")
    if len(triangles) == 0 or not np.issubdtype(triangles.dtype, np.integer):
        raise error("The mesh has no triangles; faces are rows of three vertex indices.")
    if triangles.min() < 0 or triangles.max() >= len(points):
        raise error("A triangle of the mesh refers to a vertex that does not exist; repair the file.")
    return points, triangles.astype(np.int64, copy=False)
