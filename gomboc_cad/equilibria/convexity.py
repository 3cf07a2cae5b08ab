"""Extremes of curvature: is the body strictly convex, and how thick may a wall be?"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from gomboc_cad.body.arrays import finite_vector
from gomboc_cad.body.sphere import Array
from gomboc_cad.body.surface import Body
from gomboc_cad.equilibria.cells import SphereMinimum, minimise_on_sphere
from gomboc_cad.equilibria.records import Convexity, as_vector
from gomboc_cad.errors import CensusError, NotConvexError

_ABSOLUTE_GAP = 1e-6
_RELATIVE_GAP = 1e-4


def as_point(values: Sequence[float] | Array) -> Array:
    """Turn what a caller gives as a centre of mass into an array of shape (3,).

    Raises:
        CensusError: If it is not three finite numbers.
    """
    point = finite_vector(values)
    if point is None:
        raise CensusError(f"The centre of mass must be three finite numbers in mm, not {values!r}.")
    return point


def require_strictly_convex(body: Body) -> Convexity:
    """Give the extremes of curvature of a strictly convex body.

    Raises:
        NotConvexError: If the body is not strictly convex; its rests are those of its hull.
    """
    curvature = convexity(body)
    if not curvature.strictly_convex:
        raise NotConvexError(
            f"{body.name!r} is not strictly convex (smallest principal curvature "
            f"{curvature.min_curvature_per_mm:.4g} per mm), so it rests on its convex hull, which the smooth "
            "census does not see; use a smaller beta or smaller coefficients."
        )
    return curvature


@lru_cache(maxsize=64)
def convexity(body: Body) -> Convexity:
    """Find the extremes of the principal and Gaussian curvatures by global search."""
    unit = 1.0 / body.radius_mm

    def smallest(directions: Array) -> Array:
        return body.surface(directions).principal_curvatures_per_mm()[:, 1]

    def negative_largest(directions: Array) -> Array:
        return -body.surface(directions).principal_curvatures_per_mm()[:, 0]

    def gaussian(directions: Array) -> Array:
        result: Array = np.prod(body.surface(directions).principal_curvatures_per_mm(), axis=1)
        return result

    low = _minimum(smallest, unit)
    high = _minimum(negative_largest, unit)
    gauss = _minimum(gaussian, unit * unit)
    return Convexity(
        strictly_convex=low.value > 0.0,
        min_curvature_per_mm=low.value,
        min_curvature_direction=as_vector(low.direction),
        min_gaussian_curvature_per_mm2=gauss.value,
        min_radius_of_curvature_mm=-1.0 / high.value,
    )


def _minimum(function: Callable[[Array], Array], unit: float) -> SphereMinimum:
    """Search a curvature to 1e-6 of its natural unit, or to 1e-4 of itself where it is large."""
    return minimise_on_sphere(function, _ABSOLUTE_GAP * unit, relative=_RELATIVE_GAP)
