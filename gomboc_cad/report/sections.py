"""Plane sections of closed meshes."""

from __future__ import annotations

import numpy as np

from gomboc_cad.body.sphere import Array, IntArray


def section_loops(
    vertices_mm: Array, faces: IntArray, point_mm: Array, plane: tuple[int, int]
) -> list[Array]:
    """Cut a closed mesh by a coordinate plane through a point.

    Args:
        vertices_mm: Shape (n, 3).
        faces: Outward oriented triangles, shape (m, 3).
        point_mm: A point of the plane, shape (3,).
        plane: The two axes that span it.

    Returns:
        Closed loops in those axes, shape (k, 2) each; outer ones turn against holes.
    """
    normal = 3 - sum(plane)
    height = vertices_mm[:, normal] - point_mm[normal]
    above = height >= 0.0
    start, end = faces, np.roll(faces, -1, axis=1)
    rising, falling = ~above[start] & above[end], above[start] & ~above[end]
    # A face that is cut has one rising and one falling edge, which are falling and rising in its neighbours.
    cut = rising.any(axis=1)
    entry, leave = (_edge_keys(start, end, kind, cut, len(vertices_mm)) for kind in (rising, falling))
    following = dict(zip(entry.tolist(), leave.tolist(), strict=True))
    loops = []
    while following:
        first, key = following.popitem()
        keys = [first, key]
        while key != first:
            key = following.pop(key)
            keys.append(key)
        low, high = np.divmod(np.array(keys), len(vertices_mm))
        share = height[low] / (height[low] - height[high])
        points = vertices_mm[low] + share[:, None] * (vertices_mm[high] - vertices_mm[low])
        loops.append(points[:, list(plane)])
    return loops


def _edge_keys(start: IntArray, end: IntArray, kind: Array, cut: Array, count: int) -> IntArray:
    """Key of the edge of one kind in each face that is cut, the same seen from both its faces."""
    place = kind[cut].argmax(axis=1)[:, None]
    ends = (np.take_along_axis(part[cut], place, axis=1)[:, 0] for part in (start, end))
    a, b = ends
    result: IntArray = np.minimum(a, b) * count + np.maximum(a, b)
    return result
