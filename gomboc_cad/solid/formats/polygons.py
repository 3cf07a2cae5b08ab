"""Polygons of OBJ and PLY files, cut into triangles."""

from __future__ import annotations

import manifold3d
import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray, IntArray
from gomboc_cad.errors import InspectionError
from gomboc_cad.solid.formats.content import MAX_FACETS, check_count, check_indices

_FLAT = 1e-5
"""Largest distance of a corner from its polygon's plane, over the polygon's size, that is rounding."""


def triangulate(
    name: str, vertices: Array, sizes: IntArray, corners: IntArray
) -> tuple[IntArray, tuple[str, ...]]:
    """Cut polygons into triangles.

    A fan from the first corner where that covers a polygon, the convex ones for example; else by ear clipping
    in the polygon's mean plane.

    Args:
        name: Name of the file.
        vertices: Shape (n, 3).
        sizes: Number of corners of each polygon, shape (k,).
        corners: Their indices, one polygon after another, shape (sum of sizes,).

    Returns:
        Triangles, shape (m, 3), and sentences about what the file leaves open.

    Raises:
        InspectionError: If a polygon has fewer than three corners or one that does not exist, or if there are
            too many triangles.
    """
    if len(sizes) and sizes.min() < 3:
        raise InspectionError(f"{name} is damaged: it holds a facet with fewer than three corners.")
    check_count(name, "triangles", int((sizes - 2).sum()), MAX_FACETS)
    check_indices(name, corners[:, None], len(vertices))
    starts = np.cumsum(sizes) - sizes
    triangles, bent = [], 0
    for size in np.unique(sizes):
        polygons = corners[starts[sizes == size, None] + np.arange(size)]
        fans = _fans(polygons)
        if size > 3:
            covered, flat = _fan_covers(vertices, polygons)
            bent += int(np.sum(~flat))
            fans = np.concatenate([fans[covered], *_clipped(vertices, polygons[~covered])])
        triangles.append(fans.reshape(-1, 3))
    notes = (f"{bent} polygons are not flat: how they are cut into triangles is our choice.",) if bent else ()
    return np.concatenate(triangles) if triangles else np.zeros((0, 3), dtype=np.int64), notes


def _fans(polygons: IntArray) -> IntArray:
    """Triangles from the first corner of polygons (k, s), shape (k, s − 2, 3)."""
    first = np.broadcast_to(polygons[:, :1], polygons[:, 2:].shape)
    return np.stack([first, polygons[:, 1:-1], polygons[:, 2:]], axis=-1)


def _fan_covers(vertices: Array, polygons: IntArray) -> tuple[BoolArray, BoolArray]:
    """Whether all triangles of a polygon's fan face the way it does, and whether it is flat."""
    arms = vertices[polygons[:, 1:]] - vertices[polygons[:, :1]]
    normals = np.cross(arms[:, :-1], arms[:, 1:])
    whole = normals.sum(axis=1)
    size = np.linalg.norm(arms, axis=2).max(axis=1)
    off = np.abs(np.einsum("ksx,kx->ks", arms, whole)).max(axis=1)
    covered: BoolArray = (np.einsum("ksx,kx->ks", normals, whole) >= 0.0).all(axis=1)
    flat: BoolArray = off <= _FLAT * size * np.linalg.norm(whole, axis=1)
    return covered, flat


def _clipped(vertices: Array, polygons: IntArray) -> list[IntArray]:
    """Triangles of polygons that no fan covers, each polygon as an array of shape (1, s − 2, 3)."""
    result = []
    for polygon in polygons:
        arms = vertices[polygon] - vertices[polygon[0]]
        # The mean normal by Newell's sum, and two axes across it.
        normal = np.cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)
        along = np.linalg.svd(normal[None, :])[2][1:]
        along[1] *= np.sign(np.dot(np.cross(along[0], along[1]), normal)) or 1.0
        cut = np.asarray(manifold3d.triangulate([arms @ along.T]), dtype=np.int64).reshape(-1, 3)
        # A polygon that crosses itself may come back incomplete; its fan keeps the boundary closed.
        whole = len(cut) == len(polygon) - 2
        result.append(polygon[cut][None] if whole else _fans(polygon[None]))
    return result
