"""Slope and stiffness of bodies as made, exactly, at any place of any of them.

With H the support function of the nominal body, δ the form error and S the stretch, the support function of
the body as made is `h(u) = (H + δ)(S u)`, the bracket extended to all of space as a function of degree one.
At the nominal surface point x(w) with normal v, the body as made has the point `S (x + ∇δ + δ v)` and the
normal `u = S⁻¹v / |S⁻¹v|`. A part that is displaced by d has its COM displaced by −d as seen from itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, BoolArray, IntArray
from gomboc_cad.tolerance.harmonics import FormErrors
from gomboc_cad.tolerance.variants import Variants

_LANES = 16
"""Points are evaluated in multiples of this, so that the same instructions serve each of them."""

_CHUNK = 2048


class Slopes(NamedTuple):
    """The height f of the COM over the table at n places of bodies as made; the place is the last index.

    Attributes:
        place: Surface point of the nominal body, shape (3, n).
        tangents: Its tangent frame, shape (2, 3, n).
        point: Point of the part before it is stretched and displaced, shape (3, n).
        normal: Outward normal u as made, shape (3, n).
        frame: Tangent frame at u, shape (2, 3, n).
        height: f, shape (n,).
        slope: ∇f in the frame, shape (2, n).
        hessian: ∇²f, components 11, 12, 22, shape (3, n).
        rate: Derivative A of the slope along the nominal surface, as rows 11, 12, 21, 22, shape (4, n).
    """

    place: Array
    tangents: Array
    point: Array
    normal: Array
    frame: Array
    height: Array
    slope: Array
    hessian: Array
    rate: Array

    def softest(self) -> Array:
        """Smaller eigenvalue of the Hessian, shape (n,)."""
        result: Array = self.stiffness()[0]
        return result

    def stiffness(self) -> Array:
        """Eigenvalues of the Hessian, the smaller first, shape (2, n)."""
        h11, h12, h22 = self.hessian
        mean, spread = 0.5 * (h11 + h22), np.hypot(0.5 * (h11 - h22), h12)
        return np.stack([mean - spread, mean + spread])

    def step(self) -> Array:
        """Newton step towards the next equilibrium, in the tangent frame of the nominal surface, (2, n)."""
        a11, a12, a21, a22 = self.rate
        g1, g2 = self.slope
        determinant = a11 * a22 - a12 * a21
        safe = np.where(determinant == 0.0, np.inf, determinant)
        return np.stack([(a12 * g2 - a22 * g1) / safe, (a21 * g1 - a11 * g2) / safe])

    def moved(self, step: Array) -> Array:
        """Directions w after a step (2, n) along the nominal surface, shape (n, 3)."""
        target = self.place + step[0] * self.tangents[0] + step[1] * self.tangents[1]
        result: Array = (target / np.sqrt((target * target).sum(axis=0))).T
        return result

    def rows(self, index: IntArray | BoolArray) -> Slopes:
        """Some of the places."""
        return Slopes(*(values[..., index] for values in self))


@dataclass(frozen=True, eq=False)
class MadeBodies:
    """Variants of a body, prepared for evaluation.

    Attributes:
        body: The nominal body.
        form: Their form errors.
        stretch: S, shape (3, 3, n).
        unstretch: Its inverse, shape (3, 3, n).
        com_mm: S⁻¹ c, shape (n, 3).
        upper_com_mm: The same as seen from the displaced upper part, S⁻¹ (c − d), shape (n, 3).
    """

    body: Body
    form: FormErrors
    stretch: Array
    unstretch: Array
    com_mm: Array
    upper_com_mm: Array

    @classmethod
    def of(cls, body: Body, variants: Variants) -> MadeBodies:
        """Prepare variants."""
        inverse: Array = np.linalg.inv(variants.stretch).astype(float, copy=False)
        return cls(
            body=body,
            form=FormErrors.of(variants.form_mm),
            stretch=np.ascontiguousarray(variants.stretch.transpose(1, 2, 0)),
            unstretch=np.ascontiguousarray(inverse.transpose(1, 2, 0)),
            com_mm=_applied(inverse, variants.com_mm),
            upper_com_mm=_applied(inverse, variants.com_mm - variants.upper_shift_mm),
        )

    def slopes(self, rows: IntArray, directions: Array, upper: BoolArray) -> Slopes:
        """Evaluate bodies at places.

        Args:
            rows: Which body, shape (n,).
            directions: Nominal surface parameters w, shape (n, 3).
            upper: Whether the surface of the displaced upper part is meant, shape (n,).
        """
        count = len(rows)
        padded = np.minimum(np.arange(-(-max(count, 1) // _LANES) * _LANES), count - 1)
        if count == 0:
            rows, directions, upper = np.zeros(1, dtype=np.int64), np.eye(3)[:1], np.zeros(1, dtype=bool)
            padded = np.zeros(_LANES, dtype=np.int64)
        parts = [
            self._slopes(rows[index], directions[index], upper[index])
            for index in (padded[i : i + _CHUNK] for i in range(0, len(padded), _CHUNK))
        ]
        joined = (np.concatenate(arrays, axis=-1)[..., :count] for arrays in zip(*parts, strict=True))
        return Slopes(*joined)

    def arms(self, rows: IntArray, points: Array, normals: Array, upper: BoolArray) -> tuple[Array, Array]:
        """From the COM to points of the parts as made, and normals as made, both of shape (3, n).

        Args:
            rows: Which body, shape (n,).
            points: Points of the part before it is stretched and displaced, shape (n, 3).
            normals: Normals v before the stretch, shape (n, 3).
            upper: Whether the point is on the displaced upper part, shape (n,).
        """
        com = np.where(upper[:, None], self.upper_com_mm[rows], self.com_mm[rows])
        arm = _image(self.stretch[:, :, rows], (points - com).T)
        u = _image(self.unstretch[:, :, rows], normals.T)
        return arm, u / _length(u)

    def _slopes(self, rows: IntArray, directions: Array, upper: BoolArray) -> Slopes:
        surface = self.body.surface(directions)
        tangents = np.ascontiguousarray(surface.tangents.transpose(1, 2, 0))
        place, v = np.ascontiguousarray(surface.position_mm.T), np.ascontiguousarray(surface.normal.T)
        jet = self.form.jets(rows, surface.normal, surface.tangents)
        point = place + jet[0] * v + jet[1] * tangents[0] + jet[2] * tangents[1]
        com = np.where(upper[:, None], self.upper_com_mm[rows], self.com_mm[rows]).T
        stretch = self.stretch[:, :, rows]
        arm = _image(stretch, point - com)
        u = _image(self.unstretch[:, :, rows], v)
        q = 1.0 / _length(u)
        u *= q
        # S carries the tangent plane of v to that of u; its image is made orthonormal.
        first, second = _image(stretch, tangents[0]), _image(stretch, tangents[1])
        l11 = _length(first)
        e1 = first / l11
        e2 = _cross(u, e1)
        l12, l22 = _dot(e1, second), _dot(e2, second)
        height = _dot(u, arm)
        slope = np.stack([_dot(e1, arm), _dot(e2, arm)])
        kappa = surface.shape_operator_per_mm
        k11, k12, k22 = kappa[:, 0, 0], kappa[:, 0, 1], kappa[:, 1, 1]
        gauss = k11 * k22 - k12 * k12
        w11 = k22 / gauss + jet[3] + jet[0]
        w12 = jet[4] - k12 / gauss
        w22 = k11 / gauss + jet[5] + jet[0]
        m12 = l11 * w12 + l12 * w22
        h11 = ((l11 * w11 + l12 * w12) * l11 + m12 * l12) / q - height
        h12 = m12 * l22 / q
        h22 = l22 * l22 * w22 / q - height
        # How the normal as made turns along the nominal surface: q L⁻ᵀ κ.
        b11, b12 = q * k11 / l11, q * k12 / l11
        b21, b22 = (q * k12 - l12 * b11) / l22, (q * k22 - l12 * b12) / l22
        rate = np.stack(
            [h11 * b11 + h12 * b21, h11 * b12 + h12 * b22, h12 * b11 + h22 * b21, h12 * b12 + h22 * b22]
        )
        return Slopes(
            place, tangents, point, u, np.stack([e1, e2]), height, slope, np.stack([h11, h12, h22]), rate
        )


def _applied(matrices: Array, vectors: Array) -> Array:
    """Matrices (n, 3, 3) times vectors (n, 3), in an order of summation that does not depend on n."""
    return _image(matrices.transpose(1, 2, 0), vectors.T).T


def _image(matrices: Array, vectors: Array) -> Array:
    """Matrices (3, 3, n) times vectors (3, n)."""
    result: Array = matrices[:, 0] * vectors[0] + matrices[:, 1] * vectors[1] + matrices[:, 2] * vectors[2]
    return result


def _dot(a: Array, b: Array) -> Array:
    result: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return result


def _length(a: Array) -> Array:
    result: Array = np.sqrt(_dot(a, a))
    return result


def _cross(a: Array, b: Array) -> Array:
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
