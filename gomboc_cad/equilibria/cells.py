"""Adaptive triangular cells on the sphere, and global minimisation over them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray, IntArray, geodesic_triangulation, subdivide, unit

CORNER_SAFETY = 2.5
"""How many times the largest centre-to-corner change a function is allowed to fall inside a cell.

For a function that is nearly linear in the cell, some corner lies within 60° of steepest descent, so
the factor 2 already covers the whole circumscribed disc.
"""

_MAX_CELLS = 200_000
_MAX_EVALUATIONS = 1_000_000
_SMALLEST_RADIUS = 1e-7
_BLOCK = 8192
"""Directions evaluated at once: what they need stays in the cache, which halves the time."""


def in_blocks(function: Callable[[Array], Array], directions: Array) -> Array:
    """Evaluate a function of unit vectors (n, 3) block by block, shape (n, …)."""
    starts = range(0, max(1, len(directions)), _BLOCK)
    return np.concatenate([function(directions[i : i + _BLOCK]) for i in starts])


@dataclass(frozen=True, eq=False)
class Cells:
    """Spherical triangles that share their corners.

    Attributes:
        vertices: Unit vectors, shape (v, 3); subdivision only appends to them.
        triangles: Three vertex indices per cell, shape (n, 3).
    """

    vertices: Array
    triangles: IntArray

    @staticmethod
    @lru_cache(maxsize=4)
    def covering_sphere(level: int) -> Cells:
        """The triangles of an icosahedron subdivided `level` times; kept, since every search begins there."""
        return Cells(*geodesic_triangulation(level))

    def __len__(self) -> int:
        """Number of cells."""
        return len(self.triangles)

    def centers(self) -> Array:
        """Unit vectors to the centres, shape (n, 3)."""
        return self._centers

    def radii(self) -> Array:
        """Angular radius of the disc about the centre that holds the cell, in radians, shape (n,)."""
        return self._radii

    @cached_property
    def _centers(self) -> Array:
        return _read_only(unit(self.vertices[self.triangles].sum(axis=1)))

    @cached_property
    def _radii(self) -> Array:
        chord = np.linalg.norm(self.vertices[self.triangles] - self._centers[:, None], axis=2).max(axis=1)
        return _read_only(2.0 * np.arcsin(np.minimum(1.0, 0.5 * chord)))

    def subdivided(self, chosen: BoolArray) -> Cells:
        """Split the chosen cells into four each and drop the others; the old vertices keep their places."""
        return Cells(*subdivide(self.vertices, self.triangles[chosen]))


def _read_only(array: Array) -> Array:
    array.flags.writeable = False
    return array


class SphereMinimum(NamedTuple):
    """A global minimum on the sphere.

    Attributes:
        value: The minimum.
        direction: Where it is, shape (3,).
        candidates: The best directions met, shape (k, 3), for a local refinement.
    """

    value: float
    direction: Array
    candidates: Array


def minimise_on_sphere(
    function: Callable[[Array], Array],
    tolerance: float,
    *,
    relative: float = 0.0,
    upper_bound: float = np.inf,
    start_level: int = 4,
    keep: int = 64,
) -> SphereMinimum:
    """Branch and bound over triangular cells.

    A cell is dropped when its centre value less `CORNER_SAFETY` times the largest change to a corner
    is above the best value less the tolerance. The slopes are sampled, not bounded, and the number of
    evaluations is limited, so this is a thorough search and no proof.

    Args:
        function: Values at unit vectors (n, 3), shape (n,).
        tolerance: Absolute gap at which the search stops.
        relative: Gap in units of the best value; the wider of the two counts.
        upper_bound: A value that the function is known to reach somewhere.
        start_level: Subdivision level of the first cells.
        keep: How many candidates to return.
    """
    cells = Cells.covering_sphere(start_level)
    corner_values = function(cells.vertices)
    best_points, best_values = cells.vertices, corner_values
    evaluations = 0
    while True:
        centers = cells.centers()
        values = in_blocks(function, centers)
        best_points, best_values = _lowest(
            np.concatenate([best_points, centers]), np.concatenate([best_values, values]), keep
        )
        at_corners = corner_values[cells.triangles]
        bound = values - CORNER_SAFETY * np.abs(at_corners - values[:, None]).max(axis=1)
        best = min(float(best_values[0]), upper_bound)
        target = best - max(tolerance, relative * abs(best))
        open_cells = (bound < target) & (cells.radii() > _SMALLEST_RADIUS)
        evaluations += len(centers)
        if not open_cells.any() or evaluations + len(cells.vertices) > _MAX_EVALUATIONS:
            return SphereMinimum(float(best_values[0]), best_points[0], best_points)
        if 4 * int(open_cells.sum()) > _MAX_CELLS:
            # A plateau: go on with the cells that may still hold the lowest values.
            bound[~open_cells] = np.inf
            open_cells = bound <= np.partition(bound, _MAX_CELLS // 8)[_MAX_CELLS // 8]
        known = len(cells.vertices)
        cells = cells.subdivided(open_cells)
        fresh = cells.vertices[known:]
        fresh_values = in_blocks(function, fresh)
        corner_values = np.concatenate([corner_values, fresh_values])
        best_points = np.concatenate([best_points, fresh])
        best_values = np.concatenate([best_values, fresh_values])


def _lowest(points: Array, values: Array, count: int) -> tuple[Array, Array]:
    """Keep the points with the lowest values, in rising order."""
    order = np.argsort(values, kind="stable")[:count]
    return points[order], values[order]
