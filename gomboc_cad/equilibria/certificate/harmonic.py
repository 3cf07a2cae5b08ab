"""Ball geometry of a body `r⁴ = 1 + 4 f` with `f = Σ c_lm Y_lm` of degree l ≥ 2.

Everything is a finite sum over the azimuthal orders m,
    `f = Re Σ v_m(θ) e^{−imφ}` with `v_m = ρ^m w_m(z)` and polynomials w_m,
and in the chart the same with `V_m = v_m e^{−imP}`, which depend on θ alone. So a cell needs a product of two
small matrices: what its interval of θ gives (`meridian.py`), times cos mψ and sin mψ. All numbers are affine
ones: where valley and ridge have nearly the same margin all along, balls alone would need far too many cells.

Chart
    `P = Σ p_k z^k` with any decimals p_k. It decides how many cells a proof needs, not whether it holds.

Derivatives in the orthonormal frame (e_θ, e_φ), each the real part of a sum over m with the factor e^{−imφ};
a prime is d/dθ, and nothing is divided by ρ, so the poles are no exception:
    `∇f`: `v'`, `−i (mρ^{m−1} w)`;
    `∇²f`: `v''`, `−i (mρ^{m−1} w)'`, `−m(m−1) ρ^{m−2} w − mρ^m w − zρ^m dw/dz`.

Centroid
    `∫ r⁴ u dω / 4V = ∫ f u dω / V = 0`, since f has no component of degree 1: the centroid is the origin.

Volume
    `V = ∫ (1 + 4f)^{3/4} dω / 3`. The binomial series is cut off after some power, with a bound on the rest;
    what is left is a polynomial, which a Gauss–Legendre rule in z and equal steps in φ integrate exactly.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cached_property, lru_cache

from flint import acb, acb_poly, arb, arb_mat, arb_poly, ctx, fmpq_poly

from gomboc_cad.body.catalogue import ExactParameters
from gomboc_cad.body.families import MAX_HARMONIC_DEGREE
from gomboc_cad.equilibria.certificate.affine import SQUARED, UNIT, Affine
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
from gomboc_cad.equilibria.certificate.meridian import SERIES_BITS, Band, make_band
from gomboc_cad.equilibria.certificate.records import TURN_UNITS, Cell, Decimals
from gomboc_cad.errors import BodyError

MAX_CHART_DEGREE = 40
"""Largest degree of the chart's polynomial."""

_KEPT_BANDS = 1_000
_BANDS_OF_THE_BOUND = 128
_VOLUME_ERROR = 1e-12
_LARGEST_POWER = 24


