"""The search in the extended family: differential evolution over β and a few Fourier coefficients.

Bodies are compared by Deb's rule (Computer Methods in Applied Mechanics and Engineering 186, 2000): one that
keeps the constraints beats one that does not; of two that do, the better objective wins, of two that do
not, the smaller violation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import Bounds, differential_evolution

from gomboc_cad.body import Body, make_body
from gomboc_cad.body.mass import mass_properties
from gomboc_cad.body.sphere import Array
from gomboc_cad.errors import BodyError
from gomboc_cad.progress import Progress, silent
from gomboc_cad.search.curvature_floor import with_curvature_above
from gomboc_cad.search.landscape import survey
from gomboc_cad.search.objectives import Goal

BETA_BOUNDS = (0.002, 0.06)
COEFFICIENT_BOUND = 0.6
MAX_ORDERS = 8
BETA_DECIMALS, COEFFICIENT_DECIMALS = 8, 6
_OUTSIDE = 2.0
"""Cost of a body that is dented or has more poses: worse than any that only misses a constraint."""


@dataclass(frozen=True)
class Evolution:
    """How the differential evolution is run.

    Attributes:
        orders: Orders k of the Fourier coefficients.
        seed: Seed of the random numbers; the same seed gives the same body.
        population: Members of the population per parameter.
        generations: Largest number of generations.
    """

    orders: tuple[int, ...] = (1, 2, 3)
    seed: int = 1
    population: int = 10
    generations: int = 60

    def __post_init__(self) -> None:
        """Raise BodyError if the search is not possible."""
        if not 1 <= len(set(self.orders)) == len(self.orders) <= MAX_ORDERS or min(self.orders) < 1:
            raise BodyError(f"Give one to {MAX_ORDERS} different orders k ≥ 1, not {self.orders!r}.")
        if self.seed < 0 or self.population < 1 or self.generations < 1:
            raise BodyError("The seed must not be negative; population and generations must be 1 or more.")


def search_extended(goal: Goal, evolution: Evolution, progress: Progress = silent) -> Body:
    """Find the best body of the family that keeps the constraints, with nominal radius 1.

    Args:
        goal: What is wanted.
        evolution: How to search.
        progress: Told of every generation; an exception that it raises ends the search.

    Raises:
        BodyError: If no body met the constraints.
    """
    generation = 0

    def watch(intermediate_result: Any) -> None:
        nonlocal generation
        generation += 1
        cost = intermediate_result.fun
        state = f"{goal.objective} {-cost:.5f} R0" if cost < 0.0 else "no body within the constraints yet"
        progress(f"generation {generation} of at most {evolution.generations}: {state}")

    def cost(parameters: Array) -> float:
        body = _body(parameters, evolution.orders)
        landscape = survey(body, np.array(mass_properties(body).com_mm))
        if landscape is None:
            return _OUTSIDE
        missed = float(goal.shortfall(landscape).sum())
        return missed if missed > 0.0 else -goal.value(landscape)

    found = differential_evolution(
        cost,
        Bounds(
            *np.array([BETA_BOUNDS, *((-COEFFICIENT_BOUND, COEFFICIENT_BOUND) for _ in evolution.orders)]).T
        ),
        # Sloan 2 itself, which keeps the constraints unless they are wide: the search is never worse.
        x0=np.array([0.02, *(0.0 for _ in evolution.orders)]),
        rng=evolution.seed,
        popsize=evolution.population,
        maxiter=evolution.generations,
        tol=1e-4,
        polish=False,
        callback=watch,
    )
    if found.fun >= 0.0:
        raise BodyError(
            "The search met no body within the constraints; lower the smallest curvature or the smallest "
            "margin, or allow more generations."
        )
    # Short decimals can be typed, and a certificate is for exactly the decimals.
    beta, coefficients = found.x[0], np.round(found.x[1:], COEFFICIENT_DECIMALS)
    return with_curvature_above(
        goal.min_curvature,
        lambda scale: _body(np.array([round(scale * beta, BETA_DECIMALS), *coefficients]), evolution.orders),
    )


def _body(parameters: Array, orders: tuple[int, ...]) -> Body:
    beta, *coefficients = (float(value) for value in parameters)
    terms = {str(k): a for k, a in zip(orders, coefficients, strict=True)}
    return make_body("extended", beta, terms, diameter_mm=2.0)
