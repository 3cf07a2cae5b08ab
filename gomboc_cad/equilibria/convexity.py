"""Extremes of curvature: is the body strictly convex, and how thick may a wall be?"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.body.surface import Body
from gomboc_cad.equilibria.cells import minimise_on_sphere, polish_minimum
from gomboc_cad.equilibria.records import Convexity, Vector

_RELATIVE_GAP = 1e-4


def as_vector(array: Array) -> Vector:
    """Turn an array of shape (3,) into a plain tuple."""
    x, y, z = (float(value) for value in array)
    return x, y, z


@lru_cache(maxsize=64)
def convexity(body: Body) -> Convexity:
    """Find the extremes of the principal and Gaussian curvatures by global search and refinement."""
    gap = _RELATIVE_GAP / body.radius_mm

    def smallest(directions: Array) -> Array:
        return body.surface(directions).principal_curvatures_per_mm()[:, 1]

    def negative_largest(directions: Array) -> Array:
        return -body.surface(directions).principal_curvatures_per_mm()[:, 0]

    def gaussian(directions: Array) -> Array:
        result: Array = np.prod(body.surface(directions).principal_curvatures_per_mm(), axis=1)
        return result

    low = polish_minimum(smallest, minimise_on_sphere(smallest, gap))
    high = polish_minimum(negative_largest, minimise_on_sphere(negative_largest, gap))
    gauss = polish_minimum(gaussian, minimise_on_sphere(gaussian, gap / body.radius_mm))
    return Convexity(
        strictly_convex=low.value > 0.0,
        min_curvature_per_mm=low.value,
        min_curvature_direction=as_vector(low.direction),
        min_gaussian_curvature_per_mm2=gauss.value,
        min_radius_of_curvature_mm=-1.0 / high.value,
    )
