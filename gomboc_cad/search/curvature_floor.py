"""The last step of a search: the smallest curvature is kept as the exact search of the surface finds it."""

from __future__ import annotations

from collections.abc import Callable

from scipy.optimize import brentq

from gomboc_cad.body import Body
from gomboc_cad.equilibria import convexity
from gomboc_cad.errors import BodyError

_SMALLEST_SCALE = 0.5
_SLACK = 2e-6
"""More than rounding of the parameters and the tolerance of `convexity` take away."""


def with_curvature_above(min_curvature: float, scaled: Callable[[float], Body]) -> Body:
    """The body with the largest amplitude whose curvatures all exceed a bound, at least half of that given.

    Args:
        min_curvature: The bound, times R₀.
        scaled: Gives the body of radius 1 whose amplitude is multiplied by a factor up to 1.

    Raises:
        BodyError: If the curvature is missed by more than that.
    """

    def excess(scale: float) -> float:
        return convexity(scaled(scale)).min_curvature_per_mm - min_curvature

    if excess(1.0) >= 0.0:
        return scaled(1.0)
    if excess(_SMALLEST_SCALE) <= _SLACK:
        raise BodyError("The search ended with a body that is too flat; ask for a larger smallest curvature.")
    scale = brentq(lambda scale: excess(scale) - _SLACK, _SMALLEST_SCALE, 1.0, xtol=1e-7)
    return scaled(float(scale))
