"""The search in the harmonic family: sequential linear programming from a mild body.

A margin is the least of many focal distances, so it has kinks and no gradient. A linear program handles
that: in each step the focal distances along valley and ridge, and the curvature where it is small, are
linearised in the coefficients, and the least of them is raised as far as a trust region lets the linear
model go.

The places are found anew in every step, where the focal distance is least across the valley. Its
derivative in that direction vanishes there, so by the envelope theorem the derivative at the fixed place is
that of the least distance itself, which moves with the valley.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from scipy.optimize import linprog

from gomboc_cad.body.families import FourierSloan, Harmonic
from gomboc_cad.body.mass import sphere_quadrature
from gomboc_cad.body.sphere import Array
from gomboc_cad.body.surface import Body
from gomboc_cad.errors import BodyError
from gomboc_cad.progress import Progress, silent
from gomboc_cad.search.curvature_floor import with_curvature_above
from gomboc_cad.search.landscape import Landscape, height_range_mm, stiffness_mm, survey
from gomboc_cad.search.mirror_start import rising_coefficients
from gomboc_cad.search.objectives import Goal

Index = tuple[int, int]

Value = TypeVar("Value", float, Array)

SYMMETRIES = ("half-turn", "mirrors")

CENTER = np.zeros(3)
"""Without degree 1 the centroid is at the origin."""

DECIMALS = 10
_SLOAN_BETA = 0.03
_SLOAN_BETAS = (0.03, 0.025, 0.02, 0.015, 0.01, 0.005)
_MIRRORED_AMPLITUDES = (0.2, 0.16, 0.13, 0.1, 0.08, 0.06, 0.04, 0.02)
_QUADRATURE_ORDER = 80
_DIFFERENCE = 1e-7
_FIRST_TRUST, _TRUST_TO_REPAIR, _SMALLEST_TRUST = 0.02, 1e-3, 1e-6
_PATIENCE = 12
_FIRST_WEIGHTS, _LARGEST_WEIGHT = (1.0, 50.0), 1e6
"""What a unit of curvature and of margin costs that is missed, at first; it doubles while they are missed."""


@dataclass(frozen=True)
class Programming:
    """How the sequential linear programming is run.

    Attributes:
        symmetry: `half-turn` about the x-axis, from Sloan 2; or `mirrors`: two mirror planes through it, from
            a start of that kind.
        first_degree: Degree of the polynomial w₁, which is searched alone at first.
        other_degree: Degree of the polynomials w_m of the other orders.
        orders: Largest azimuthal order m.
        mirrored_degree: Largest degree l with two mirror planes, where orders are not told apart.
        steps: Largest number of steps of each of the two stages.
        gain: A stage ends when a dozen steps have gained less, in units of R₀.
    """

    symmetry: str = "half-turn"
    first_degree: int = 16
    other_degree: int = 10
    orders: int = 4
    mirrored_degree: int = 16
    steps: int = 150
    gain: float = 2e-6

    def __post_init__(self) -> None:
        """Raise BodyError for a symmetry or degrees that the search does not have."""
        if self.symmetry not in SYMMETRIES:
            raise BodyError(f"There is no symmetry {self.symmetry!r}; choose one of {', '.join(SYMMETRIES)}.")
        if not (
            8 <= self.first_degree <= 30
            and 2 <= self.other_degree <= 30
            and 0 <= self.orders <= 8
            and 10 <= self.mirrored_degree <= 24
            and self.steps >= 1
        ):
            raise BodyError(
                "The degrees must be 8 to 30, 2 to 30 and 10 to 24, the orders 0 to 8, the steps positive."
            )


@dataclass(frozen=True, eq=False)
class _Found:
    """Coefficients, and what the body looks like."""

    coefficients: Array
    landscape: Landscape


@dataclass(frozen=True, eq=False)
class _Rows:
    """What a step linearises: the least of `objective` is raised, the others are kept above their floors."""

    objective: Array
    curvature: Array
    margin: Array

    def stacked(self) -> Array:
        return np.concatenate([self.objective, self.curvature, self.margin])


def search_harmonic(goal: Goal, programming: Programming, progress: Progress = silent) -> Body:
    """Find a body of the family.

    Args:
        goal: What is wanted.
        programming: How to search.
        progress: Told of every step; an exception that it raises ends the search.

    Returns:
        The best body that was found, of nominal radius 1. It keeps the smallest curvature; the smallest
        margin only if such a body was found.

    Raises:
        BodyError: If no start of these degrees keeps the smallest curvature.
    """
    search = _with_mirrors if programming.symmetry == "mirrors" else _with_half_turn
    indices, path = search(goal, programming, progress)
    kept = [found for found in path if not goal.is_out_of_reach(found.landscape).any()]
    best = (kept or path)[-1].coefficients
    return with_curvature_above(
        goal.min_curvature, lambda scale: _body(indices, np.round(scale * best, DECIMALS))
    )


def _with_half_turn(
    goal: Goal, programming: Programming, progress: Progress
) -> tuple[list[Index], list[_Found]]:
    """From Sloan 2, first with the order m = 1 alone, then with the others."""
    first = symmetric_indices(1, programming.first_degree)
    others = [
        index
        for order in range(programming.orders + 1)
        if order != 1
        for index in symmetric_indices(order, programming.other_degree)
    ]
    sloan = projected(FourierSloan(_SLOAN_BETA), first) / _SLOAN_BETA
    start = _start(goal, first, sloan, _SLOAN_BETAS)
    alone = _Search(goal, first, programming).run(start, _labelled(progress, "order 1 alone"))[-1]
    wide = np.append(alone.coefficients, np.zeros(len(others)))
    indices = first + others
    return indices, _Search(goal, indices, programming).run(wide, _labelled(progress, "all orders"))


def _with_mirrors(
    goal: Goal, programming: Programming, progress: Progress
) -> tuple[list[Index], list[_Found]]:
    """From a function that rises from rest to top, with all orders at once."""
    indices = mirrored_indices(programming.mirrored_degree)
    start = _start(goal, indices, rising_coefficients(indices), _MIRRORED_AMPLITUDES)
    return indices, _Search(goal, indices, programming).run(start, _labelled(progress, "two mirror planes"))


def symmetric_indices(order: int, degree: int) -> list[Index]:
    """Harmonics (l, m) of |m| = `order` that are symmetric under a half-turn about x, without l = 0 and 1.

    The half-turn takes φ to −φ and z to −z, so cos(mφ) goes with even polynomials of z, and sin(mφ) with odd
    ones, up to the given degree.
    """
    return [
        (order + k, order if k % 2 == 0 else -order)
        for k in range(degree + 1)
        if order + k >= 2 and (order > 0 or k % 2 == 0)
    ]


def mirrored_indices(top: int) -> list[Index]:
    """Harmonics (l, m) up to the degree `top` that the planes y = 0 and z = 0 mirror, without l = 0 and 1.

    The one takes φ to −φ, which leaves cos(mφ); the other z to −z, which leaves those with l − m even.
    """
    return [(degree, m) for degree in range(2, top + 1) for m in range(degree % 2, degree + 1, 2)]


def projected(shape: FourierSloan, indices: Sequence[Index]) -> Array:
    """Coefficients of a Sloan body in the harmonics (l, m), by quadrature over the sphere."""
    directions, weights = sphere_quadrature(_QUADRATURE_ORDER)
    weighted = weights * shape.ambient_jet(directions).value
    return np.array([weighted @ Harmonic(((index, 1.0),)).ambient_jet(directions).value for index in indices])


def _body(indices: Sequence[Index], coefficients: Array) -> Body:
    terms = tuple((index, float(c)) for index, c in zip(indices, coefficients, strict=True))
    return Body("harmonic design", Harmonic(terms), 1.0)


def _start(goal: Goal, indices: Sequence[Index], shape: Array, amplitudes: Sequence[float]) -> Array:
    """The largest body of a shape and some amplitudes, which fall, that keeps the smallest curvature."""
    for amplitude in amplitudes:
        coefficients = amplitude * shape
        landscape = survey(_body(indices, coefficients), CENTER)
        if landscape and landscape.min_curvature_per_mm >= goal.min_curvature:
            return coefficients
    raise BodyError(
        f"No start of these degrees has all curvatures above {goal.min_curvature:g} / R0; lower the smallest "
        "curvature, or take higher degrees."
    )


def _bounded(value: Value) -> Value:
    """What is raised instead of an objective: nearly the same where it is small, and never more than 1.

    The stiffness of a flat rest is many R₀, and no fixed cost would outweigh it.
    """
    return value / (1.0 + value)


def _labelled(progress: Progress, label: str) -> Progress:
    return lambda text: progress(f"{label}: {text}")


class _Search:
    """Sequential linear programming over one set of harmonics."""

    def __init__(self, goal: Goal, indices: Sequence[Index], programming: Programming) -> None:
        self._goal = goal
        self._indices = indices
        self._programming = programming
        # Equal steps bend the surface equally: curvature goes with l (l + 1).
        self._scale = np.array([1.0 / (degree * (degree + 1)) for degree, _ in indices])
        self._weights = np.array(_FIRST_WEIGHTS)

    def run(self, coefficients: Array, progress: Progress) -> list[_Found]:
        """Step until steps no longer gain, and give the bodies on the way, each better than the last."""
        here = self._looked_at(coefficients)
        if here is None:
            raise BodyError("The search needs a start with one stable and one unstable pose.")
        trust, history = _FIRST_TRUST, [here]
        for step in range(self._programming.steps):
            progress(
                f"step {step + 1} of at most {self._programming.steps}: {self._goal.objective} "
                f"{self._goal.value(here.landscape):.5f} R0, smallest curvature "
                f"{here.landscape.min_curvature_per_mm:.4f}, margin {here.landscape.margin_mm:.5f} R0"
            )
            linearised = self._linearised(here)
            while trust > _SMALLEST_TRUST:
                there = self._looked_at(here.coefficients + self._raised(*linearised, trust))
                if there is not None and self._merit(there) > self._merit(here):
                    here = there
                    trust *= 1.5
                    break
                trust *= 0.4
            history.append(here)
            missed = self._goal.is_out_of_reach(here.landscape)
            self._weights = np.minimum(np.where(missed, 2.0, 1.0) * self._weights, _LARGEST_WEIGHT)
            before = history[-_PATIENCE] if len(history) > _PATIENCE else None
            stalled = before and self._merit(here) - self._merit(before) < self._programming.gain
            if missed.any() and np.all(self._weights < _LARGEST_WEIGHT):
                trust = max(trust, _TRUST_TO_REPAIR)
            elif trust <= _SMALLEST_TRUST or stalled:
                break
        return history

    def _looked_at(self, coefficients: Array) -> _Found | None:
        """The body of these coefficients, if it is one with S = U = 1."""
        try:
            landscape = survey(_body(self._indices, coefficients), CENTER)
        except BodyError:
            return None
        if landscape is None:
            return None
        return _Found(coefficients, landscape)

    def _merit(self, found: _Found) -> float:
        """The objective less what the missed constraints cost."""
        cost = float(self._weights @ self._goal.shortfall(found.landscape))
        return _bounded(self._goal.value(found.landscape)) - cost

    def _linearised(self, found: _Found) -> tuple[_Rows, Array]:
        """The rows at the present coefficients, and the derivatives of the stacked rows."""
        rows_of = self._rows(found.landscape)
        here = rows_of(found.coefficients)
        steps = _DIFFERENCE * np.eye(len(found.coefficients))
        change = [rows_of(found.coefficients + step).stacked() - here.stacked() for step in steps]
        return here, np.stack(change, axis=1) / _DIFFERENCE

    def _rows(self, landscape: Landscape) -> Callable[[Array], _Rows]:
        """Rows as a function of the coefficients, where valley, ridge and flat spots are now."""
        directions = np.concatenate([landscape.valley, landscape.ridge, landscape.flat])
        sheet = np.repeat([0, 1], [len(landscape.valley), len(landscape.ridge)])

        def rows(coefficients: Array) -> _Rows:
            body = _body(self._indices, coefficients)
            points = body.surface(directions)
            curvatures = points.principal_curvatures_per_mm()
            along, where = slice(0, len(sheet)), np.arange(len(sheet))
            focal = points.position_mm[along] - points.normal[along] / curvatures[where, sheet][:, None]
            distances = np.linalg.norm(focal, axis=1)
            if self._goal.objective == "s-margin":
                objective = distances
            elif self._goal.objective == "height-range":
                objective = np.array([height_range_mm(body, CENTER)])
            else:
                objective = np.array([stiffness_mm(body, CENTER)])
            return _Rows(_bounded(objective), curvatures[len(sheet) :, 1], distances)

        return rows

    def _raised(self, rows: _Rows, slopes: Array, trust: float) -> Array:
        """The step that raises the least objective row most within the trust region, by linear programming.

        Unknowns: the step, the least objective t, and what curvature and margin lack to their floors.
        """
        count = len(self._scale)
        kinds = np.repeat([0, 1, 2], [len(rows.objective), len(rows.curvature), len(rows.margin)])
        floors = np.choose(kinds, [0.0, self._goal.curvature_floor, self._goal.margin_floor])
        matrix = np.hstack([-slopes, np.zeros((len(kinds), 3))])
        matrix[np.arange(len(kinds)), count + kinds] = np.where(kinds == 0, 1.0, -1.0)
        cost = np.concatenate([np.zeros(count), [-1.0], self._weights])
        reach = trust * self._scale
        bounds = [*zip(-reach, reach, strict=True), (None, None), (0.0, None), (0.0, None)]
        solution = linprog(cost, A_ub=matrix, b_ub=rows.stacked() - floors, bounds=bounds, method="highs")
        return np.zeros(count) if solution.x is None else np.asarray(solution.x[:count])
