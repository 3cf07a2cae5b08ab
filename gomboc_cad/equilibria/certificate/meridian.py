"""Taylor models in θ of what a harmonic body is made of, on an interval of θ.

The functions of θ are analytic, so each has a Taylor series about the middle of the interval. Its terms up to
a power follow from exact polynomials; the term that ends it takes the derivative from the whole interval, as
a ball. Kept are the value and the change to the first order, with everything else in the ball of the value.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from flint import acb, acb_poly, acb_series, arb, arb_mat, arb_poly, arb_series, ctx

from gomboc_cad.equilibria.certificate.affine import SQUARED, UNIT, Affine
from gomboc_cad.equilibria.certificate.enclosures import Chart, half_turns

SERIES_BITS = 192
"""Precision of the series, in which polynomials of degree 40 lose digits."""

_LAST = 5
"""Power of the term that ends a series."""

_LENGTH = _LAST + 3
"""Terms of the series before two derivatives are taken."""


class Band(NamedTuple):
    """What depends on θ alone.

    The matrices have two rows for each function, its value in the middle and half its change across the
    interval, and two columns for each azimuthal order m, the factors of cos mψ and sin mψ.

    Attributes:
        chart: The chart.
        phase: Cosine and sine of P.
        relief: Functions of f: value; ∇f along e_θ − q e_φ and along e_φ; ∇²f in the frame (e_θ, e_φ).
        jet: Functions of 4 f: value and partial derivatives t, p, tt, tp, pp in the coordinates (θ, ψ).
    """

    chart: Chart[Affine]
    phase: tuple[Affine, Affine]
    relief: arb_mat
    jet: arb_mat


class _Series(NamedTuple):
    """The same as series in θ, those of the matrices for each m."""

    chart: list[acb_series]
    phase: list[acb_series]
    relief: list[list[acb_series]]
    jet: list[list[acb_series]]


def make_band(low: int, high: int, phase: arb_poly, profiles: Mapping[int, acb_poly]) -> Band:
    """Enclose the functions of θ on an interval.

    Args:
        low: Lower end in 2⁻²⁰ half-turns.
        high: Upper end.
        phase: P as a polynomial in z.
        profiles: Polynomials w_m(z) by azimuthal order m.
    """
    with ctx.workprec(SERIES_BITS):
        turns = half_turns(low, high)
        wide, middle, half = (arb.pi() * angle for angle in (turns, turns.mid(), turns.rad()))
        shift = middle.cos()
        shifted_phase = acb_poly(phase)(acb_poly([shift, 1]))
        shifted = {m: w(acb_poly([shift, 1])) for m, w in profiles.items()}
        inside, outside = (_series(theta, shift, shifted_phase, shifted) for theta in (middle, wide))
        z, rho, q, rho_p, east_bend, cosine, sine = (
            Affine(value.real, change.real, arb(0))
            for value, change in _models(inside.chart + inside.phase, outside.chart + outside.phase, half)
        )
        relief, jet = (
            _matrix([_models(*series, half) for series in zip(*pair, strict=True)])
            for pair in ((inside.relief, outside.relief), (inside.jet, outside.jet))
        )
        return Band(Chart(z, rho, q, rho_p, east_bend), (cosine, sine), relief, jet)


def _series(theta: arb, shift: arb, phase: acb_poly, profiles: Mapping[int, acb_poly]) -> _Series:
    """Series about θ, which may be an interval; the polynomials are those in `z − shift`."""
    angle = arb_series([theta, 1], _LENGTH)
    z, rho = acb_series(angle.cos()), acb_series(angle.sin())
    turn = _composed(phase, z - shift)
    turn_t = turn.derivative()
    chart = [z, rho, -rho * turn_t, -turn_t, 2 * z * turn_t + rho * turn_t.derivative()]
    relief, jet = [], []
    for m, profile in profiles.items():
        w, w_z = _composed(profile, z - shift), _composed(profile.derivative(), z - shift)
        twist = acb(0, -m)
        back = (turn * twist).exp()
        v = rho**m * w
        east = twist * rho ** (m - 1) * w if m else 0 * w
        along_parallel = -m * v - z * rho**m * w_z
        if m > 1:
            along_parallel -= m * (m - 1) * rho ** (m - 2) * w
        straight = v * back
        slope = straight.derivative()
        hessian = [v.derivative().derivative(), east.derivative(), along_parallel]
        relief.append([straight, slope, east * back, *(entry * back for entry in hessian)])
        by_angle = [straight, slope, twist * straight, slope.derivative(), twist * slope, -m * m * straight]
        jet.append([4 * derivative for derivative in by_angle])
    return _Series(chart, [turn.cos(), turn.sin()], relief, jet)


def _composed(polynomial: acb_poly, inner: acb_series) -> acb_series:
    """A polynomial of a series: shifted by the constant term, which may be a ball, then composed."""
    start = inner[0]
    rest = acb_series([0, *(inner[k] for k in range(1, _LENGTH))], _LENGTH)
    return acb_series(polynomial(acb_poly([start, 1])), _LENGTH)(rest)


def _models(inside: Sequence[acb_series], outside: Sequence[acb_series], half: arb) -> list[tuple[acb, acb]]:
    """Value and change to the first order of each function, from its series in the middle and anywhere."""
    powers = [half**k * (UNIT if k % 2 else SQUARED) for k in range(2, _LAST + 1)]
    return [
        (
            sum(
                (mid[k] * power for k, power in enumerate(powers[:-1], 2)), mid[0] + wide[_LAST] * powers[-1]
            ),
            mid[1] * half,
        )
        for mid, wide in zip(inside, outside, strict=True)
    ]


def _matrix(orders: Sequence[Sequence[tuple[acb, acb]]]) -> arb_mat:
    """The matrix of the models of all functions, given for each order."""
    return arb_mat(
        [
            [part for order in orders for part in (order[k][row].real, order[k][row].imag)]
            for k in range(len(orders[0]))
            for row in (0, 1)
        ]
    )
