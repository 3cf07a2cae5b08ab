"""The S-margin of bodies as made: how near the centre of mass (COM) is to the focal surface.

With g the slope and λ the smaller eigenvalue of the Hessian of the height, the vector from the COM to the
centre of the larger curvature is `g − λ u`. Its length is minimised over the surface from several places by
the Gauss–Newton method, its derivative taken by differences once and kept up to date by Broyden's formula.
"""

from __future__ import annotations

import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray, IntArray
from gomboc_cad.tolerance.made_bodies import MadeBodies, Slopes

_STEPS = 5
_FOLLOWED = 2
"""Places from which the search goes on."""

_TURN = 0.02
"""Angle in radians by which a start may be off the bottom of its valley."""

_DIFFERENCE = 1e-5
_LONGEST_STEP = 0.1
_DAMPING = 1e-4
_FLAT = 1e-15


def s_margins_mm(bodies: MadeBodies, rows: IntArray, starts: Array, upper: BoolArray) -> Array:
    """S-margin of variants with one rest.

    Args:
        bodies: The bodies as made.
        rows: The variants, shape (k,).
        starts: Directions w for each, near the nearest focal points, shape (k, j, 3).
        upper: Whether these places are on the displaced upper part, shape (k, j).

    Returns:
        Shape (k,).
    """
    count = starts.shape[1]
    here = bodies.slopes(np.repeat(rows, count), starts.reshape(-1, 3), upper.ravel())
    order = np.argsort(_promise(here).reshape(-1, count), axis=1, kind="stable")[:, :_FOLLOWED]
    line = np.arange(len(rows))[:, None]
    start, side = starts[line, order].reshape(-1, 3), upper[line, order].ravel()
    best = _nearest_focal_point_mm(bodies, np.repeat(rows, _FOLLOWED), start, side)
    result: Array = best.reshape(-1, _FOLLOWED).min(axis=1)
    return result


def _promise(slopes: Slopes) -> Array:
    """Square of the distance of a focal point that is expected on the bottom of the valley nearby, (n,)."""
    g1, g2 = slopes.slope
    h11, h12, h22 = slopes.hessian
    soft, stiff = slopes.stiffness()
    angle = 0.5 * np.arctan2(h12, 0.5 * (h11 - h22))
    x, y = np.cos(angle), np.sin(angle)
    along, across = x * g2 - y * g1, np.abs(x * g1 + y * g2)
    # What a small turn along the stiff direction takes away does not count.
    left = np.maximum(across - _TURN * np.abs(stiff), 0.0)
    result: Array = along**2 + left**2 + soft**2
    return result


def focal_vector(slopes: Slopes) -> Array:
    """From the COM to the centre of the larger curvature, shape (3, n)."""
    g1, g2 = slopes.slope
    result: Array = g1 * slopes.frame[0] + g2 * slopes.frame[1] - slopes.softest() * slopes.normal
    return result


def _nearest_focal_point_mm(bodies: MadeBodies, row: IntArray, start: Array, upper: BoolArray) -> Array:
    unit_mm = bodies.body.radius_mm
    probe = _DIFFERENCE * unit_mm
    here = bodies.slopes(row, start, upper)
    vector = focal_vector(here)
    best = (vector * vector).sum(axis=0)
    jacobian = np.stack(
        [
            (focal_vector(bodies.slopes(row, here.moved(_along(axis, probe, len(row))), upper)) - vector)
            / probe
            for axis in range(2)
        ]
    )
    damping = np.full(len(row), _DAMPING)
    for _ in range(_STEPS):
        step = _damped_step(jacobian, vector, damping)
        length = np.sqrt((step * step).sum(axis=0))
        step *= np.minimum(1.0, _LONGEST_STEP * unit_mm / np.maximum(length, 1e-300))
        trial = bodies.slopes(row, here.moved(step), upper)
        reached = focal_vector(trial)
        square = (reached * reached).sum(axis=0)
        missed = reached - vector - step[0] * jacobian[0] - step[1] * jacobian[1]
        jacobian = jacobian + missed * (step / np.maximum((step * step).sum(axis=0), 1e-300))[:, None]
        better = square < best
        damping = np.where(better, 0.1 * damping, 10.0 * damping)
        best = np.where(better, square, best)
        vector = np.where(better, reached, vector)
        here = Slopes(*(np.where(better, new, old) for new, old in zip(trial, here, strict=True)))
    result: Array = np.sqrt(best)
    return result


def _along(axis: int, length: float, count: int) -> Array:
    step = np.zeros((2, count))
    step[axis] = length
    return step


def _damped_step(jacobian: Array, vector: Array, damping: Array) -> Array:
    """Levenberg–Marquardt step in the tangent frame, shape (2, n)."""
    one, two = jacobian
    m11, m12, m22 = (one * one).sum(axis=0), (one * two).sum(axis=0), (two * two).sum(axis=0)
    # On a sphere all focal points are one, and there is no way to go.
    floor = damping * (m11 + m22) + _FLAT
    m11, m22 = m11 + floor, m22 + floor
    r1, r2 = (one * vector).sum(axis=0), (two * vector).sum(axis=0)
    determinant = m11 * m22 - m12 * m12
    result: Array = np.stack([m12 * r2 - m22 * r1, m12 * r1 - m11 * r2]) / determinant
    return result
