"""The height of the COM over the table in any pose, for those who look at more of it than its equilibria."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.body.support import support_height_mm
from gomboc_cad.body.surface import Body

_BLOCK = 1 << 22
"""Corners times directions that are multiplied at once."""


@dataclass(frozen=True, eq=False)
class BodyHeights:
    """Heights of a smooth body, dented or not.

    Attributes:
        body: The body.
        com_mm: Its centre of mass, shape (3,).
    """

    body: Body
    com_mm: Array

    def __call__(self, directions: Array) -> Array:
        """Height in mm with each of the unit vectors (n, 3) pointing down, shape (n,)."""
        return support_height_mm(self.body, directions) - directions @ self.com_mm


@dataclass(frozen=True, eq=False)
class HullHeights:
    """Heights of the convex hull of points.

    Attributes:
        corners_mm: Its corners, shape (m, 3).
        com_mm: The centre of mass, shape (3,).
    """

    corners_mm: Array
    com_mm: Array

    def __call__(self, directions: Array) -> Array:
        """Height in mm with each of the unit vectors (n, 3) pointing down, shape (n,)."""
        arms = (self.corners_mm - self.com_mm).T
        step = max(1, _BLOCK // arms.shape[1])
        blocks = [directions[k : k + step] @ arms for k in range(0, len(directions), step)]
        return np.concatenate([block.max(axis=1) for block in blocks])
