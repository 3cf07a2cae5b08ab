"""Choosing trim: which masses, where, so that the rest of the moment is within the core's reach.

A choice that slides between two ends of its site has a mass that is linear between them, and a moment that is
nearly so. So the lightest set is the solution of a mixed-integer linear program, but for one condition: what
is left must lie in the ball that the core can balance. That ball is built up from outside by planes: each
solution beyond it adds the plane that cuts it off (Kelley's method). It is made smaller by what the moments
may be off the line, so that every set that is found does reach the target. Where no core moves, the masses
keep a little of their way for that.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp

from gomboc_cad.body.sphere import Array, geodesic_triangulation
from gomboc_cad.products.placing.moment_balance import Balance, Choice, Use

HEAVIER = 1.1
"""A set may be so much heavier than the lightest, if it has fewer pieces."""

_ROUNDS = 100
_REACHED, _NEAR = 1e-6, 1e-3
"""How far beyond the core's ball a solution may lie, in units of the largest moment."""

_SPARE = 0.05
_MIP_GAP = 1e-4
_NODES = 20_000


def chosen(balance: Balance) -> tuple[Use, ...] | None:
    """Choose the trim with which the target is reached: few pieces, and light ones.

    Of all sets at most a tenth heavier than the lightest, it is the lightest of those with the fewest pieces.
    What is weighed is the mass that is put in, or with pockets the mass that is taken away.

    Returns:
        What is used, at the depths at which the core has least to do; None if there is no such set.
    """
    if not balance.choices:
        return None
    program = _Program(balance)
    solution = program.solve(program.cost, reached=True)
    if solution is None:
        return None
    bound = HEAVIER * float(program.cost @ solution)
    fewest = program.solve(program.pieces + program.cost / max(bound, 1e-300), reached=True, bound=bound)
    return program.uses(solution if fewest is None else fewest)


def nearest(balance: Balance) -> tuple[Use, ...]:
    """Choose the trim that leaves the least moment, to a thousandth of the largest moment."""
    if not balance.choices:
        return ()
    program = _Program(balance)
    solution = program.solve(program.distance, reached=False)
    return () if solution is None else program.uses(solution)


