"""Ball geometry of Sloan's second body and its Fourier extension.

Chart
    `f = β sinθ cosψ` with `ψ = φ − P(z)`, `P = η + Σ a_k sin kη`, `η = (3π/2)(z − z³/3)`: the chart makes
    valley and ridge straight. As `dω = dz dφ = dz dψ` the volume depends on β only:
    `V = 2π/3 ∫ (1 + 4βt)^(3/4) dt` over −1 ≤ t ≤ 1.

Derivatives in the orthonormal frame (e_θ, e_φ), with `p = P'(z)`, `b = P''(z)`, `q = ρ² p`, at the poles too
    `∇f  = β (z cosψ − q sinψ, −sinψ)`,
    `∇²f = −βρ [[(1 + ρ²p²) cosψ + (3zp − ρ²b) sinψ, p cosψ], [p cosψ, cosψ + zp sinψ]]`.

The body looks the same after half a turn about the x-axis, since P is odd in z; so its centroid lies on
that axis, at `x = 2β/(3V) ∫ cos(η + Σ a_k sin kη) dη` over −π ≤ η ≤ π.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cached_property
from typing import NamedTuple

from flint import acb, arb, ctx

from gomboc_cad.body.catalogue import ExactParameters
from gomboc_cad.body.families import MAX_WINDING
from gomboc_cad.equilibria.certificate.decimals import decimal_ball
from gomboc_cad.equilibria.certificate.enclosures import (
    BallGeometry,
    Chart,
    Form,
    Jet,
    Point,
    Relief,
    half_turns,
)
from gomboc_cad.equilibria.certificate.records import Cell, Decimals
from gomboc_cad.errors import BodyError

_CENTROID_BITS = 128
_MAX_EVALUATIONS = 20_000
_MAX_TERMS = 32


class _Band(NamedTuple):
    """What depends on θ alone: the chart, the phase P, and a factor of ∇²f."""

    chart: Chart[arb]
    phase: arb
    bend: arb


class SloanGeometry(BallGeometry[arb]):
    """A body `r⁴ = 1 + 4 β sinθ cos(φ − P)`, `P = η + Σ a_k sin kη`, known by its exact decimals.

    Args:
        beta: Decimal of β, 0 < β < 0.25.
        coefficients: Decimals a_k by order k ≥ 1.
        com: Decimals of the centre of mass; the centroid if not given.

    Raises:
        BodyError: If the decimals do not describe such a body.
    """

    def __init__(self, beta: str, coefficients: Mapping[int, str], com: Decimals | None = None) -> None:
        super().__init__(com)
        self.beta = decimal_ball(beta)
        self._terms = [(k, decimal_ball(a)) for k, a in coefficients.items()]
        if not (self.beta > 0 and self.beta < 0.25):
            raise BodyError(f"beta = {beta} is outside 0 < beta < 0.25; a certificate needs a body within.")
        if len(self._terms) > _MAX_TERMS or not all(
            1 <= k <= MAX_WINDING and abs(a) * k <= MAX_WINDING for k, a in self._terms
        ):
            raise BodyError(
                f"A certificate takes at most {_MAX_TERMS} Fourier terms, of order 1 ≤ k ≤ {MAX_WINDING:g} "
                f"and with k |a| ≤ {MAX_WINDING:g}."
            )
        self._bands: dict[tuple[int, int], _Band] = {}
        self._columns: dict[tuple[int, int], tuple[arb, arb, arb]] = {}

    @classmethod
    def of(cls, parameters: ExactParameters, com: Decimals | None = None) -> SloanGeometry:
        """The geometry of a `sloan2` or `extended` body by its exact parameters.

        Raises:
            BodyError: If the parameters are not those of such a body with 0 < β < 0.25.
        """
        coefficients = {_order(key): a for key, a in parameters.coefficients.items()}
        if len(coefficients) < len(parameters.coefficients) or bool(coefficients) == (
            parameters.family == "sloan2"
        ):
            raise BodyError("Give each coefficient once, to the family extended and not to sloan2.")
        return cls(parameters.beta or "", coefficients, com)

    @cached_property
    def volume(self) -> arb:
        """Volume."""
        with ctx.workprec(_CENTROID_BITS):
            power = arb(7) / 4
            span = (1 + 4 * self.beta) ** power - (1 - 4 * self.beta) ** power
            return 2 * arb.pi() * span / (21 * self.beta)

    @cached_property
    def centroid(self) -> Point:
        """Homogeneous centroid, on the x-axis."""

        def integrand(eta: acb, _: bool) -> acb:
            return sum((a * (k * eta).sin() for k, a in self._terms), eta).cos()

        with ctx.workprec(_CENTROID_BITS):
            # The integrand is even.
            half = acb.integral(integrand, 0, acb(arb.pi()), eval_limit=_MAX_EVALUATIONS).real
            return 4 * self.beta * half / (3 * self.volume), arb(0), arb(0)

    @property
    def inscribed_radius(self) -> arb:
        """Radius of the largest ball about the origin inside the body."""
        return (1 - 4 * self.beta).sqrt().sqrt()

    @property
    def axis_is_symmetry(self) -> bool:
        """True: P is odd in z."""
        return True

    def _chart(self, cell: Cell) -> Chart[arb]:
        return self._band(cell).chart

    def _relief(self, cell: Cell) -> Relief[arb]:
        band, (cosine, sine, _) = self._band(cell), self._column(cell)
        z, rho, q, _, _ = band.chart
        return Relief(
            s=1 + 4 * (self.beta * rho) * cosine,
            g_theta=self.beta * (z * cosine - q * sine),
            g_phi=-self.beta * sine,
            g_oblique=self.beta * z * cosine,
        )

    def _bending(self, cell: Cell, factor: arb) -> Form[arb]:
        band, (cosine, sine, _) = self._band(cell), self._column(cell)
        z, rho, _, rho_p, _ = band.chart
        tilt = self.beta * rho
        return Form(
            factor * (1 + tilt * ((5 + rho_p * rho_p) * cosine + band.bend * sine)),
            factor * self.beta * rho_p * cosine,
            factor * (1 + tilt * 5 * cosine + self.beta * z * rho_p * sine),
        )

    def _jet(self, cell: Cell) -> Jet[arb]:
        chart, (cosine, sine, _) = self._chart(cell), self._column(cell)
        height = 4 * self.beta * chart.rho * cosine
        return Jet(
            s=1 + height,
            t=4 * self.beta * chart.z * cosine,
            p=-4 * self.beta * chart.rho * sine,
            tt=-height,
            tp=-4 * self.beta * chart.z * sine,
            pp=-height,
        )

    def _azimuth(self, cell: Cell) -> tuple[arb, arb]:
        phi = self._column(cell)[2] + self._band(cell).phase
        return phi.cos(), phi.sin()

    def _band(self, cell: Cell) -> _Band:
        key = cell.theta_low, cell.theta_high
        if key not in self._bands:
            self._bands[key] = self._make_band(half_turns(*key))
        return self._bands[key]

    def _make_band(self, theta: arb) -> _Band:
        z, rho = arb.cos_pi(theta), arb.sin_pi(theta)
        eta = arb.pi() * (3 * z - z * z * z) / 2
        eta_z, eta_zz = 3 * arb.pi() * rho * rho / 2, -3 * arb.pi() * z
        phase, slope, curve = eta, arb(1), arb(0)
        for k, a in self._terms:
            sine, cosine = (k * eta).sin(), (k * eta).cos()
            phase += a * sine
            slope += a * k * cosine
            curve -= a * k * k * sine
        p = slope * eta_z
        b = slope * eta_zz + curve * eta_z * eta_z
        bend = 3 * z * p - rho * rho * b
        return _Band(Chart(z, rho, rho * rho * p, rho * p, -rho * bend), phase, bend)

    def _column(self, cell: Cell) -> tuple[arb, arb, arb]:
        key = cell.psi_low, cell.psi_high
        if key not in self._columns:
            psi = half_turns(*key)
            self._columns[key] = arb.cos_pi(psi), arb.sin_pi(psi), psi * arb.pi()
        return self._columns[key]


def _order(key: str) -> int:
    if not re.fullmatch(r"[1-9]\d{0,3}", key, re.ASCII):
        raise BodyError(f"{key!r:.60} is not an order k of a Fourier term, a whole number such as 2.")
    return int(key)
