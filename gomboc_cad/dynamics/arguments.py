"""What callers give as directions and angular velocities, turned into checked arrays."""

from __future__ import annotations

import numpy as np

from gomboc_cad.body.sphere import Array, unit
from gomboc_cad.errors import CensusError


def vector_rows(rows: object) -> Array:
    """Rows of three finite numbers as an array of shape (n, 3).

    Raises:
        CensusError: If they are anything else.
    """
    try:
        vectors = np.array(rows, dtype=float)
    except (TypeError, ValueError):
        vectors = np.empty(0)
    if vectors.ndim != 2 or vectors.shape[1] != 3 or not len(vectors) or not np.isfinite(vectors).all():
        raise CensusError("Directions and angular velocities must be rows of three finite numbers.")
    return vectors


def direction_rows(rows: object) -> Array:
    """Unit vectors along rows of three finite numbers, shape (n, 3).

    Raises:
        CensusError: If they are anything else, or one is zero.
    """
    vectors = vector_rows(rows)
    if not np.all(np.any(vectors != 0.0, axis=1)):
        raise CensusError("A direction that points down must not be zero.")
    return unit(vectors)