class _Program:
    """The mixed-integer linear program.

    Its columns: which choices are used (n), how far they go from the low end to the high end (n), the moment
    that the core takes (3), the moment that is left (3) and the size of that (1).
    """

    def __init__(self, balance: Balance) -> None:
        self.balance = balance
        choices, target = balance.choices, balance.target_mm
        self.count = n = len(choices)
        lever = balance.lever_with_g(())
        spare = 0.0 if balance.limit_mm * lever else _SPARE
        self.ends_mm = [_ends_mm(choice, spare) for choice in choices]
        moments = self._between_ends(lambda choice, depth: choice.moment_g_mm(depth, target)).reshape(-1, 3)
        self.scale = max(float(np.abs([balance.moment_g_mm, *moments]).max()), 1e-300)
        self.moments = moments.T / self.scale
        cost = self._between_ends(Choice.cost_g)
        self.cost = np.concatenate([cost / max(float(cost.max(initial=0.0)), 1e-300), np.zeros(7)])
        self.pieces = np.concatenate([np.ones(n), np.zeros(n + 7)])
        self.distance = np.concatenate([np.zeros(2 * n + 6), [1.0]])
        per_lever = np.sign(lever) * balance.limit_mm / self.scale
        self.reach = abs(per_lever * lever)
        self.reach_of_choices = per_lever * self._between_ends(Choice.moved_mass_g)
        if self.reach > 0.0:
            self.reach_of_choices[:n] -= np.array([c.bulge_g_mm for c in choices]) / self.scale

    def _between_ends(self, value: Callable[[Choice, float], float | Array]) -> Array:
        """Values of choices at their low ends, then what their high ends add: shape (2n, …)."""
        pairs = list(zip(self.balance.choices, self.ends_mm, strict=True))
        low = np.array([value(choice, low) for choice, (low, _) in pairs])
        high = np.array([value(choice, high) for choice, (_, high) in pairs])
        return np.concatenate([low, high - low])

    def solve(self, cost: Array, *, reached: bool, bound: float = np.inf) -> Array | None:
        """Minimise a cost.

        Args:
            cost: Of each column.
            reached: Whether nothing of the moment may be left.
            bound: The most that the trim may weigh, in the unit of `self.cost`.

        Returns:
            The columns; None if there is no solution.
        """
        n, tolerance = self.count, _REACHED if reached else _NEAR
        core_free, core_planes = _start(self.reach > 0.0)
        rest_free, rest_planes = _start(not reached)
        bounds = Bounds(
            np.concatenate([np.zeros(2 * n), np.full(3, -core_free), np.full(3, -rest_free), [0.0]]),
            np.concatenate([np.ones(2 * n), np.full(3, core_free), np.full(4, rest_free)]),
        )
        for _ in range(_ROUNDS):
            found = milp(
                cost,
                integrality=np.repeat([1, 0], [n, n + 7]),
                bounds=bounds,
                constraints=[*self._equations(bound), self._planes(core_planes, rest_planes)],
                options={"mip_rel_gap": _MIP_GAP, "node_limit": _NODES},
            )
            if found.x is None:
                return None
            core, rest, size = np.split(found.x[2 * n :], [3, 6])
            reach = self.reach + self.reach_of_choices @ found.x[: 2 * n]
            new_core = _beyond(core, reach + tolerance)
            new_rest = _beyond(rest, float(size[0]) + tolerance)
            if not len(new_core) and not len(new_rest):
                break
            core_planes, rest_planes = np.vstack([core_planes, new_core]), np.vstack([rest_planes, new_rest])
        return np.asarray(found.x)

    def uses(self, solution: Array) -> tuple[Use, ...]:
        """What a solution uses, at the depths at which the core has least to do."""
        used, way = solution[: self.count], np.clip(solution[self.count : 2 * self.count], 0.0, 1.0)
        uses = [
            Use(choice, low + float(w) * (high - low))
            for choice, (low, high), z, w in zip(self.balance.choices, self.ends_mm, used, way, strict=True)
            if z > 0.5
        ]
        return self.balance.drawn_near(uses)

    def _equations(self, bound: float) -> list[LinearConstraint]:
        """Moments add up to what is left; one choice a site; nothing unused goes along; the weight."""
        n, eye = self.count, np.eye(3)
        given = -np.array(self.balance.moment_g_mm) / self.scale
        sums = np.hstack([self.moments, eye, -eye, np.zeros((3, 1))])
        names = [c.site.name for c in self.balance.choices]
        site = np.array([[name == other for name in names] for other in sorted(set(names))], dtype=float)
        once = np.hstack([site.reshape(-1, n), np.zeros((len(site), n + 7))])
        along = np.hstack([-np.eye(n), np.eye(n), np.zeros((n, 7))])
        return [
            LinearConstraint(sums, given, given),
            LinearConstraint(np.vstack([once, along]), -np.inf, np.repeat([1.0, 0.0], [len(once), n])),
            LinearConstraint(self.cost, -np.inf, bound),
        ]

    def _planes(self, core_planes: Array, rest_planes: Array) -> LinearConstraint:
        """The core's part within its reach and what is left within its size, in these directions."""
        k, m, n = len(core_planes), len(rest_planes), self.count
        core = np.hstack([np.tile(-self.reach_of_choices, (k, 1)), core_planes, np.zeros((k, 4))])
        rest = np.hstack([np.zeros((m, 2 * n + 3)), rest_planes, -np.ones((m, 1))])
        return LinearConstraint(np.vstack([core, rest]), -np.inf, np.repeat([self.reach, 0.0], [k, m]))


def _start(free: bool) -> tuple[float, Array]:
    """Bound of the components of a vector that is free or zero, and the first planes around its ball."""
    return (np.inf, geodesic_triangulation(2)[0]) if free else (0.0, np.empty((0, 3)))


def _beyond(vector: Array, radius: float) -> Array:
    """Normal of the plane that cuts a vector off a ball, shape (1, 3); shape (0, 3) if it lies inside."""
    size = float(np.linalg.norm(vector))
    return vector[None] / size if size > radius else np.empty((0, 3))


def _ends_mm(choice: Choice, spare: float) -> tuple[float, float]:
    """Depths between which a choice slides; a mass in a hole that grows keeps a share of its way."""
    kept = spare * (choice.high_mm - choice.low_mm) * (choice.item is not None and choice.hole_g_mm > 0.0)
    return choice.low_mm + kept, choice.high_mm - kept