class HarmonicGeometry(BallGeometry[Affine]):
    """A body of the family `harmonic`, known by its exact decimals.

    Args:
        coefficients: Decimals c_lm by (l, m), as in `families.Harmonic`.
        chart: Decimals of the chart's polynomial by rising powers of z.
        com: Decimals of the centre of mass; the centroid if not given.

    Raises:
        BodyError: If the decimals do not describe such a body, or its surface is not certainly one.
    """

    def __init__(
        self,
        coefficients: Mapping[tuple[int, int], str],
        chart: tuple[str, ...] = (),
        com: Decimals | None = None,
    ) -> None:
        super().__init__(com)
        if not coefficients:
            raise BodyError("A certificate of a harmonic body needs at least one coefficient l,m = c.")
        if len(chart) > MAX_CHART_DEGREE + 1:
            raise BodyError(f"The chart of a certificate has at most {MAX_CHART_DEGREE + 1} coefficients.")
        self._indices = tuple(coefficients)
        with ctx.workprec(SERIES_BITS):
            self._phase = arb_poly([decimal_ball(p) for p in chart])
            self._profiles = _profiles({lm: decimal_ball(c) for lm, c in coefficients.items()})
        # Made here, so that each geometry has a memory of its own.
        self._band = lru_cache(_KEPT_BANDS)(self._make_band)
        self._sums = lru_cache(1)(self._make_sums)
        self._column = lru_cache(_KEPT_BANDS)(self._make_column)
        if not self._largest_4f < 1:
            raise BodyError("The coefficients are too large for a certificate: 4 |f| must stay below 1.")

    @classmethod
    def of(
        cls, parameters: ExactParameters, com: Decimals | None = None, chart: tuple[str, ...] = ()
    ) -> HarmonicGeometry:
        """The geometry of a `harmonic` body by its exact parameters.

        Raises:
            BodyError: If the parameters are not those of such a body.
        """
        coefficients = {_degree_and_order(key): c for key, c in parameters.coefficients.items()}
        if parameters.beta is not None or len(coefficients) < len(parameters.coefficients):
            raise BodyError("The harmonic family takes no beta, and each coefficient once.")
        return cls(coefficients, chart, com)

    @property
    def centroid(self) -> Point:
        """The origin."""
        return arb(0), arb(0), arb(0)

    @property
    def inscribed_radius(self) -> arb:
        """Radius of a ball about the origin inside the body."""
        return (1 - self._largest_4f).sqrt().sqrt()

    @property
    def axis_is_symmetry(self) -> bool:
        """Whether half a turn about the x-axis maps the body to itself, and the axis is at ψ = 0 and π.

        It takes φ to −φ and z to −z.
        """
        return self._phase[0] == 0 and all((degree - m + (m < 0)) % 2 == 0 for degree, m in self._indices)

    @cached_property
    def volume(self) -> arb:
        """Volume."""
        with ctx.workprec(SERIES_BITS):
            largest, power, binomial = self._largest_4f.upper(), 0, [arb(1)]
            while power < _LARGEST_POWER and not abs(binomial[-1]) * largest**power < _VOLUME_ERROR:
                binomial.append(binomial[-1] * (arb(3) / 4 - power) / (power + 1))
                power += 1
            # The binomial coefficients of 3/4 fall in modulus.
            rest = abs(binomial[-1]) * largest ** (power + 1) / (1 - largest)
            series = arb_poly(binomial)
            mean = sum((weight * series(value) for weight, value in self._nodes_of_4f(power)), arb(0))
            return 4 * arb.pi() / 3 * (mean + rest * UNIT)

    def _nodes_of_4f(self, power: int) -> Iterator[tuple[arb, arb]]:
        """Weights and values of 4 f that give the mean of `(4f)^k` over the sphere for every k ≤ `power`."""
        rings = power * max(degree for degree, _ in self._indices) // 2 + 1
        turns = power * max(abs(m) for _, m in self._indices) + 1
        waves = arb_mat(
            [
                [wave(arb(2 * m * k) / turns) for k in range(turns)]
                for m in self._profiles
                for wave in (arb.cos_pi, arb.sin_pi)
            ]
        )
        for ring in range(rings):
            z, weight = arb.legendre_p_root(rings, ring, weight=True)
            rho = (1 - z * z).sqrt()
            amplitudes = [4 * rho**m * w(acb(z)) for m, w in self._profiles.items()]
            row = arb_mat([[part for v in amplitudes for part in (v.real, v.imag)]])
            for value in (row * waves).entries():
                yield weight / (2 * turns), value

    @cached_property
    def _largest_4f(self) -> arb:
        """A bound on |4f|: the amplitudes of all orders added up, at their largest in each of many bands."""
        step = TURN_UNITS // _BANDS_OF_THE_BOUND
        largest = arb(0)
        for low in range(0, TURN_UNITS, step):
            jet = self._band(low, low + step).jet
            amplitudes = (
                acb(*(jet[0, 2 * i + part] + UNIT * jet[1, 2 * i + part] for part in (0, 1)))
                for i in range(len(self._profiles))
            )
            largest = largest.max(sum((v.abs_upper() for v in amplitudes), arb(0)))
        return largest

    def _chart(self, cell: Cell) -> Chart[Affine]:
        return self._band(cell.theta_low, cell.theta_high).chart

    def _azimuth(self, cell: Cell) -> tuple[Affine, Affine]:
        cos_p, sin_p = self._band(cell.theta_low, cell.theta_high).phase
        cosine, sine = self._column(cell.psi_low, cell.psi_high)[1]
        return cos_p * cosine - sin_p * sine, sin_p * cosine + cos_p * sine

    def _relief(self, cell: Cell) -> Relief[Affine]:
        f, oblique, g_phi, *_ = self._sums(cell)
        return Relief(1 + 4 * f, oblique + self._chart(cell).q * g_phi, g_phi, oblique)

    def _bending(self, cell: Cell, factor: Affine) -> Form[Affine]:
        f, _, _, tt, tp, pp = self._sums(cell)
        s = 1 + 4 * f
        return Form(factor * (s - tt), factor * -tp, factor * (s - pp))

    def _jet(self, cell: Cell) -> Jet[Affine]:
        band = self._band(cell.theta_low, cell.theta_high)
        f4, *derivatives = _affine_sums(band.jet * self._column(cell.psi_low, cell.psi_high)[0])
        return Jet(1 + f4, *derivatives)

    def _make_sums(self, cell: Cell) -> list[Affine]:
        band = self._band(cell.theta_low, cell.theta_high)
        return _affine_sums(band.relief * self._column(cell.psi_low, cell.psi_high)[0])

    def _make_band(self, low: int, high: int) -> Band:
        return make_band(low, high, self._phase, self._profiles)

    def _make_column(self, low: int, high: int) -> tuple[arb_mat, tuple[Affine, Affine]]:
        """Value and change to the first order of cos mψ and sin mψ for each m, and of cos ψ and sin ψ."""
        turns = half_turns(low, high)
        rows = [model for m in self._profiles for model in _waves(m, turns)]
        cosine, sine = (Affine(value, arb(0), change) for value, change in _waves(1, turns))
        return arb_mat([list(row) for row in rows]), (cosine, sine)


