"""How much material is left between cylinders, both taken with round ends, which is never too little."""

from __future__ import annotations

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.solid.hollow import Cylinder

_PARALLEL = 1e-12
"""Square of the sine of the angle below which two axes count as parallel."""


def gaps_mm(bases_mm: Array, tips_mm: Array, radius_mm: float, other: Cylinder) -> Array:
    """Material between n cylinders of one radius and another cylinder, negative where they meet.

    Args:
        bases_mm: Beginnings of their axes, shape (n, 3).
        tips_mm: Ends of their axes, shape (n, 3).
        radius_mm: Their radius.
        other: The other cylinder.

    Returns:
        Shape (n,).
    """
    start = np.array(other.base_mm)
    end = start + other.length_mm * np.array(other.direction)
    return segment_distances(bases_mm, tips_mm, start, end) - radius_mm - other.radius_mm


def segment_distances(starts: Array, ends: Array, start: Array, end: Array) -> Array:
    """Distances of n segments, (n, 3) to (n, 3), from one segment, (3,) to (3,), shape (n,).

    The least distance is at an end of one of the two, or along the common perpendicular.
    """
    from_ends = [
        _point_distances(starts, start, end),
        _point_distances(ends, start, end),
        _point_distances(start, starts, ends),
        _point_distances(end, starts, ends),
    ]
    along, other, arm = ends - starts, end - start, starts - start
    aa, ab, bb = _dot(along, along), along @ other, float(other @ other)
    determinant = aa * bb - ab * ab
    crossing = determinant > _PARALLEL * aa * bb
    divisor = np.where(crossing, determinant, 1.0)
    da, db = _dot(along, arm), arm @ other
    s, t = (ab * db - bb * da) / divisor, (aa * db - ab * da) / divisor
    crossing &= (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    perpendicular = np.linalg.norm(arm + s[:, None] * along - t[:, None] * other, axis=1)
    result: Array = np.minimum(np.min(from_ends, axis=0), np.where(crossing, perpendicular, np.inf))
    return result


def _point_distances(points: Array, starts: Array, ends: Array) -> Array:
    """Distances of points from segments, n points from one segment or one point from n, shape (n,)."""
    along = ends - starts
    share = np.clip(_dot(points - starts, along) / np.maximum(_dot(along, along), 1e-300), 0.0, 1.0)
    result: Array = np.linalg.norm(points - starts - share[:, None] * along, axis=1)
    return result


def _dot(a: Array, b: Array) -> Array:
    """Products of vectors (n, 3) or (3,) with vectors (n, 3) or (3,)."""
    result: Array = np.sum(a * b, axis=-1)
    return result
