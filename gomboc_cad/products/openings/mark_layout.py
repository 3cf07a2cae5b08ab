"""Dots of a mark: on the page, and laid on a curved surface with the lengths that they have on the page."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, unit
from gomboc_cad.products.openings.dot_letters import COLUMNS, ROWS, letter

_ARROW = np.array([(k, 0) for k in range(9)] + [(7, 1), (7, -1), (6, 2), (6, -2)], dtype=float)
_ARROW_ROWS, _GAP_ROWS = 5, 2
"""Rows of dots that the arrow takes, and empty rows between lines."""

_MOST_LINES = 3
_STEPS = 8


@dataclass(frozen=True, eq=False)
class MarkLayout:
    """A mark on the page about its middle: along the reading direction, and upwards.

    Attributes:
        letters_mm: Dots of the text, shape (n, 2).
        arrow_mm: Dots of the arrow, pointing along the reading direction, shape (k, 2).
    """

    letters_mm: Array
    arrow_mm: Array

    @property
    def size_mm(self) -> tuple[float, float]:
        """Width and height between the middles of the outermost dots."""
        width, height = 2.0 * self._half_mm
        return float(width), float(height)

    @property
    def reach_mm(self) -> float:
        """Half the diagonal."""
        return float(np.linalg.norm(self._half_mm))

    @property
    def _half_mm(self) -> Array:
        half: Array = np.abs(self.dots_mm(1.0)).max(axis=0)
        return half

    def dots_mm(self, arrow_sign: float) -> Array:
        """All dots, the arrow along (1) or against (−1) the reading direction, shape (n + k, 2)."""
        return np.concatenate([self.letters_mm, self.arrow_mm * [arrow_sign, 1.0]])

    def outline_mm(self) -> Array:
        """The middle, the corners of the rectangle around it and the middles of its sides, shape (9, 2)."""
        steps = np.array([(i, j) for i in (-1.0, 0.0, 1.0) for j in (-1.0, 0.0, 1.0)])
        return steps * self._half_mm


def mark_layouts(text: str, pitch_mm: float) -> list[MarkLayout]:
    """Layouts of a text in one to three lines under an arrow, the most compact first."""
    lengths = {math.ceil(len(text) / lines): lines for lines in range(1, _MOST_LINES + 1)}
    layouts = [_layout(text, length, pitch_mm) for length in lengths]
    return sorted(layouts, key=lambda layout: layout.reach_mm)


def _layout(text: str, length: int, pitch_mm: float) -> MarkLayout:
    """Lines of at most so many characters, one under the other, under an arrow."""
    lines = [text[start : start + length] for start in range(0, len(text), length)]
    dots = []
    for number, line in enumerate(reversed(lines)):
        left = -0.5 * (len(line) * (COLUMNS + 1) - 2)
        foot = number * (ROWS + _GAP_ROWS)
        dots += [letter(c) + np.array([left + i * (COLUMNS + 1), foot]) for i, c in enumerate(line)]
    top = len(lines) * (ROWS + _GAP_ROWS)
    arrow = _ARROW + np.array([-0.5 * _ARROW[:, 0].max(), top + 0.5 * (_ARROW_ROWS - 1)])
    middle = np.array([0.0, 0.5 * (top + _ARROW_ROWS - 1)])
    return MarkLayout(pitch_mm * (np.concatenate(dots) - middle), pitch_mm * (arrow - middle))


def walked(body: Body, sites: Array, ways_mm: Array) -> Array:
    """Walk straight ahead on the surface.

    Args:
        body: The body.
        sites: Surface parameters to start from, shape (n, 3).
        ways_mm: Tangent vectors there, as long as the ways to walk, shape (n, 3).

    Returns:
        Surface parameters at the ends of these geodesics, shape (n, 3).
    """
    step = np.linalg.norm(ways_mm, axis=1) / _STEPS
    ahead = _scaled(ways_mm)
    points = body.surface(sites)
    for _ in range(_STEPS):
        local = np.einsum("nax,nx->na", points.tangents, ahead)
        curvature = np.einsum("na,nab,nb->n", local, points.shape_operator_per_mm, local)
        # Along the circle of that curvature, up to the third order of the step.
        bend = curvature * step
        place = points.position_mm + (step * (1.0 - bend**2 / 6.0))[:, None] * ahead
        place -= (0.5 * bend * step)[:, None] * points.normal
        # Down to the surface along the normal, which shifts it the least.
        near = body.surface(unit(place))
        gap = np.einsum("nx,nx->n", place - near.position_mm, near.normal)
        points = body.surface(unit(place - gap[:, None] * near.normal))
        ahead = _scaled(ahead - np.einsum("nx,nx->n", ahead, points.normal)[:, None] * points.normal)
    return points.directions


def least_spacing_mm(places_mm: Array) -> float:
    """Least distance between two of the points (n, 3)."""
    distances: Array = np.asarray(cKDTree(places_mm).query(places_mm, k=2)[0])
    return float(distances[:, 1].min())


def _scaled(vectors: Array) -> Array:
    """Unit vectors along vectors (n, 3); zero where there is no direction."""
    result: Array = vectors / np.maximum(np.linalg.norm(vectors, axis=1), 1e-300)[:, None]
    return result