def _waves(m: int, turns: arb) -> tuple[tuple[arb, arb], tuple[arb, arb]]:
    """First-order Taylor models of cos mψ and sin mψ on an interval of ψ in half-turns."""
    middle, half = turns.mid(), m * arb.pi() * turns.rad()
    rest = half * half / 2 * SQUARED
    cosine, sine = arb.cos_pi(m * middle), arb.sin_pi(m * middle)
    return (
        (cosine - rest * arb.cos_pi(m * turns), -half * sine),
        (sine - rest * arb.sin_pi(m * turns), half * cosine),
    )


def _affine_sums(product: arb_mat) -> list[Affine]:
    """Affine numbers from the products of models in θ (two rows each) and in ψ (two columns)."""
    entries = iter(product.entries())
    return [
        Affine(value + UNIT * both, theta, psi)
        for value, psi, theta, both in zip(entries, entries, entries, entries, strict=True)
    ]


def _profiles(coefficients: Mapping[tuple[int, int], arb]) -> dict[int, acb_poly]:
    """The polynomials w_m(z) by m: sums of derivatives of Legendre polynomials, scaled as in `families`."""
    profiles: dict[int, acb_poly] = {}
    for (degree, order), c in sorted(coefficients.items()):
        m = abs(order)
        norm = arb(2 * degree + 1) * arb.fac_ui(degree - m) / (4 * arb.pi() * arb.fac_ui(degree + m))
        factor = c * norm.sqrt() * (arb(2).sqrt() if m else 1)
        polynomial = fmpq_poly.legendre_p(degree)
        for _ in range(m):
            polynomial = polynomial.derivative()
        term = acb_poly(polynomial) * (acb(0, factor) if order < 0 else acb(factor))
        profiles[m] = profiles.get(m, acb_poly()) + term
    return profiles


def _degree_and_order(key: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,2}),(-?\d{1,2})", key, re.ASCII)
    degree, m = (int(number) for number in match.groups()) if match else (0, 0)
    if not 2 <= degree <= MAX_HARMONIC_DEGREE or abs(m) > degree:
        raise BodyError(
            f"{key!r:.60} is not a pair l,m of a harmonic with 2 ≤ l ≤ {MAX_HARMONIC_DEGREE} and |m| ≤ l."
        )
    return degree, m
