"""Form error as real spherical harmonics `δ(v) = Σ c_k Y_k(v)`, with two derivatives on the sphere.

The Y_k have degrees l = 2 … N in the order (l = 2: m = −l … l), (l = 3: …) and mean square 1 over the sphere,
so a coefficient is the root mean square of its term. m > 0 goes with cos(mφ), m < 0 with sin(|m|φ), without
the Condon–Shortley sign.

Y_lm is the real or imaginary part of `(x + i y)^|m|` times the m-th derivative of a Legendre polynomial of z,
but for a factor. So everything is polynomial in x, y and z, and the poles are ordinary points.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gomboc_cad.body.sphere import Array, IntArray, geodesic_triangulation, tangent_frame
from gomboc_cad.errors import GombocError

LOWEST_DEGREE = 2
_CHUNK = 256
"""Points at a time: the table of a chunk fits into the cache of a core."""

_FEW = 512
"""The same where every single harmonic is wanted."""

_BEND_ROWS = 64
"""Form errors at a time; fixed, so that every one is multiplied alike."""

_COVERING_ANGLE = 0.81
"""No place is farther from a vertex of a geodesic grid than this angle in radians, halved at each level."""


def coefficient_count(degree: int) -> int:
    """Number of harmonics of degrees 2 to N."""
    return max(0, (degree + 1) ** 2 - LOWEST_DEGREE**2)


def highest_degree(count: int) -> int:
    """Highest degree N of a form error with so many coefficients; 1 if there are none.

    Raises:
        GombocError: If no N has this number of coefficients.
    """
    degree = math.isqrt(count + LOWEST_DEGREE**2) - 1
    if coefficient_count(degree) != count:
        raise GombocError(
            f"A form error of degrees 2 to N has (N + 1)² − 4 coefficients; {count} is no such number."
        )
    return degree


def degrees_and_orders(degree: int) -> IntArray:
    """Degree l and order m of each harmonic, in order, shape (K, 2)."""
    pairs = [(n, m) for n in range(LOWEST_DEGREE, degree + 1) for m in range(-n, n + 1)]
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


class FormError(NamedTuple):
    """A form error at normals.

    Attributes:
        value_mm: δ, shape (n,).
        gradient_mm: ∇δ as a tangent vector in space, shape (n, 3).
    """

    value_mm: Array
    gradient_mm: Array


def form_error(normals: Array, coefficients_mm: Array) -> FormError:
    """Form error at outward unit normals.

    Args:
        normals: Shape (n, 3).
        coefficients_mm: Those of one body, shape (K,), or one row per normal, shape (n, K).
    """
    frame = np.stack(tangent_frame(normals), axis=1)
    jet = form_jets(normals, frame, coefficients_mm)
    return FormError(jet[0], jet[1, :, None] * frame[:, 0] + jet[2, :, None] * frame[:, 1])


def form_jets(normals: Array, frame: Array, coefficients_mm: Array) -> Array:
    """Value, gradient and Hessian of form errors in tangent frames, shape (6, n); see `FormErrors.jets`.

    Args:
        normals: Unit vectors, shape (n, 3).
        frame: Tangent vectors as rows, shape (n, 2, 3).
        coefficients_mm: Those of one body, shape (K,), or one row per normal, shape (n, K).
    """
    one = coefficients_mm.ndim == 1
    rows = np.zeros(len(normals), dtype=np.int64) if one else np.arange(len(normals))
    return FormErrors.of(np.atleast_2d(coefficients_mm)).jets(rows, normals, frame)


@dataclass(frozen=True, eq=False)
class FormErrors:
    """Form errors of several bodies, prepared for evaluation.

    Attributes:
        weights: Factors of `Re[(x + i y)^m] P_l^(m)(z)` and of the imaginary part, shape (2, N + 1, N + 1,
            bodies).
    """

    weights: Array

    @classmethod
    def of(cls, coefficients_mm: Array) -> FormErrors:
        """Prepare form errors with coefficients of shape (bodies, K)."""
        degree = highest_degree(coefficients_mm.shape[1])
        weights = np.zeros((2, degree + 1, degree + 1, len(coefficients_mm)))
        for k, (n, m) in enumerate(degrees_and_orders(degree).tolist()):
            weights[int(m < 0), n, abs(m)] = _norm(n, abs(m)) * coefficients_mm[:, k]
        return cls(weights)

    def jets(self, bodies: IntArray, normals: Array, frame: Array) -> Array:
        """Value, gradient and Hessian in tangent frames.

        Args:
            bodies: Which body, shape (n,).
            normals: Unit vectors, shape (n, 3).
            frame: Tangent vectors as rows, shape (n, 2, 3).

        Returns:
            Rows δ, ∂₁δ, ∂₂δ, ∇²δ₁₁, ∇²δ₁₂, ∇²δ₂₂, shape (6, n).
        """
        degree = self.weights.shape[1] - 1
        result = np.zeros((6, len(normals)))
        if degree < LOWEST_DEGREE:
            return result
        for start in range(0, len(normals), _CHUNK):
            part = slice(start, start + _CHUNK)
            table = _Table.at(normals[part], degree)
            cosine, sine = self.weights[..., bodies[part]]
            columns = [table.legendre[:, k : k + degree + 1] for k in range(3)]
            wc = [np.einsum("lmn,lmn->mn", cosine, column) for column in columns]
            ws = [np.einsum("lmn,lmn->mn", sine, column) for column in columns]
            jet = np.stack([row.sum(axis=0) for row in table.azimuthal(wc, ws)])
            result[:, part] = _in_frame(jet, normals[part], frame[part])
        return result


def harmonic_jets(normals: Array, frame: Array, degree: int) -> Array:
    """The same six rows for every single harmonic, shape (6, K, n)."""
    result = np.zeros((6, coefficient_count(degree), len(normals)))
    if degree >= LOWEST_DEGREE:
        for part in _parts(len(normals)):
            for columns, rows in _single_harmonics(normals[part], degree):
                result[:, columns, part] = _in_frame(np.stack(list(rows)), normals[part], frame[part])
    return result


def harmonic_slopes(normals: Array, degree: int) -> Array:
    """Gradients in space of extensions of every single harmonic, shape (K, 3, n).

    Only their tangential parts are those of the harmonics.
    """
    result = np.zeros((coefficient_count(degree), 3, len(normals)))
    if degree >= LOWEST_DEGREE:
        for part in _parts(len(normals)):
            for columns, rows in _single_harmonics(normals[part], degree):
                for axis, row in enumerate(islice(rows, 1, 4)):
                    result[columns, axis, part] = row
    return result


def _parts(count: int) -> list[slice]:
    """Slices of so many points whose tables fit into the cache of a core."""
    return [slice(start, start + _FEW) for start in range(0, count, _FEW)]


def _single_harmonics(normals: Array, degree: int) -> Iterator[tuple[IntArray, Iterator[Array]]]:
    """Columns k of cosine and sine harmonics; their value and derivatives in space, (columns, n) each."""
    table = _Table.at(normals, degree)
    pairs = degrees_and_orders(degree)
    for sine in (False, True):
        columns = np.flatnonzero((pairs[:, 1] < 0) == sine)
        degrees, orders = pairs[columns, 0], np.abs(pairs[columns, 1])
        norm = np.array([_norm(n, m) for n, m in zip(degrees.tolist(), orders.tolist(), strict=True)])
        profiles = [norm[:, None] * table.legendre[degrees, orders + k] for k in range(3)]
        yield columns, table.azimuthal_of(orders, profiles, sine)


def derivative_bounds_mm(coefficients_mm: Array) -> Array:
    """Upper bounds of |δ| and of its first four derivatives along any direction, everywhere.

    By the addition theorem `Σ_m Y_lm(v) Y_lm(w) = (2l + 1) P_l(v·w)`, so that a term of degree l with the
    coefficients c_l has `|∂^k δ_l|² ≤ |c_l|² (2l + 1) |d^2k P_l(cosγ)/dγ^2k|` at γ = 0. The degrees are
    added.

    Args:
        coefficients_mm: Shape (n, K).

    Returns:
        Shape (n, 5).
    """
    degree = highest_degree(coefficients_mm.shape[1])
    result = np.zeros((len(coefficients_mm), 5))
    for n in range(LOWEST_DEGREE, degree + 1):
        columns = slice(n * n - LOWEST_DEGREE**2, (n + 1) ** 2 - LOWEST_DEGREE**2)
        size = np.sqrt((coefficients_mm[:, columns] ** 2).sum(axis=1))
        result += size[:, None] * _largest_derivatives(n)
    return result


def largest_bends_mm(coefficients_mm: Array) -> Array:
    """Upper bounds of the second derivative of form errors along any direction, tighter than by degree, (n,).

    A trigonometric polynomial of degree N falls within an angle r of its maximum to cos(N r) of it at most
    (M. Riesz), so samples that leave no gap wider than r tell the maximum. The second derivative is that of a
    turn about a fixed axis, which differs from the covariant one by the slope times the distance at most.
    """
    count, size = coefficients_mm.shape
    degree = highest_degree(size)
    if degree < LOWEST_DEGREE:
        return np.zeros(count)
    bends, spacing = _bend_samples(degree)
    largest = np.empty(count)
    for start in range(0, count, _BEND_ROWS):
        rows = np.zeros((_BEND_ROWS, size), dtype=np.float32)
        part = coefficients_mm[start : start + _BEND_ROWS]
        rows[: len(part)] = part
        h11, h12, h22 = (rows @ bends).reshape(_BEND_ROWS, 3, -1).transpose(1, 0, 2)
        bend = 0.5 * np.abs(h11 + h22) + np.hypot(0.5 * (h11 - h22), h12)
        largest[start : start + len(part)] = bend.max(axis=1)[: len(part)]
    by_degree = derivative_bounds_mm(coefficients_mm)
    sampled = (1.0 + 1e-4) * (largest + spacing * by_degree[:, 1]) / math.cos(degree * spacing)
    return np.minimum(sampled, by_degree[:, 2])


@lru_cache(maxsize=4)
def _bend_samples(degree: int) -> tuple[NDArray[np.float32], float]:
    """Second derivatives of every harmonic at the vertices of a geodesic grid, and its covering angle."""
    level = max(4, math.ceil(math.log2(degree * _COVERING_ANGLE)))
    vertices = geodesic_triangulation(level)[0]
    frame = np.stack(tangent_frame(vertices), axis=1)
    bends = harmonic_jets(vertices, frame, degree)[3:].transpose(1, 0, 2)
    flat = np.ascontiguousarray(bends.reshape(len(bends), -1), dtype=np.float32)
    return flat, _COVERING_ANGLE / 2**level


@lru_cache(maxsize=64)
def _largest_derivatives(degree: int) -> Array:
    """Largest k-th derivative, k = 0 … 4, of a term of one degree with |c_l| = 1.

    From `P_l(cosγ) = Σ_j g_j g_(l−j) cos((l − 2j)γ)` with `g_j = C(2j, j)/4^j`.
    """
    g = [math.comb(2 * j, j) / 4**j for j in range(degree + 1)]
    weights = np.array([g[j] * g[degree - j] for j in range(degree + 1)])
    frequency = degree - 2.0 * np.arange(degree + 1)
    powers = np.array([weights @ frequency ** (2 * k) for k in range(5)])
    result: Array = np.sqrt((2 * degree + 1) * powers)
    return result


def _norm(degree: int, order: int) -> float:
    """Factor that gives mean square 1 over the sphere to `Re[(x + i y)^m] P_l^(m)(z)`."""
    ratio = math.factorial(degree - order) / math.factorial(degree + order)
    return math.sqrt((2.0 if order else 1.0) * (2 * degree + 1) * ratio)


class _Table(NamedTuple):
    """What harmonics are made of at n places.

    Attributes:
        legendre: `P_l^(m)(z)` for l = 0 … N and m = 0 … N + 2, shape (N + 1, N + 3, n).
        powers: Real and imaginary part of (x + i y)^m and of its first two derivatives in x, each of them for
            m = 0 … N, shape (3, 2, N + 1, n).
    """

    legendre: Array
    powers: Array

    @classmethod
    def at(cls, normals: Array, degree: int) -> _Table:
        """The table at unit vectors (n, 3)."""
        x, y, z = np.ascontiguousarray(normals.T)
        powers = np.zeros((3, 2, degree + 1, len(z)))
        powers[0, 0, 0] = 1.0
        for m in range(1, degree + 1):
            real, imaginary = powers[0, :, m - 1]
            powers[0, 0, m], powers[0, 1, m] = x * real - y * imaginary, x * imaginary + y * real
        orders = np.arange(degree + 1)[:, None]
        powers[1, :, 1:] = orders[1:] * powers[0, :, :-1]
        powers[2, :, 1:] = orders[1:] * powers[1, :, :-1]
        return cls(_legendre(z, degree), powers)

    def azimuthal_of(self, orders: IntArray, profile: Sequence[Array], imaginary: bool) -> Iterator[Array]:
        """Rows of `azimuthal` for harmonics that have a real or an imaginary part only.

        Args:
            orders: Order m of each, shape (k,).
            profile: Profile and its first two derivatives in z, each of shape (k, n).
            imaginary: Whether it is the imaginary part of (x + i y)^m that they have.
        """
        # Im ζ^m = Re(−i ζ^m).
        for a, b, p in (
            (0, 0, 0),
            (1, 0, 0),
            (1, 1, 0),
            (0, 0, 1),
            (2, 0, 0),
            (2, 1, 0),
            (1, 0, 1),
            (1, 1, 1),
            (0, 0, 2),
        ):
            part = self.powers[a, b ^ imaginary, orders]
            yield part * profile[p] if not b or imaginary else -part * profile[p]

    def azimuthal(self, wc: Sequence[Array], ws: Sequence[Array]) -> Iterator[Array]:
        """`Re[(x + i y)^m] wc(z) + Im[(x + i y)^m] ws(z)` and its derivatives in space, for each m.

        Args:
            wc: Profile of the real part and its first two derivatives in z, each of the shape of the powers.
            ws: The same of the imaginary part.

        Yields:
            The value, x, y, z, xx (which is −yy), xy, xz, yz, zz.
        """
        (a, b), (a1, b1), (a2, b2) = self.powers
        yield a * wc[0] + b * ws[0]
        yield a1 * wc[0] + b1 * ws[0]
        yield a1 * ws[0] - b1 * wc[0]
        yield a * wc[1] + b * ws[1]
        yield a2 * wc[0] + b2 * ws[0]
        yield a2 * ws[0] - b2 * wc[0]
        yield a1 * wc[1] + b1 * ws[1]
        yield a1 * ws[1] - b1 * wc[1]
        yield a * wc[2] + b * ws[2]


def _legendre(z: Array, degree: int) -> Array:
    """Derivatives `P_l^(m)(z)` of Legendre polynomials, shape (N + 1, N + 3, n).

    `(l + 1 − m) P_(l+1)^(m) = (2l + 1) z P_l^(m) − (l + m) P_(l−1)^(m)`, from `P_m^(m) = (2m − 1)!!`.
    """
    result = np.zeros((degree + 1, degree + 3, len(z)))
    result[0, 0] = 1.0
    for n in range(degree):
        m = np.arange(n + 1)[:, None]
        result[n + 1, : n + 1] = (2 * n + 1) / (n + 1 - m) * (z * result[n, : n + 1])
        if n > 0:
            result[n + 1, : n + 1] -= (n + m) / (n + 1 - m) * result[n - 1, : n + 1]
        result[n + 1, n + 1] = (2 * n + 1) * result[n, n]
    return result


def _in_frame(jet: Array, normals: Array, frame: Array) -> Array:
    """Covariant derivatives in tangent frames from those of an extension to space.

    `∇f = P ∇G` and `∇²f = P (∇²G) P − (v·∇G) P` with `P = I − v vᵀ`.
    """
    value, x, y, z, xx, xy, xz, yz, zz = jet
    vx, vy, vz = normals.T
    radial = vx * x + vy * y + vz * z
    (ax, ay, az), (bx, by, bz) = frame[:, 0].T, frame[:, 1].T
    # The Hessian in space applied to each of the two tangent vectors.
    hax, hay, haz = ax * xx + ay * xy + az * xz, ax * xy - ay * xx + az * yz, ax * xz + ay * yz + az * zz
    hbx, hby, hbz = bx * xx + by * xy + bz * xz, bx * xy - by * xx + bz * yz, bx * xz + by * yz + bz * zz
    return np.stack(
        [
            value,
            ax * x + ay * y + az * z,
            bx * x + by * y + bz * z,
            ax * hax + ay * hay + az * haz - radial,
            bx * hax + by * hay + bz * haz,
            bx * hbx + by * hby + bz * hbz - radial,
        ]
    )
