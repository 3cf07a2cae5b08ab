"""A start with two mirror planes: a shape function that rises from the rest to the top.

A function on the sphere that rises along a field of tangents with two zeros has no critical point elsewhere.
That is linear in its coefficients, so a linear program finds the harmonics, none of degree 0 or 1, for which
the slope along the field is steepest where it is least.

Source: the field is the direction of ascent of the construction by which P. L. Várkonyi and G. Domokos proved
that such bodies exist (Static equilibria of rigid bodies, Journal of Nonlinear Science 16, 2006, 255), about
the x-axis; here it need not be centred, nor convex.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import linprog

from gomboc_cad.body.families import Harmonic
from gomboc_cad.body.sphere import Array, fibonacci_directions, tangent_frame, unit

_SHARPNESS = 0.5
"""The constant c of the construction; of several it gave the start with the largest margin."""

_DIRECTIONS, _ON_EACH_PLANE = 12_000, 240
_DIFFERENCE = 1e-5


def rising_coefficients(indices: Sequence[tuple[int, int]]) -> Array:
    """Coefficients of harmonics (l, m) whose sum rises along the field wherever it was looked at.

    The largest possible are those that bend the surface as much as any other.
    """
    directions, field = _field()
    slopes = np.stack(
        [
            np.einsum("nx,nx->n", Harmonic(((index, 1.0),)).ambient_jet(directions).gradient, field)
            for index in indices
        ],
        axis=1,
    )
    # Near the rest and the top, slopes are in proportion to the distance from them.
    distance = np.hypot(directions[:, 1], directions[:, 2])
    largest = np.array([1.0 / (degree * (degree + 1)) for degree, _ in indices])
    solution = linprog(
        np.append(np.zeros(len(indices)), -1.0),
        A_ub=np.column_stack([-slopes, distance]),
        b_ub=np.zeros(len(directions)),
        bounds=[*zip(-largest, largest, strict=True), (None, None)],
        method="highs",
    )
    # All coefficients zero are allowed, so there is a solution.
    return np.asarray(solution.x, dtype=np.float64)[:-1]


def _field() -> tuple[Array, Array]:
    """Directions in the quarter y, z ≥ 0 of the sphere, both planes included, and the field there, (n, 3)."""
    spread = fibonacci_directions(_DIRECTIONS)
    inside = spread[(spread[:, 1] > 0.0) & (spread[:, 2] > 0.0)]
    frame = np.stack(tangent_frame(inside), axis=1)
    ahead, behind = (
        _construction(unit(inside[:, None] + sign * _DIFFERENCE * frame).reshape(-1, 3)).reshape(-1, 2)
        for sign in (1.0, -1.0)
    )
    ascent = unit(np.einsum("na,nax->nx", ahead - behind, frame))
    latitude = 0.5 * np.pi * np.linspace(-1.0, 1.0, _ON_EACH_PLANE + 2)[1:-1]
    sine, cosine, zero = np.sin(latitude), np.cos(latitude), np.zeros_like(latitude)
    on_planes = [np.stack(parts, axis=1) for parts in ((sine, cosine, zero), (sine, zero, cosine))]
    up = [np.stack(parts, axis=1) for parts in ((cosine, -sine, zero), (cosine, zero, -sine))]
    return np.concatenate([inside, *on_planes]), np.concatenate([ascent, *up])


def _construction(directions: Array) -> Array:
    """The radial function ΔR of the construction at unit vectors (n, 3): latitude and longitude about x."""
    x, y, z = directions.T
    latitude = np.arcsin(np.clip(x, -1.0, 1.0))
    first, second = _profile(latitude), -_profile(-latitude)
    across = y**2 * (1.0 - first**2)
    along = z**2 * (1.0 - second**2)
    share = across / (across + along)
    result: Array = share * first + (1.0 - share) * second
    return result


def _profile(latitude: Array) -> Array:
    bent = np.expm1(latitude / (np.pi * _SHARPNESS) + 0.5 / _SHARPNESS) / np.expm1(1.0 / _SHARPNESS)
    result: Array = np.sin(np.pi * (bent - 0.5))
    return result
