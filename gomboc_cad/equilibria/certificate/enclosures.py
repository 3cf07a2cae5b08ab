"""Geometry of a Sloan body over a cell of directions, in ball arithmetic.

Every number here is a ball (midpoint and radius) that holds the true value for every direction of the cell,
rounding included; python-flint (Arb) does the arithmetic. Lengths are in units of the nominal radius R₀.

Chart
    `f = β sinθ cos ψ` with `ψ = φ − P(z)`, `z = cosθ`. The body is described in (θ, ψ), in which
    `s = r⁴ = 1 + 4 β ρ cosψ` with `ρ = sinθ`. For every z, ψ runs once round as φ does, so the rectangle
    0 ≤ θ ≤ π, −π/2 ≤ ψ ≤ 3π/2 covers the sphere, and as `dω = dz dφ = dz dψ` the volume depends on β only:
    `V = 2π/3 ∫ (1 + 4βt)^(3/4) dt` over −1 ≤ t ≤ 1.

Derivatives in the orthonormal frame (e_θ, e_φ), with `p = P'(z)`, `b = P''(z)`, `q = ρ² p`, at the poles too
    `∇f  = β (z cosψ − q sinψ, −sinψ)`,
    `∇²f = −βρ [[(1 + ρ²p²) cosψ + (3zp − ρ²b) sinψ, p cosψ], [p cosψ, cosψ + zp sinψ]]`.

Curvature
    With `g = ∇f` and `N = r sqrt(1 + |g|²/s²)` the second fundamental form is
    `r² (s² I + 5 g gᵀ − s ∇²f) / (s² N)` and the first one `r² (s² I + g gᵀ) / s²`, from `r = s^(1/4)`.

Equilibria about a centre of mass c, the centroid or any other,
    are the zeros of `F = (r − u·c) g − s c_T`, which is the gradient of `|x − c|²/2` times s/r.

Margin
    A centre of mass near c balances on a surface point if it lies on its normal line. Moving c by δ changes
    `t·F` by `δ sqrt((t·g)² + s²|t|²)` at most, and that line is as far from c as ℓ,
    `ℓ² = (s² |F|² + (g × F)²) / (s² (s² + |g|²))`. A centre of mass on it closer than δ has a height of
    `h ± sqrt(δ² − ℓ²)` over the tangent plane, with `h = (s r − s u·c + g·c_T) / sqrt(s² + |g|²)`, and the
    equilibrium is regular if one over its height is no principal curvature.

The body looks the same after half a turn about the x-axis, since P is odd in z; so its centroid lies on
that axis, at `x = 2β/(3V) ∫ cos(η + Σ a_k sin kη) dη` over −π ≤ η ≤ π.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property
from typing import Final, NamedTuple

from flint import acb, arb, ctx

from gomboc_cad.body.catalogue import ExactParameters
from gomboc_cad.body.families import MAX_WINDING
from gomboc_cad.equilibria.certificate.records import TURN_UNITS, Cell, Decimals
from gomboc_cad.errors import BodyError

CERTIFIED_FAMILIES = ("sloan2", "extended")

PRECISION_BITS = 64
"""Working precision of the cells; their width, not the rounding, limits what can be proven."""

_CENTROID_BITS = 128
_DECIMAL_BITS = 320
_MAX_EVALUATIONS = 20_000
_MAX_TERMS = 32
_DECIMAL_PLACES: Final = 20
_DECIMAL = re.compile(r"-?\d{1,20}(\.\d{1,60})?(e-?\d{1,2})?", re.ASCII)


class Form(NamedTuple):
    """A symmetric 2 × 2 matrix of balls."""

    xx: arb
    xy: arb
    yy: arb

    @property
    def determinant(self) -> arb:
        """Determinant."""
        return self.xx * self.yy - self.xy * self.xy

    def is_positive(self) -> bool:
        """Whether it is certainly positive definite."""
        return bool(self.xx > 0 and self.determinant > 0)

    def is_negative(self) -> bool:
        """Whether it is certainly negative definite."""
        return bool(self.xx < 0 and self.determinant > 0)


class _Band(NamedTuple):
    """What depends on θ alone: z, ρ, the phase P, q = ρ²p, and the factors of ∇²f."""

    z: arb
    rho: arb
    phase: arb
    q: arb
    rho_p: arb
    bend: arb


def decimal_ball(text: object) -> arb:
    """The ball of a plain decimal such as "0.023149".

    Raises:
        BodyError: If it is not a decimal of sensible length.
    """
    if not isinstance(text, str) or not _DECIMAL.fullmatch(text.lower()):
        raise BodyError(f"{text!r:.60} is not a decimal number such as 0.023149, of at most 60 digits.")
    with ctx.workprec(_DECIMAL_BITS):
        return arb(text)


def decimal_interval(ball: arb) -> tuple[str, str]:
    """Decimals of 20 places that enclose a ball.

    Raises:
        BodyError: If the ball is not finite.
    """
    if not ball.is_finite():
        raise BodyError("A number of this body could not be enclosed; use smaller coefficients.")
    low, high = (_scaled(end) for end in (ball.lower(), ball.upper()))
    return _decimal(math.floor(low)), _decimal(math.ceil(high))


def _scaled(exact: arb) -> Fraction:
    mantissa, exponent = (int(part) for part in exact.man_exp())
    scale = Fraction(1 << exponent) if exponent >= 0 else Fraction(1, 1 << -exponent)
    return mantissa * scale * 10**_DECIMAL_PLACES


def _decimal(units: int) -> str:
    digits = f"{abs(units):0{_DECIMAL_PLACES + 1}d}"
    return f"{'-' * (units < 0)}{digits[:-_DECIMAL_PLACES]}.{digits[-_DECIMAL_PLACES:]}"


class BallGeometry:
    """A body `r⁴ = 1 + 4 β sinθ cos(φ − P)`, `P = η + Σ a_k sin kη`, known by its exact decimals.

    Args:
        beta: Decimal of β, 0 < β < 0.25.
        coefficients: Decimals a_k by order k ≥ 1.
        com: Decimals of the centre of mass; the centroid if not given.

    Raises:
        BodyError: If the decimals do not describe such a body.
    """

    def __init__(self, beta: str, coefficients: Mapping[int, str], com: Decimals | None = None) -> None:
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
        self._given_com = None if com is None else tuple(decimal_ball(coordinate) for coordinate in com)
        self._bands: dict[tuple[int, int], _Band] = {}
        self._columns: dict[tuple[int, int], tuple[arb, arb, arb]] = {}

    @classmethod
    def of(cls, parameters: ExactParameters, com: Decimals | None = None) -> BallGeometry:
        """The geometry of a body by its exact parameters, about its centroid or another centre of mass.

        Raises:
            BodyError: If it is not a `sloan2` or `extended` body with 0 < β < 0.25.
        """
        if parameters.family not in CERTIFIED_FAMILIES or parameters.beta is None:
            raise BodyError(
                f"Certificates are made for the families {' and '.join(CERTIFIED_FAMILIES)}, not for "
                f"{parameters.family!r}; the census judges the others."
            )
        coefficients = {_order(key): a for key, a in parameters.coefficients.items()}
        if len(coefficients) < len(parameters.coefficients) or bool(coefficients) == (
            parameters.family == "sloan2"
        ):
            raise BodyError("Give each coefficient once, to the family extended and not to sloan2.")
        return cls(parameters.beta, coefficients, com)

    @cached_property
    def volume(self) -> arb:
        """Volume."""
        with ctx.workprec(_CENTROID_BITS):
            power = arb(7) / 4
            span = (1 + 4 * self.beta) ** power - (1 - 4 * self.beta) ** power
            return 2 * arb.pi() * span / (21 * self.beta)

    @cached_property
    def centroid_x(self) -> arb:
        """The x-coordinate of the centroid; y and z are zero."""

        def integrand(eta: acb, _: bool) -> acb:
            return sum((a * (k * eta).sin() for k, a in self._terms), eta).cos()

        with ctx.workprec(_CENTROID_BITS):
            # The integrand is even.
            half = acb.integral(integrand, 0, acb(arb.pi()), eval_limit=_MAX_EVALUATIONS).real
            return 4 * self.beta * half / (3 * self.volume)

    @cached_property
    def com(self) -> tuple[arb, arb, arb]:
        """The centre of mass that everything here is about."""
        if self._given_com is None:
            return self.centroid_x, arb(0), arb(0)
        x, y, z = self._given_com
        return x, y, z

    @property
    def com_on_axis(self) -> bool:
        """Whether half a turn about the x-axis leaves the centre of mass where it is."""
        _, y, z = self.com
        return bool(y == 0 and z == 0)

    def holds_ball(self, radius: arb) -> bool:
        """Whether a ball about the centre of mass certainly lies inside the body."""
        # Of their largest sizes: the square of a ball about zero may reach below zero.
        x, y, z = (abs(coordinate).upper() for coordinate in self.com)
        return bool((x * x + y * y + z * z).sqrt() + radius < self.inscribed_radius)

    @property
    def inscribed_radius(self) -> arb:
        """Radius of the largest ball about the origin inside the body."""
        return _fourth_root(1 - 4 * self.beta)

    def curvature_excess(self, cell: Cell, bound: arb) -> Form:
        """Second form less `bound` times the first: positive where both principal curvatures exceed it.

        Both forms are multiplied by s²/r², which changes no sign.
        """
        band, (cosine, sine, _) = self._band(cell), self._column(cell)
        tilt = self.beta * band.rho
        s = 1 + 4 * tilt * cosine
        g_theta, g_phi = self._gradient(band, cosine, sine)
        xx, xy, yy = g_theta * g_theta, g_theta * g_phi, g_phi * g_phi
        norm = _fourth_root(s) * (s * s + xx + yy).sqrt() / s
        diagonal, outer = bound * s * s, 5 / norm - bound
        return Form(
            s / norm * (1 + tilt * ((5 + band.rho_p * band.rho_p) * cosine + band.bend * sine))
            - diagonal
            + outer * xx,
            s / norm * self.beta * band.rho_p * cosine + outer * xy,
            s / norm * (1 + tilt * 5 * cosine + self.beta * band.z * band.rho_p * sine)
            - diagonal
            + outer * yy,
        )

    def gaussian_curvature(self, cell: Cell) -> arb:
        """Gaussian curvature: the ratio of the determinants of the two forms."""
        band, (cosine, sine, _) = self._band(cell), self._column(cell)
        s = 1 + 4 * self.beta * band.rho * cosine
        g_theta, g_phi = self._gradient(band, cosine, sine)
        first = s * s * (s * s + g_theta * g_theta + g_phi * g_phi)
        return self.curvature_excess(cell, arb(0)).determinant / first

    def pulls(self, cell: Cell) -> tuple[arb, arb]:
        """`t·F` for t = e_φ and for t = e_θ − q e_φ, along which the valley is straight."""
        band, (cosine, sine, psi) = self._band(cell), self._column(cell)
        s = 1 + 4 * self.beta * band.rho * cosine
        along, across, up = self._com_seen(psi + band.phase)
        lever = _fourth_root(s) - band.rho * along - band.z * up
        return (
            s * across - lever * self.beta * sine,
            lever * self.beta * band.z * cosine - s * (band.z * along - band.rho * up + band.q * across),
        )

    def keeps_focal_distance(self, cell: Cell, distance: arb) -> bool:
        """Whether certainly no centre of curvature of these points is that near to the centre of mass."""
        band, (cosine, sine, psi) = self._band(cell), self._column(cell)
        s = 1 + 4 * self.beta * band.rho * cosine
        along, across, up = self._com_seen(psi + band.phase)
        g_theta, g_phi = self._gradient(band, cosine, sine)
        f_phi, f_oblique = self.pulls(cell)
        squared = s * s
        g_oblique = self.beta * band.z * cosine
        if (
            abs(f_phi) > distance * (g_phi * g_phi + squared).sqrt()
            or abs(f_oblique) > distance * (g_oblique * g_oblique + squared * (1 + band.q * band.q)).sqrt()
        ):
            return True
        f_theta = f_oblique + band.q * f_phi
        normal = squared + g_theta * g_theta + g_phi * g_phi
        cross = g_theta * f_phi - g_phi * f_theta
        from_line = (squared * (f_theta * f_theta + f_phi * f_phi) + cross * cross) / (squared * normal)
        room = (distance * distance - from_line).upper()
        if room < 0:
            return True
        lever = s * (_fourth_root(s) - band.rho * along - band.z * up)
        height = (lever + g_theta * (band.z * along - band.rho * up) - g_phi * across) / normal.sqrt()
        if not height > room.sqrt():
            return False
        low, high = (self.curvature_excess(cell, 1 / (height + sign * room.sqrt())) for sign in (1, -1))
        between = low.determinant < 0 and high.determinant < 0
        return bool(high.is_positive() or low.is_negative() or between)

    def distance_hessian(self, cell: Cell) -> Form:
        """Second derivatives of `|x − c|²/2` in the coordinates (θ, ψ).

        A function with a definite matrix of second derivatives on a rectangle of the chart is strictly
        convex (or concave) there, so it has one critical point there at most.
        """
        band, (cosine, sine, psi) = self._band(cell), self._column(cell)
        z, rho, _, q, rho_p, bend = band
        s_t, s_p = 4 * self.beta * z * cosine, -4 * self.beta * rho * sine
        s_tt = s_pp = -4 * self.beta * rho * cosine
        s_tp = -4 * self.beta * z * sine
        s = 1 - s_tt
        r = _fourth_root(s)
        zero = arb(0)
        # Derivatives of u, outwards, eastwards and upwards, in a frame that turns with φ.
        u, u_t, u_p = (rho, zero, z), (z, -q, -rho), (zero, rho, zero)
        u_tt, u_tp, u_pp = (-rho * (1 + rho_p * rho_p), -rho * bend, -z), (q, z, zero), (-rho, zero, zero)
        along, across, up = self._com_seen(psi + band.phase)
        scale = r / (4 * s)

        def entry(s_i: arb, s_j: arb, s_ij: arb, u_i: _Triple, u_j: _Triple, u_ij: _Triple) -> arb:
            r_i, r_j = scale * s_i, scale * s_j
            r_ij = scale * (s_ij - 3 * s_i * s_j / (4 * s))
            outwards, eastwards, upwards = (
                r_ij * a + r_i * b + r_j * c + r * d for a, b, c, d in zip(u, u_j, u_i, u_ij, strict=True)
            )
            seen = along * outwards - across * eastwards + up * upwards
            return r * scale * (s_ij - s_i * s_j / (2 * s)) - seen

        return Form(
            entry(s_t, s_t, s_tt, u_t, u_t, u_tt),
            entry(s_t, s_p, s_tp, u_t, u_p, u_tp),
            entry(s_p, s_p, s_pp, u_p, u_p, u_pp),
        )

    def _com_seen(self, phi: arb) -> _Triple:
        """The centre of mass outwards at the azimuth φ, westwards and upwards."""
        x, y, z = self.com
        cosine, sine = phi.cos(), phi.sin()
        return x * cosine + y * sine, x * sine - y * cosine, z

    def _gradient(self, band: _Band, cosine: arb, sine: arb) -> tuple[arb, arb]:
        return self.beta * (band.z * cosine - band.q * sine), -self.beta * sine

    def _band(self, cell: Cell) -> _Band:
        key = cell.theta_low, cell.theta_high
        if key not in self._bands:
            self._bands[key] = self._make_band(_half_turns(*key))
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
        return _Band(z, rho, phase, rho * rho * p, rho * p, 3 * z * p - rho * rho * b)

    def _column(self, cell: Cell) -> tuple[arb, arb, arb]:
        key = cell.psi_low, cell.psi_high
        if key not in self._columns:
            psi = _half_turns(*key)
            self._columns[key] = arb.cos_pi(psi), arb.sin_pi(psi), psi * arb.pi()
        return self._columns[key]


def _order(key: str) -> int:
    if not re.fullmatch(r"[1-9]\d{0,3}", key, re.ASCII):
        raise BodyError(f"{key!r:.60} is not an order k of a Fourier term, a whole number such as 2.")
    return int(key)


_Triple = tuple[arb, arb, arb]


def _half_turns(low: int, high: int) -> arb:
    """The ball of an interval of angles, in half-turns; exact where the width is a power of two."""
    return arb(low + high, high - low) / (2 * TURN_UNITS)


def _fourth_root(value: arb) -> arb:
    return value.sqrt().sqrt()
