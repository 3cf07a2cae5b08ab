"""Quasi-static rolling: down the steepest slope of the height, to one of the rests.

Moving so slowly a body has no momentum. The direction u that points down follows `u' = −∇h(u)`, an ordinary
differential equation on the sphere, which ends in a stable rest from all orientations but those on the ridges
between the basins. It is followed in the surface parameter of the contact, so that the lowest point need not
be searched for.

Which basins border on each other at which pass is found by going down on both sides of each saddle; the
barriers are those of the merge tree of these passes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from gomboc_cad.body.sphere import Array, IntArray, fibonacci_directions, unit
from gomboc_cad.body.support import support_jet, touching_directions
from gomboc_cad.body.surface import Body
from gomboc_cad.dynamics.arguments import direction_rows
from gomboc_cad.dynamics.records import Basin, DescentPath
from gomboc_cad.equilibria.convexity import as_point
from gomboc_cad.equilibria.persistence import merge_tree
from gomboc_cad.equilibria.records import Equilibrium
from gomboc_cad.equilibria.smooth import find_equilibria
from gomboc_cad.errors import CensusError

_NUMBERS = 4
"""A descent is followed in the three components of the contact parameter and the length of its way."""

_ARRIVED_RAD = 0.02
"""A path that is so near to a rest, and much nearer than other equilibria are, ends there."""

_OFF_SADDLE_RAD = 1e-4
_LONGEST = 1e7
"""Time after which a path must have arrived; in units of R₀ the soft stiffness of a rest is 1e-3 or more."""


def descent_path(
    body: Body, com: Sequence[float] | Array, down: Sequence[float] | Array, *, tolerance: float = 1e-8
) -> DescentPath:
    """Follow one quasi-static release to its rest.

    Args:
        body: A strictly convex body.
        com: Centre of mass in mm, shape (3,).
        down: Body direction that points down at first, shape (3,).
        tolerance: Error allowed in a step.

    Raises:
        NotConvexError: If the body is not strictly convex.
        DegenerateEquilibriaError: If its equilibria are not isolated.
        CensusError: If the COM is not inside the body, or the path does not arrive, as from an equilibrium.
    """
    ground = _Ground.of(body, com)
    (path,) = _descended(ground, direction_rows([down]), 1e-2 * ground.near_rad, tolerance)
    contact, length = unit(path[:, :3]), path[-1, 3]
    points = body.surface(contact)
    arm = points.position_mm - ground.center_mm
    rest = ground.rests[int(np.argmax(ground.rest_directions @ points.normal[-1]))]
    last = float(np.arccos(np.clip(points.normal[-1] @ np.array(rest.direction), -1.0, 1.0)))
    return DescentPath(
        down=np.concatenate([points.normal, [rest.direction]]),
        height_mm=np.append(np.einsum("nx,nx->n", arm, points.normal), rest.height_mm),
        length_rad=float(length) + last,
        rest=rest,
    )


def basins(
    body: Body, com: Sequence[float] | Array, *, samples: int = 1000, tolerance: float = 1e-6
) -> tuple[Basin, ...]:
    """Measure the basin of each stable rest, the lowest first.

    Barriers are exact to the accuracy of the census; shares are those of evenly spread releases.

    Args:
        body: A strictly convex body.
        com: Centre of mass in mm, shape (3,).
        samples: Number of releases.
        tolerance: Error allowed in a step of a release.

    Raises:
        NotConvexError: If the body is not strictly convex.
        DegenerateEquilibriaError: If its equilibria are not isolated.
        CensusError: If the COM is not inside the body, or a release does not arrive.
    """
    ground = _Ground.of(body, com)
    barriers = _barriers_mm(ground, tolerance)
    shares = np.ones(1)
    if len(ground.rests) > 1:
        ends = _ends(ground, fibonacci_directions(samples), tolerance)
        shares = np.bincount(ends, minlength=len(ground.rests)) / samples
    return tuple(
        Basin(rest, float(share), float(barrier))
        for rest, share, barrier in zip(ground.rests, shares, barriers, strict=True)
    )


class _Ground(NamedTuple):
    """A body about its centre of mass, and its equilibria by kind, the lowest first."""

    body: Body
    center_mm: Array
    rests: tuple[Equilibrium, ...]
    saddles: tuple[Equilibrium, ...]
    rest_directions: Array
    near_rad: float
    highest_mm: float

    @classmethod
    def of(cls, body: Body, com: Sequence[float] | Array) -> _Ground:
        center = as_point(com)
        found = find_equilibria(body, center)
        rests = tuple(e for e in found if e.kind == "stable")
        down = np.array([e.direction for e in rests])
        cosines = down @ np.array([e.direction for e in found]).T
        # Of the equilibria, each rest is its own nearest; the next one is a neighbour.
        neighbour = float(np.arccos(np.clip(np.sort(cosines, axis=1)[:, -2].max(), -1.0, 1.0)))
        saddles = tuple(e for e in found if e.kind == "saddle")
        near = min(_ARRIVED_RAD, 0.1 * neighbour)
        return cls(body, center, rests, saddles, down, near, found[-1].height_mm)


def _barriers_mm(ground: _Ground, tolerance: float) -> Array:
    """Rise from each rest to the lowest pass into the basin of another, shape (r,)."""
    heights = np.array([rest.height_mm for rest in ground.rests])
    if len(ground.rests) == 1:
        return ground.highest_mm - heights
    directions = np.array([saddle.direction for saddle in ground.saddles])
    jet = support_jet(ground.body, directions, ground.center_mm)
    # The first eigenvector is that of the negative eigenvalue: the way down.
    way = np.einsum("na,nax->nx", np.linalg.eigh(jet.hessian_mm)[1][:, :, 0], jet.tangents)
    sides = unit(np.concatenate([directions + _OFF_SADDLE_RAD * way, directions - _OFF_SADDLE_RAD * way]))
    borders = _ends(ground, sides, tolerance).reshape(2, -1).T
    passes = np.array([saddle.height_mm for saddle in ground.saddles])
    tree = merge_tree(heights, borders, passes, np.arange(len(heights)))
    climb = tree.climb(heights, np.ones(len(heights), dtype=bool))
    result = np.empty(len(heights))
    result[tree.bottom] = climb
    return result


def _ends(ground: _Ground, down: Array, tolerance: float) -> IntArray:
    """Index of the rest in which a release from each of the directions (n, 3) ends, shape (n,)."""
    paths = _descended(ground, down, ground.near_rad, tolerance)
    normals = ground.body.surface(unit(paths[:, -1, :3])).normal
    result: IntArray = np.argmax(normals @ ground.rest_directions.T, axis=1)
    return result


def _descended(ground: _Ground, down: Array, near_rad: float, tolerance: float) -> Array:
    """Follow releases side by side until all have arrived: contact and length of way, shape (n, k, 4)."""
    body, size = ground.body, ground.body.radius_mm

    def rates(_: float, numbers: Array) -> Array:
        contact = unit(numbers.reshape(-1, _NUMBERS)[:, :3])
        points = body.surface(contact)
        slope = points.tangents @ (points.position_mm - ground.center_mm)[:, :, None] / size
        local = -np.linalg.solve(points.shape_operator_per_mm, slope)[:, :, 0]
        x_rate = np.einsum("na,nax->nx", local, points.tangents)
        x_rate -= contact * np.einsum("nx,nx->n", contact, x_rate)[:, None]
        reach = np.linalg.norm(points.position_mm, axis=1, keepdims=True)
        return np.concatenate([x_rate / reach, np.linalg.norm(slope, axis=1)], axis=1).ravel()

    def farthest(_: float, numbers: Array) -> float:
        normals = body.surface(unit(numbers.reshape(-1, _NUMBERS)[:, :3])).normal
        return float(np.cos(near_rad) - (normals @ ground.rest_directions.T).max(axis=1).min())

    farthest.terminal, farthest.direction = True, -1.0  # type: ignore[attr-defined]  # as scipy wants it
    start = np.zeros((len(down), _NUMBERS))
    start[:, :3] = touching_directions(body, down)
    # The stiffnesses of a rest differ by three orders, and paths do not act on each other.
    band = _NUMBERS - 1
    done = solve_ivp(
        rates,
        (0.0, _LONGEST),
        start.ravel(),
        method="LSODA",
        events=farthest,
        rtol=tolerance,
        atol=tolerance,
        lband=band,
        uband=band,
    )
    if done.status != 1:
        raise CensusError(
            "A quasi-static release does not arrive at a rest; it starts at an equilibrium or on the ridge "
            "between two basins. Turn it a little."
        )
    rows: Array = done.y.reshape(len(down), _NUMBERS, -1).transpose(0, 2, 1)
    return rows
