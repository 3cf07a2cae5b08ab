"""Where a closed mesh crosses itself, which makes its volume and centre of mass mean nothing.

A tree of boxes over the facets finds the pairs that are near, level by level; each pair is then tested by
its edges. Contact within the rounding of 32-bit coordinates is no crossing.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray, IntArray
from gomboc_cad.solid.mesh import Mesh

CONTACT = 2.0**-21
"""Overlap that is rounding, over the largest coordinate: four steps of a 32-bit number."""

_MAX_PAIRS = 4 * 10**8
_CHUNK = 2**19
_MORTON_BITS = 20


class TooEntangledError(Exception):
    """More facets are near each other than can be tested."""


def is_star_shaped(mesh: Mesh, center_mm: Array) -> bool:
    """Whether every ray from a point meets a closed mesh exactly once, so that it cannot cross itself.

    True if all facets face away from the point and are seen once around: their projection to the sphere is
    then a covering of one sheet.

    Args:
        mesh: One closed shell, its facets outwards.
        center_mm: The point, shape (3,).
    """
    arms = (mesh.vertices_mm - center_mm)[mesh.faces]
    a, b, c = arms[:, 0], arms[:, 1], arms[:, 2]
    volumes = np.einsum("nx,nx->n", a, np.cross(b, c))
    if volumes.min() <= 0.0:
        return False
    la, lb, lc = np.linalg.norm(arms, axis=2).T
    # Solid angle of a triangle: van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30 (1983).
    below = la * lb * lc + lc * np.vecdot(a, b) + lb * np.vecdot(a, c) + la * np.vecdot(b, c)
    around = 2.0 * np.arctan2(volumes, below).sum()
    return bool(around < 6.0 * np.pi)


def self_intersection(mesh: Mesh) -> Array | None:
    """Find a place where facets cross, or lie on one another and face the same way.

    Args:
        mesh: A closed mesh.

    Returns:
        A point of the crossing, shape (3,), in mm; None if there is none.

    Raises:
        TooEntangledError: If more pairs of facets are near each other than can be tested.
    """
    corners = mesh.vertices_mm[mesh.faces]
    contact = CONTACT * float(np.abs(mesh.vertices_mm).max())
    for pairs in _near_pairs(corners):
        first, second = mesh.faces[pairs[:, 0]], mesh.faces[pairs[:, 1]]
        shared = (first[:, :, None] == second[:, None, :]).sum(axis=(1, 2))
        # Neighbours along an edge can only lie on one another, which then facets beside them do as well.
        apart = shared < 2
        pairs, shared = pairs[apart], shared[apart]
        crossing = _crossings(corners[pairs[:, 0]], corners[pairs[:, 1]], shared == 0, contact)
        if crossing.any():
            place: Array = corners[pairs[int(np.argmax(crossing))]].mean(axis=(0, 1))
            return place
    return None


def _near_pairs(corners: Array) -> Iterator[IntArray]:
    """Pairs of facets whose boxes meet, in chunks of shape (k, 2)."""
    order = _morton_order(corners.mean(axis=1))
    low, high = [corners.min(axis=1)[order]], [corners.max(axis=1)[order]]
    while len(low[-1]) > 1:
        starts = np.arange(0, len(low[-1]), 2)
        low.append(np.minimum.reduceat(low[-1], starts))
        high.append(np.maximum.reduceat(high[-1], starts))
    stack = [(len(low) - 1, np.zeros((1, 2), dtype=np.int64))]
    tested = 0
    while stack:
        level, pairs = stack.pop()
        tested += len(pairs)
        if tested > _MAX_PAIRS:
            raise TooEntangledError
        i, j = pairs.T
        meet = np.all((low[level][i] <= high[level][j]) & (low[level][j] <= high[level][i]), axis=1)
        pairs = pairs[meet]
        if level == 0:
            yield order[pairs[pairs[:, 0] < pairs[:, 1]]]
        elif len(pairs):
            below = _children(pairs, len(low[level - 1]))
            stack += [(level - 1, below[k : k + _CHUNK]) for k in range(0, len(below), _CHUNK)]


def _children(pairs: IntArray, count: int) -> IntArray:
    """Pairs of the nodes below pairs of nodes, each once."""
    i, j = 2 * pairs.T
    below = np.concatenate([np.stack([i + a, j + b], axis=1) for a, b in ((0, 0), (0, 1), (1, 0), (1, 1))])
    result: IntArray = below[(below[:, 0] <= below[:, 1]) & (below[:, 1] < count)]
    return result


def _morton_order(points: Array) -> IntArray:
    """Order of points along a curve that keeps neighbours together."""
    low, span = points.min(axis=0), np.maximum(np.ptp(points, axis=0).max(), 1e-300)
    cells = ((points - low) / span * (2**_MORTON_BITS - 1)).astype(np.uint64)
    key = np.zeros(len(points), dtype=np.uint64)
    for bit in range(_MORTON_BITS):
        for axis in range(3):
            key |= (cells[:, axis] >> np.uint64(bit) & np.uint64(1)) << np.uint64(3 * bit + axis)
    return np.argsort(key, kind="stable")


def _crossings(first: Array, second: Array, strangers: BoolArray, contact: float) -> BoolArray:
    """Which pairs of facets, each (k, 3, 3), cross or lie on one another; strangers share no corner."""
    result = np.zeros(len(first), dtype=bool)
    normals = [_unit_normals(facets) for facets in (first, second)]
    # Heights of the corners of one facet over the plane of the other.
    over_second = np.vecdot(first - second[:, :1], normals[1][:, None, :])
    over_first = np.vecdot(second - first[:, :1], normals[0][:, None, :])
    near = np.flatnonzero(_straddles(over_second, contact) & _straddles(over_first, contact))
    for edges_of, heights, facets, normal in (
        (first, over_second, second, normals[1]),
        (second, over_first, first, normals[0]),
    ):
        result[near] |= _pierced(
            edges_of[near], heights[near], facets[near], normal[near], strangers[near], contact
        )
    flat = (np.abs(over_first) <= contact).all(axis=1) & (np.abs(over_second) <= contact).all(axis=1)
    flat &= np.vecdot(*normals) > 0.5
    lying = np.flatnonzero(flat)
    result[lying] |= _overlap(first[lying], second[lying], normals[0][lying], contact)
    return result


def _unit_normals(facets: Array) -> Array:
    normals = np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    result: Array = normals / np.where(lengths > 0.0, lengths, 1.0)
    return result


def _straddles(heights: Array, contact: float) -> BoolArray:
    result: BoolArray = (heights.max(axis=1) > contact) & (heights.min(axis=1) < -contact)
    return result


def _pierced(
    edges_of: Array, heights: Array, facets: Array, normals: Array, strangers: BoolArray, contact: float
) -> BoolArray:
    """Whether an edge of one facet goes through the other.

    Edges that meet count among strangers; facets with a common corner meet there anyway.
    """
    ends, end_heights = np.roll(edges_of, -1, axis=1), np.roll(heights, -1, axis=1)
    through = (np.minimum(heights, end_heights) < -contact) & (np.maximum(heights, end_heights) > contact)
    rise = np.where(through, heights - end_heights, 1.0)
    points = edges_of + (heights / rise)[..., None] * (ends - edges_of)
    sides = np.roll(facets, -1, axis=1) - facets
    inward = np.cross(normals[:, None, :], sides)
    lengths = np.linalg.norm(inward, axis=2, keepdims=True)
    inward /= np.where(lengths > 0.0, lengths, 1.0)
    depth = np.einsum("kpsx,ksx->kps", points[:, :, None, :] - facets[:, None, :, :], inward).min(axis=2)
    least = np.where(strangers, -contact, contact)[:, None]
    result: BoolArray = (through & (depth > least)).any(axis=1)
    return result


def _overlap(first: Array, second: Array, normals: Array, contact: float) -> BoolArray:
    """Whether facets in one plane overlap: no side of either has the other beyond it."""
    result = np.ones(len(first), dtype=bool)
    for facets, others in ((first, second), (second, first)):
        for k in range(3):
            outward = np.cross(facets[:, (k + 1) % 3] - facets[:, k], normals)
            lengths = np.linalg.norm(outward, axis=1)
            beyond = np.vecdot(others - facets[:, k : k + 1], outward[:, None, :]).min(axis=1)
            result &= beyond < -contact * lengths
    return result
