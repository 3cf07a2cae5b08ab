"""The room that something needs inside a product, in the frame of the resting pose."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gomboc_cad.body import Body, depth_mm
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.solid.hollow import Cylinder


@dataclass(frozen=True, eq=False)
class Envelope:
    """An upright prism over a convex outline.

    Attributes:
        name: What needs the room, as in `the board 'X'`.
        outline_mm: Corners around it, along first and second, counter-clockwise, shape (n, 2).
        low_mm: Height of its underside over the body's origin.
        high_mm: Height of its top.
    """

    name: str
    outline_mm: Array
    low_mm: float
    high_mm: float

    def wall_clearances_mm(self, body: Body, frame: RestFrame, wall_mm: float) -> tuple[float, float]:
        """Least distance of its underside and of its top from the cavity's wall, negative beyond it.

        The cavity of a convex body is convex, so the prism lies in it when its corners do.
        """
        low, high = (self._clearance_at(level, body, frame, wall_mm) for level in (self.low_mm, self.high_mm))
        return low, high

    def passes(self, height_mm: float, body: Body, frame: RestFrame, wall_mm: float) -> bool:
        """Whether the cavity is as wide as the outline at a height."""
        return self._clearance_at(height_mm, body, frame, wall_mm) >= 0.0

    def _clearance_at(self, level: float, body: Body, frame: RestFrame, wall_mm: float) -> float:
        corners = np.array([frame.point(first, second, level) for first, second in self.outline_mm])
        return float(depth_mm(body, corners).min()) - wall_mm

    def gap_to_column_mm(self, frame: RestFrame, column: Cylinder) -> float:
        """Free space to an upright cylinder or tube, which may be around it; negative where they meet."""
        first, second, base = frame.matrix() @ np.array(column.base_mm)
        ends = base, base + column.length_mm * float(np.dot(column.direction, frame.up))
        over = max(self.low_mm - max(ends), min(ends) - self.high_mm)
        axis = np.array([first, second])
        beside = _distance_mm(self.outline_mm, axis) - column.radius_mm
        within = column.inner_radius_mm - float(np.linalg.norm(self.outline_mm - axis, axis=1).max())
        return max(over, beside, within)

    def gap_mm(self, other: Envelope) -> float:
        """Free space to another envelope along an axis of the frame; negative where their boxes meet."""
        (low, high), (other_low, other_high) = self._box(), other._box()
        return float(np.max([low - other_high, other_low - high]))

    def column(self, frame: RestFrame) -> Cylinder:
        """The upright cylinder around it."""
        middle = self.outline_mm.mean(axis=0)
        return self._post(frame, middle, float(np.linalg.norm(self.outline_mm - middle, axis=1).max()))

    def posts(self, frame: RestFrame, radius_mm: float) -> tuple[Cylinder, ...]:
        """Upright cylinders along its outline and its middle line, between which no boss fits unnoticed."""
        low, high = self.outline_mm.min(axis=0), self.outline_mm.max(axis=0)
        half = 0.5 * (high - low)
        middle_line = np.eye(2)[int(half.argmax())] * (half.max() - half.min())
        middle = 0.5 * (low + high)
        ends = np.array([middle - middle_line, middle + middle_line])
        around = _along(np.append(self.outline_mm, self.outline_mm[:1], axis=0), 2.0 * radius_mm)
        return (
            *(self._post(frame, place, radius_mm) for place in around),
            *(self._post(frame, place, float(half.min())) for place in _along(ends, float(half.min()))),
        )

    def _post(self, frame: RestFrame, place_mm: Array, radius_mm: float) -> Cylinder:
        first, second = place_mm.tolist()
        base = as_vector(frame.point(first, second, self.low_mm))
        return Cylinder(base, frame.up, radius_mm, self.high_mm - self.low_mm)

    def _box(self) -> tuple[Array, Array]:
        low, high = self.outline_mm.min(axis=0), self.outline_mm.max(axis=0)
        return np.append(low, self.low_mm), np.append(high, self.high_mm)


def rectangle_mm(middle_mm: tuple[float, float], length_mm: float, width_mm: float) -> Array:
    """Corners of a rectangle along the frame's axes, counter-clockwise, shape (4, 2)."""
    signs = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    result: Array = np.array(middle_mm) + signs * (length_mm, width_mm)
    return result


def _distance_mm(outline_mm: Array, point_mm: Array) -> float:
    """Distance of a point (2,) from a convex counter-clockwise outline, 0 inside it."""
    along = np.roll(outline_mm, -1, axis=0) - outline_mm
    arm = point_mm - outline_mm
    if np.all(along[:, 0] * arm[:, 1] - along[:, 1] * arm[:, 0] >= 0.0):
        return 0.0
    squares = np.maximum((along**2).sum(axis=1), 1e-30)
    share = np.clip((arm * along).sum(axis=1) / squares, 0.0, 1.0)
    return float(np.linalg.norm(arm - share[:, None] * along, axis=1).min())


def _along(corners_mm: Array, step_mm: float) -> Array:
    """Points along a line through corners (n, 2), its ends included, at most a step apart, shape (m, 2)."""
    points = [corners_mm[:1]]
    for start, end in pairwise(corners_mm):
        count = max(1, math.ceil(float(np.linalg.norm(end - start)) / step_mm))
        points.append(np.linspace(start, end, count + 1)[1:])
    return np.concatenate(points)
