"""Families of shape functions f on the unit sphere; a body is `r⁴ = R₀⁴ (1 + 4 f)`.

Every family is evaluated through Cartesian components of the direction, never through θ and φ, so
the poles are ordinary points. A family extends f to a neighbourhood of the sphere in any convenient
way; the covariant derivatives on the sphere follow from the ambient ones and do not depend on the
extension: `∇f = P ∇G` and `∇²f = P (∇²G) P − (u·∇G) P` with `P = I − u uᵀ`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from gomboc_cad.body.sphere import Array
from gomboc_cad.errors import BodyError

ComplexArray = NDArray[np.complex128]

MAX_WINDING = 1000.0
"""Largest k |a_k| of a Fourier term; bodies of use have about one."""

MAX_HARMONIC_DEGREE = 40
"""Largest harmonic degree accepted; the first cells of the searches are too wide for finer undulations."""


class AmbientJet(NamedTuple):
    """Value, gradient (n, 3) and Hessian (n, 3, 3) of an ambient extension of f."""

    value: Array
    gradient: Array
    hessian: Array


class ShapeFunction(Protocol):
    """A function f on the unit sphere with two derivatives; `family` names its kind."""

    @property
    def family(self) -> str:
        """Name of the family as the command line spells it."""

    def ambient_jet(self, directions: Array) -> AmbientJet:
        """Evaluate an ambient extension at unit vectors, shape (n, 3)."""


def _azimuthal_jet(
    directions: Array, order: int, w: ComplexArray, dw: ComplexArray, ddw: ComplexArray
) -> AmbientJet:
    """Evaluate `Re[(x − i y)^m w(z)]` and its derivatives, m = `order`."""
    x, y, _ = directions.T
    zeta = x - 1j * y
    power = zeta**order
    first = order * zeta ** (order - 1) if order >= 1 else np.zeros_like(zeta)
    second = order * (order - 1) * zeta ** (order - 2) if order >= 2 else np.zeros_like(zeta)
    gradient = np.empty((len(x), 3))
    gradient[:, 0] = (first * w).real
    gradient[:, 1] = (first * w).imag
    gradient[:, 2] = (power * dw).real
    hessian = np.empty((len(x), 3, 3))
    hessian[:, 0, 0] = (second * w).real
    hessian[:, 1, 1] = -hessian[:, 0, 0]
    hessian[:, 0, 1] = hessian[:, 1, 0] = (second * w).imag
    hessian[:, 0, 2] = hessian[:, 2, 0] = (first * dw).real
    hessian[:, 1, 2] = hessian[:, 2, 1] = (first * dw).imag
    hessian[:, 2, 2] = (power * ddw).real
    return AmbientJet((power * w).real, gradient, hessian)


def _check_beta(beta: float) -> None:
    if not (math.isfinite(beta) and 0.0 <= beta < 0.25):
        raise BodyError(
            f"beta = {beta!r} is outside 0 ≤ beta < 0.25, where the radius stays real and positive."
        )


@dataclass(frozen=True)
class Sloan1:
    """Sloan's first body: `f = β sinθ cos(φ − 5θ)`, only C¹·¹ at the poles.

    With `cos 5θ = T₅(z)` and `sin 5θ = ρ U₄(z)`, `ρ = sqrt(x² + y²)`, the function is
    `β (x T₅(z) + y ρ U₄(z))`; the second derivatives of `y ρ` at a pole depend on the direction of
    approach, and there the limit along the x-axis is returned.

    Source: Sloan (2023) as given in arXiv 2604.17095, equation for "Gömböc 1".
    """

    beta: float

    def __post_init__(self) -> None:
        """Raise BodyError if β is not a usable amplitude."""
        _check_beta(self.beta)

    @property
    def family(self) -> str:
        """Name of the family."""
        return "sloan1"

    def ambient_jet(self, directions: Array) -> AmbientJet:
        """Evaluate at unit vectors (n, 3)."""
        x, y, z = directions.T
        rho = np.hypot(x, y)
        at_pole = rho == 0.0
        safe = np.where(at_pole, 1.0, rho)
        cx = np.where(at_pole, 1.0, x / safe)
        cy = np.where(at_pole, 0.0, y / safe)
        z2 = z * z
        t5, dt5, ddt5 = z * (5 + z2 * (-20 + 16 * z2)), 5 + z2 * (-60 + 80 * z2), z * (-120 + 320 * z2)
        u4, du4, ddu4 = 1 + z2 * (-12 + 16 * z2), z * (-24 + 64 * z2), -24 + 192 * z2
        value = x * t5 + y * rho * u4
        gradient = np.stack(
            [t5 + rho * cx * cy * u4, rho * (1 + cy * cy) * u4, x * dt5 + y * rho * du4], axis=-1
        )
        hessian = np.empty((len(x), 3, 3))
        hessian[:, 0, 0] = cy**3 * u4
        hessian[:, 1, 1] = (3 * cy - cy**3) * u4
        hessian[:, 0, 1] = hessian[:, 1, 0] = cx**3 * u4
        hessian[:, 0, 2] = hessian[:, 2, 0] = dt5 + rho * cx * cy * du4
        hessian[:, 1, 2] = hessian[:, 2, 1] = rho * (1 + cy * cy) * du4
        hessian[:, 2, 2] = x * ddt5 + y * rho * ddu4
        return AmbientJet(self.beta * value, self.beta * gradient, self.beta * hessian)


@dataclass(frozen=True)
class FourierSloan:
    """Sloan's second body and its Fourier extension: `f = β sinθ cos(φ − P)`.

    `P = η + Σ a_k sin(kη)` with `η = (3π/2)(cosθ − cos³θ/3)`; without terms it is Sloan 2.

    Attributes:
        beta: Amplitude β, 0 ≤ β < 0.25.
        terms: Pairs (k, a_k) of integer order and coefficient.

    Source: arXiv 2604.17095, equations for "Gömböc 2" and for the extended phase.
    """

    beta: float
    terms: tuple[tuple[int, float], ...] = ()

    def __post_init__(self) -> None:
        """Raise BodyError if an amplitude or an order is not usable."""
        _check_beta(self.beta)
        orders = [k for k, _ in self.terms]
        if len(set(orders)) != len(orders):
            raise BodyError("Each Fourier order k may be given once only.")
        for k, a in self.terms:
            if not isinstance(k, int) or k < 1 or not k * abs(a) <= MAX_WINDING:
                raise BodyError(
                    f"Fourier term k = {k!r}, a = {a!r} needs an integer order k ≥ 1 and a finite a with "
                    f"k |a| ≤ {MAX_WINDING:g}."
                )

    @property
    def family(self) -> str:
        """Name of the family: `sloan2` without terms, else `extended`."""
        return "extended" if self.terms else "sloan2"

    def ambient_jet(self, directions: Array) -> AmbientJet:
        """Evaluate at unit vectors (n, 3)."""
        z = directions[:, 2]
        eta = 1.5 * np.pi * (z - z**3 / 3.0)
        deta = 1.5 * np.pi * (1.0 - z * z)
        ddeta = -3.0 * np.pi * z
        phase, slope, bend = eta.copy(), np.ones_like(z), np.zeros_like(z)
        for k, a in self.terms:
            sine, cosine = np.sin(k * eta), np.cos(k * eta)
            phase += a * sine
            slope += a * k * cosine
            bend -= a * k * k * sine
        dphase = slope * deta
        ddphase = slope * ddeta + bend * deta * deta
        w = self.beta * np.exp(1j * phase)
        return _azimuthal_jet(directions, 1, w, 1j * dphase * w, (1j * ddphase - dphase**2) * w)


@dataclass(frozen=True)
class Harmonic:
    """`f = Σ c_lm Y_lm` with real orthonormal spherical harmonics of degree l ≥ 2.

    `m > 0` goes with cos(mφ), `m < 0` with sin(|m|φ), without the Condon–Shortley sign. Without
    degree 1 the homogeneous centroid is at the origin by construction.

    Attributes:
        terms: Pairs ((l, m), c_lm).
    """

    terms: tuple[tuple[tuple[int, int], float], ...] = ()

    def __post_init__(self) -> None:
        """Raise BodyError if a term is not usable."""
        indices = [lm for lm, _ in self.terms]
        if len(set(indices)) != len(indices):
            raise BodyError("Each harmonic (l, m) may be given once only.")
        for (degree, order), c in self.terms:
            if not 2 <= degree <= MAX_HARMONIC_DEGREE or abs(order) > degree or not math.isfinite(c):
                raise BodyError(
                    f"Harmonic term l = {degree}, m = {order}, c = {c!r} needs "
                    f"2 ≤ l ≤ {MAX_HARMONIC_DEGREE}, |m| ≤ l and a finite c."
                )

    @property
    def family(self) -> str:
        """Name of the family."""
        return "harmonic"

    @cached_property
    def _profiles(self) -> tuple[tuple[int, ComplexArray], ...]:
        """Coefficients of the complex profile w_m(z) by degree, for each azimuthal order m."""
        profiles: dict[int, ComplexArray] = {}
        for (degree, order), c in self.terms:
            m = abs(order)
            profile = profiles.setdefault(m, np.zeros(MAX_HARMONIC_DEGREE + 1, dtype=complex))
            profile[degree] += c * (math.sqrt(2.0) if m else 1.0) * (1j if order < 0 else 1.0)
        return tuple(sorted((m, np.trim_zeros(p, "b")) for m, p in profiles.items()))

    def ambient_jet(self, directions: Array) -> AmbientJet:
        """Evaluate at unit vectors (n, 3)."""
        n = len(directions)
        z = directions[:, 2]
        total = AmbientJet(np.zeros(n), np.zeros((n, 3)), np.zeros((n, 3, 3)))
        for m, profile in self._profiles:
            degrees = np.arange(len(profile))
            first = profile * np.sqrt(np.maximum(0, (degrees - m) * (degrees + m + 1)))
            second = first * np.sqrt(np.maximum(0, (degrees - m - 1) * (degrees + m + 2)))
            w, dw, ddw = (_profile(z, m + d, series) for d, series in enumerate((profile, first, second)))
            jet = _azimuthal_jet(directions, m, w, dw, ddw)
            total = AmbientJet(*(a + b for a, b in zip(total, jet, strict=True)))
        return total


def _profile(z: Array, order: int, series: ComplexArray) -> ComplexArray:
    """Sum `c_l N_lm P_l^(m)(z)` over the degrees l, P^(m) the m-th derivative, N_lm the normalisation.

    By the recurrence over l, which keeps all digits; the derivative in z has the same form with m + 1
    and c_l sqrt((l − m)(l + m + 1)).
    """
    total = np.zeros(z.shape, dtype=complex)
    before = np.zeros_like(z)
    k = np.arange(1, order + 1)
    current = np.full_like(z, math.sqrt(np.prod((2 * k + 1) / (2 * k)) / (4.0 * math.pi)))
    beta = 0.0
    for degree in range(order, len(series)):
        if series[degree] != 0.0:
            total += series[degree] * current
        alpha = math.sqrt((degree + 1 - order) * (degree + 1 + order) / ((2 * degree + 1) * (2 * degree + 3)))
        before, current = current, (z * current - beta * before) / alpha
        beta = alpha
    return total
