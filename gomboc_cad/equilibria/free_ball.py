"""Balls of COM positions that are free of walls, and how they grow.

The walls are the sheet of κ₁ of the focal surface, where the number of stable rests changes, and the body's
own surface.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.optimize import linprog
from scipy.spatial import cKDTree

from gomboc_cad.body.sphere import Array, BoolArray, geodesic_triangulation
from gomboc_cad.body.support import depth_mm
from gomboc_cad.body.surface import Body
from gomboc_cad.equilibria.focal import image_samples
from gomboc_cad.equilibria.margin import focal_points_mm, s_margin_mm

_REACH = 1.5
_FINENESS = (12.0, 48.0)
_ACCURACY = 1e-3
_SAME = 1e-9
_COARSER = 1.0 / 3.0
_LEAF = 32
"""Samples in a leaf of the search tree: the fastest of 8 to 32."""


class Walls:
    """Samples of the walls: no point of these is farther from a sample than the spacing."""

    def __init__(self, body: Body, spacing_mm: Callable[[Array], Array]) -> None:
        self.body = body
        sheet = image_samples(lambda u: focal_points_mm(body, u, 0), spacing_mm)
        surface = image_samples(body.position_mm, spacing_mm)
        samples = np.concatenate([sheet, surface])
        # Samples side by side in space are side by side in memory too, which halves the time of a query.
        order = cKDTree(samples).indices
        self.samples_mm = samples[order]
        self.on_sheet = order < len(sheet)
        self.tree = cKDTree(self.samples_mm, leafsize=_LEAF)

    def distance_mm(self, points_mm: Array, up_to_mm: float = np.inf) -> Array:
        """Distance to the nearest sample, infinite beyond `up_to_mm`, shape (n,)."""
        return np.asarray(self.tree.query(points_mm, distance_upper_bound=up_to_mm, workers=-1)[0])

    def gap_mm(self, point_mm: Array) -> float:
        """Distance of one point from the nearest sample."""
        return float(self.distance_mm(point_mm))


class Surroundings(NamedTuple):
    """Where the walls around a ball are sampled finely: somewhat farther than they are.

    Attributes:
        center_mm: Centre of the ball, shape (3,).
        room_mm: Its radius.
        fineness: Samples along the radius.
    """

    center_mm: Array
    room_mm: float
    fineness: float

    def spacing_mm(self, points_mm: Array) -> Array:
        """Spacing of the samples of a wall at points (n, 3), shape (n,)."""
        distance = np.linalg.norm(points_mm - self.center_mm, axis=1)
        beyond = np.maximum(0.0, distance - _REACH * self.room_mm)
        result: Array = self.room_mm / self.fineness + _COARSER * beyond
        return result

    def hold(self, center_mm: Array, room_mm: float) -> bool:
        """Whether a ball lies where samples are fine."""
        farthest = float(np.linalg.norm(center_mm - self.center_mm)) + room_mm
        return farthest <= _REACH * self.room_mm


def room_mm(body: Body, center_mm: Array) -> float:
    """Distance to the sheet or to the surface, whichever is nearer."""
    return min(s_margin_mm(body, center_mm), float(depth_mm(body, center_mm)[0]))


def best_place(body: Body, center_mm: Array, radius_mm: float) -> Array:
    """Move a ball so that it can grow, until it cannot, sampling the walls only around it.

    A ball on an axis or plane of symmetry grows within it first, and leaves it only for what is more than the
    accuracy: otherwise the best place would be off the axis by chance, and with it the resting direction.

    Args:
        body: A strictly convex body.
        center_mm: Its centre, shape (3,).
        radius_mm: Its radius: the room that it has there.

    Returns:
        The centre of the grown ball, shape (3,).
    """
    within = _kept_by_symmetry(body, center_mm)
    for fineness in _FINENESS:
        center_mm, radius_mm = _grown_on(body, center_mm, radius_mm, fineness, within)
    if within.all():
        return center_mm
    anywhere, wider_mm = _grown_on(body, center_mm, radius_mm, fineness, np.ones(3, dtype=bool))
    return anywhere if wider_mm > (1.0 + _ACCURACY) * radius_mm else center_mm


def _kept_by_symmetry(body: Body, point_mm: Array) -> BoolArray:
    """Which coordinates are left alone by all symmetries of the body that leave a point alone, shape (3,).

    The symmetries are the reflections and half-turns of the coordinate planes and axes.
    """
    grid = geodesic_triangulation(2)[0]
    radii = body.radius_at(grid)
    kept = np.ones(3, dtype=bool)
    for signs in product((1.0, -1.0), repeat=3):
        symmetric = np.allclose(body.radius_at(grid * signs), radii, rtol=_SAME, atol=0.0)
        if symmetric and np.linalg.norm(point_mm * signs - point_mm) <= _SAME * body.radius_mm:
            kept &= np.array(signs) > 0.0
    return kept


def _grown_on(
    body: Body, center_mm: Array, radius_mm: float, fineness: float, along: BoolArray
) -> tuple[Array, float]:
    """Grow a ball along some coordinates, sampling the walls anew wherever it has left what was sampled."""
    held = False
    while not held:
        around = Surroundings(center_mm, radius_mm, fineness)
        walls = Walls(body, around.spacing_mm)
        center_mm = grown(walls, center_mm, around.hold, along)
        radius_mm = walls.gap_mm(center_mm)
        held = around.hold(center_mm, radius_mm)
    return center_mm, radius_mm


def grown(
    walls: Walls,
    center_mm: Array,
    while_held: Callable[[Array, float], bool] = lambda _center, _radius: True,
    along: Sequence[bool] | BoolArray = (True, True, True),
) -> Array:
    """Move a ball so that it can grow, until it cannot.

    Each step maximises the least of the distances, linearised, within a cube. Distances are convex, so
    the true gain is at least the linear one.

    Args:
        walls: What it must not cross.
        center_mm: Its centre, shape (3,).
        while_held: Called with centre and radius; the ball stops when that is no longer true.
        along: Coordinates that may change, shape (3,).

    Returns:
        The centre of the grown ball, shape (3,).
    """
    radius = walls.gap_mm(center_mm)
    trust = 0.1 * radius
    while trust > 1e-3 * radius and while_held(center_mm, radius):
        near = walls.samples_mm[walls.tree.query_ball_point(center_mm, radius + 2.0 * trust)]
        distance, normal = _nearest_by_direction(center_mm - near)
        rows = np.column_stack([-normal, np.ones(len(normal))])
        bounds = [(-trust * free, trust * free) for free in along] + [(0.0, None)]
        step = linprog([0.0, 0.0, 0.0, -1.0], A_ub=rows, b_ub=distance, bounds=bounds).x
        trial: Array = center_mm + np.asarray(step)[:3]
        wider = walls.gap_mm(trial)
        if wider > radius * (1.0 + 1e-6):
            center_mm, radius = trial, wider
        else:
            trust *= 0.5
    return center_mm


def _nearest_by_direction(arms: Array) -> tuple[Array, Array]:
    """Length and direction of the shortest arm in each of a few thousand directions."""
    length = np.linalg.norm(arms, axis=1)
    order = np.argsort(length, kind="stable")
    normal = arms[order] / length[order, None]
    # One number for each direction, because sorting rows takes ten times as long.
    key = np.round(12.0 * normal).astype(np.int64) @ [10_000, 100, 1]
    _, first = np.unique(key, return_index=True)
    return length[order][first], normal[first]
