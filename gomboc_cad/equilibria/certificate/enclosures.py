"""Geometry of a body over a cell of directions, in ball arithmetic: what all families have in common.

Every number here holds the true value for every direction of the cell, rounding included: a ball (midpoint
and radius), or an `Affine` number of balls; python-flint (Arb) does the arithmetic. Lengths are in units of
the nominal radius R₀.

Chart
    A body `s = r⁴ = 1 + 4 f` is described in (θ, ψ) with `ψ = φ − P(z)`, `z = cosθ`, `ρ = sinθ`. For every z,
    ψ runs once round as φ does, so the rectangle 0 ≤ θ ≤ π, −π/2 ≤ ψ ≤ 3π/2 covers the sphere, whatever P
    is. With `p = P'(z)` and `q = ρ² p` the direction of constant ψ is `e_θ − q e_φ`.

Curvature
    With `g = ∇f` and `N = r sqrt(1 + |g|²/s²)` the second fundamental form is
    `r² (s² I + 5 g gᵀ − s ∇²f) / (s² N)` and the first one `r² (s² I + g gᵀ) / s²`, from `r = s^(1/4)`,
    in the orthonormal frame (e_θ, e_φ), at the poles too.

Equilibria about a centre of mass c, the centroid or any other,
    are the zeros of `F = (r − u·c) g − s c_T`, which is the gradient of `|x − c|²/2` times s/r.

Margin
    A centre of mass near c balances on a surface point if it lies on its normal line. Moving c by δ changes
    `t·F` by `δ sqrt((t·g)² + s²|t|²)` at most, and that line is as far from c as ℓ,
    `ℓ² = (s² |F|² + (g × F)²) / (s² (s² + |g|²))`. A centre of mass on it closer than δ has a height of
    `h ± sqrt(δ² − ℓ²)` over the tangent plane, with `h = (s r − s u·c + g·c_T) / sqrt(s² + |g|²)`, and the
    equilibrium is regular if one over its height is no principal curvature.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, Generic, NamedTuple, TypeVar

from flint import arb

from gomboc_cad.equilibria.certificate.affine import Affine
from gomboc_cad.equilibria.certificate.decimals import decimal_ball
from gomboc_cad.equilibria.certificate.records import TURN_UNITS, Cell, Decimals

PRECISION_BITS = 64
"""Working precision of the cells; their width, not the rounding, limits what can be proven."""

Point = tuple[arb, arb, arb]
B = TypeVar("B", arb, Affine)


class Form(NamedTuple, Generic[B]):
    """A symmetric 2 × 2 matrix."""

    xx: B
    xy: B
    yy: B

    @property
    def determinant(self: Form[Any]) -> Any:
        """Determinant, as a number of the same kind."""
        return self.xx * self.yy - self.xy * self.xy

    def is_positive(self: Form[Any]) -> bool:
        """Whether it is certainly positive definite."""
        return bool(self.xx > 0 and self.determinant > 0)

    def is_negative(self: Form[Any]) -> bool:
        """Whether it is certainly negative definite."""
        return bool(self.xx < 0 and self.determinant > 0)


class Chart(NamedTuple, Generic[B]):
    """The chart over a cell: z, ρ, q = ρ²p, ρp, and the second θ-derivative of u eastwards."""

    z: B
    rho: B
    q: B
    rho_p: B
    east_bend: B


class Relief(NamedTuple, Generic[B]):
    """`s`, and the components of ∇f along e_θ, e_φ and e_θ − q e_φ."""

    s: B
    g_theta: B
    g_phi: B
    g_oblique: B


class Jet(NamedTuple, Generic[B]):
    """`s` and its partial derivatives in the coordinates (θ, ψ)."""

    s: B
    t: B
    p: B
    tt: B
    tp: B
    pp: B


class BallGeometry(ABC, Generic[B]):
    """A body known by its exact decimals, about its centroid or another centre of mass.

    Args:
        com: Decimals of the centre of mass; the centroid if not given.

    Raises:
        BodyError: If they are no decimals.
    """

    def __init__(self, com: Decimals | None) -> None:
        self._given_com: Point | None = None
        if com is not None:
            x, y, z = (decimal_ball(coordinate) for coordinate in com)
            self._given_com = x, y, z

    @property
    @abstractmethod
    def volume(self) -> arb:
        """Volume."""

    @property
    @abstractmethod
    def centroid(self) -> Point:
        """Homogeneous centroid."""

    @property
    @abstractmethod
    def inscribed_radius(self) -> arb:
        """Radius of a ball about the origin inside the body."""

    @property
    @abstractmethod
    def axis_is_symmetry(self) -> bool:
        """Whether half a turn about the x-axis maps the body to itself, and the axis is at ψ = 0 and π."""

    @abstractmethod
    def _chart(self, cell: Cell) -> Chart[B]: ...

    @abstractmethod
    def _relief(self, cell: Cell) -> Relief[B]: ...

    @abstractmethod
    def _bending(self, cell: Cell, factor: B) -> Form[B]:
        """The form `s I − ∇²f` in the orthonormal frame, times a factor."""

    @abstractmethod
    def _jet(self, cell: Cell) -> Jet[B]: ...

    @abstractmethod
    def _azimuth(self, cell: Cell) -> tuple[B, B]:
        """Cosine and sine of φ."""

    @property
    def com(self) -> Point:
        """The centre of mass that everything here is about."""
        return self.centroid if self._given_com is None else self._given_com

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

    def curvature_excess(self, cell: Cell, bound: B | arb) -> Form[B]:
        """Second form less `bound` times the first: positive where both principal curvatures exceed it.

        Both forms are multiplied by s²/r², which changes no sign.
        """
        s, g_theta, g_phi, _ = self._relief(cell)
        xx, xy, yy = g_theta * g_theta, g_theta * g_phi, g_phi * g_phi
        norm = _fourth_root(s) * (s * s + xx + yy).sqrt() / s
        diagonal, outer = bound * s * s, 5 / norm - bound
        bending = self._bending(cell, s / norm)
        return Form(
            bending.xx - diagonal + outer * xx,
            bending.xy + outer * xy,
            bending.yy - diagonal + outer * yy,
        )

    def gaussian_curvature(self, cell: Cell) -> B:
        """Gaussian curvature: the ratio of the determinants of the two forms."""
        # s as a jet has it: the last digits of a witness depend on the order of the operations.
        s, (_, g_theta, g_phi, _) = self._jet(cell).s, self._relief(cell)
        first = s * s * (s * s + g_theta * g_theta + g_phi * g_phi)
        determinant: B = self.curvature_excess(cell, arb(0)).determinant
        return determinant / first

    def pulls(self, cell: Cell) -> tuple[B, B]:
        """`t·F` for t = e_φ and for t = e_θ − q e_φ, along which the chart holds ψ."""
        chart, relief = self._chart(cell), self._relief(cell)
        along, across, up = self._com_seen(cell)
        lever = _fourth_root(relief.s) - chart.rho * along - chart.z * up
        return (
            relief.s * across + lever * relief.g_phi,
            lever * relief.g_oblique - relief.s * (chart.z * along - chart.rho * up + chart.q * across),
        )

    def keeps_focal_distance(self, cell: Cell, distance: arb) -> bool:
        """Whether certainly no centre of curvature of these points is that near to the centre of mass."""
        chart, relief = self._chart(cell), self._relief(cell)
        s, g_theta, g_phi, g_oblique = relief
        along, across, up = self._com_seen(cell)
        f_phi, f_oblique = self.pulls(cell)
        squared = s * s
        reach_phi = distance * (g_phi * g_phi + squared).sqrt()
        reach_oblique = distance * (g_oblique * g_oblique + squared * (1 + chart.q * chart.q)).sqrt()
        if _exceeds(f_phi, reach_phi) or _exceeds(f_oblique, reach_oblique):
            return True
        f_theta = f_oblique + chart.q * f_phi
        normal = squared + g_theta * g_theta + g_phi * g_phi
        cross = g_theta * f_phi - g_phi * f_theta
        from_line = (squared * (f_theta * f_theta + f_phi * f_phi) + cross * cross) / (squared * normal)
        room = (distance * distance - from_line).upper()
        if room < 0:
            return True
        lever = s * (_fourth_root(s) - chart.rho * along - chart.z * up)
        slant = g_theta * (chart.z * along - chart.rho * up) - g_phi * across
        height = (lever + slant) / normal.sqrt()
        if not height > room.sqrt():
            return False
        low, high = (self.curvature_excess(cell, 1 / (height + sign * room.sqrt())) for sign in (1, -1))
        between = low.determinant < 0 and high.determinant < 0
        return bool(high.is_positive() or low.is_negative() or between)

    def distance_hessian(self, cell: Cell) -> Form[B]:
        """Second derivatives of `|x − c|²/2` in the coordinates (θ, ψ).

        A function with a definite matrix of second derivatives on a rectangle of the chart is strictly
        convex (or concave) there, so it has one critical point there at most.
        """
        z, rho, q, rho_p, east_bend = self._chart(cell)
        s, s_t, s_p, s_tt, s_tp, s_pp = self._jet(cell)
        r = _fourth_root(s)
        zero = 0 * rho
        # Derivatives of u, outwards, eastwards and upwards, in a frame that turns with φ.
        u, u_t, u_p = (rho, zero, z), (z, -q, -rho), (zero, rho, zero)
        u_tt, u_tp, u_pp = (-rho * (1 + rho_p * rho_p), east_bend, -z), (q, z, zero), (-rho, zero, zero)
        along, across, up = self._com_seen(cell)
        scale = r / (4 * s)

        def entry(
            s_i: B, s_j: B, s_ij: B, u_i: tuple[B, B, B], u_j: tuple[B, B, B], u_ij: tuple[B, B, B]
        ) -> B:
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

    def _com_seen(self, cell: Cell) -> tuple[B, B, arb]:
        """The centre of mass outwards at the azimuth φ, westwards and upwards."""
        x, y, z = self.com
        cosine, sine = self._azimuth(cell)
        return x * cosine + y * sine, x * sine - y * cosine, z


def half_turns(low: int, high: int) -> arb:
    """The ball of an interval of angles, in half-turns, its radius rounded up."""
    return arb(low + high, high - low) / (2 * TURN_UNITS)


def _exceeds(value: B, bound: B) -> bool:
    return bool(value > bound or -value > bound)


def _fourth_root(value: B) -> B:
    return value.sqrt().sqrt()
