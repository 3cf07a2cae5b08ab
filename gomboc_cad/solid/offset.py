"""The analytic surfaces of a hollow body: the outer one, and the one a wall further in.

An inset surface is `x(u) − d n(u) + s`: every point of the body moved inwards along the normal by the
wall d, then everything moved rigidly by a shift s. It keeps the normals and the focal surface of the body,
so its distances, curvatures and volume integrals follow from those of the body without any fitting.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gomboc_cad.body import Body
from gomboc_cad.body.mass import MassProperties, sphere_quadrature
from gomboc_cad.body.sphere import Array, unit
from gomboc_cad.equilibria import convexity
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.errors import GeometryError

_NEWTON_STEPS = 12
_CHUNK = 16_384
"""Points at a time: so many that their arrays stay in the processor's cache."""

_QUADRATURE_ORDERS = (32, 64, 128, 256, 512)


@dataclass(frozen=True)
class InsetSurface:
    """A body's surface moved inwards by a constant distance, then rigidly.

    Attributes:
        body: The body.
        inset_mm: Distance d along the inward normal, 0 for the outer surface itself.
        shift_mm: Rigid displacement s.

    Raises:
        GeometryError: If d is negative, or not less than the smallest radius of curvature, where the
            surface would fold over itself.
    """

    body: Body
    inset_mm: float = 0.0
    shift_mm: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Refuse an inset at which the surface folds."""
        if not np.all(np.isfinite([self.inset_mm, *self.shift_mm])) or self.inset_mm < 0.0:
            raise GeometryError(
                f"The wall must be a positive length and the shift three lengths in mm, not "
                f"{self.inset_mm!r} and {self.shift_mm!r}."
            )
        if self.inset_mm == 0.0:
            return
        limit = convexity(self.body).min_radius_of_curvature_mm
        if self.inset_mm >= limit:
            raise GeometryError(
                f"The wall of {self.inset_mm:g} mm is thicker than the smallest inner radius allows: the "
                f"outer surface of {self.body.name!r} bends with a radius of {limit:.4g} mm at its sharpest "
                "place; make the wall thinner or the body larger."
            )

    def position_mm(self, directions: Array) -> Array:
        """Surface points at unit vectors (n, 3), shape (n, 3)."""
        if self.inset_mm == 0.0:
            return self.body.position_mm(directions) + np.asarray(self.shift_mm)
        return self.body.offset_mm(directions, self.inset_mm) + np.asarray(self.shift_mm)

    def normal(self, directions: Array) -> Array:
        """Outward unit normals at unit vectors (n, 3); those of the body."""
        return self.body.normal(directions)

    def signed_distance_mm(self, points_mm: Array, directions: Array | None = None) -> Array:
        """Distance of points near the surface, measured along its normal, positive outside.

        The foot of the perpendicular is found by Newton iteration with the shape operator, so the result is
        exact for points nearer to the surface than to its focal surface.

        Args:
            points_mm: Shape (n, 3).
            directions: Directions of nearby surface points to start from, shape (n, 3); by default those
                of the points themselves, seen from the shifted origin.

        Returns:
            Shape (n,).
        """
        start = unit(points_mm - np.asarray(self.shift_mm)) if directions is None else directions
        pieces = [
            self._distance(points_mm[i : i + _CHUNK], start[i : i + _CHUNK])
            for i in range(0, len(points_mm), _CHUNK)
        ]
        return np.concatenate(pieces) if pieces else np.empty(0)

    def _distance(self, points_mm: Array, directions: Array) -> Array:
        u = directions
        base = points_mm - np.asarray(self.shift_mm)
        for _ in range(_NEWTON_STEPS):
            here = self.body.surface(u)
            gap = base - here.position_mm + self.inset_mm * here.normal
            slip = np.einsum("nax,nx->na", here.tangents, gap)
            distance = np.einsum("nx,nx->n", gap, here.normal)
            # The error of the distance is of second order in the slip: here 2e-11 of the size.
            if np.abs(slip).max(initial=0.0) < 1e-5 * self.body.radius_mm:
                break
            # A point at distance t over the inset surface sits over the body at t − d: x moves by
            # (I + (t − d) S)⁻¹ times the slip.
            stretch = (distance - self.inset_mm)[:, None, None] * here.shape_operator_per_mm + np.eye(2)
            move = np.linalg.solve(stretch, slip[:, :, None])[:, :, 0]
            u = unit(here.position_mm + np.einsum("na,nax->nx", move, here.tangents))
        return distance

    def mass(self) -> MassProperties:
        """Volume, centroid and inertia of what the surface encloses, by quadrature on the sphere.

        With dA the body's surface element and S its shape operator the inset surface has the element
        `det(I − d S) dA`; volume and moments follow from the divergence theorem.
        """
        return _inset_mass(self)


@lru_cache(maxsize=64)
def _inset_mass(surface: InsetSurface) -> MassProperties:
    previous = None
    for order in _QUADRATURE_ORDERS:
        moments = _moments(surface, order)
        if previous is not None and np.all(np.abs(moments - previous) <= 1e-11 * moments[0]):
            break
        previous = moments
    scale = surface.body.radius_mm
    centroid = moments[1:4] / moments[0]
    second = np.empty((3, 3))
    second[np.triu_indices(3)] = second.T[np.triu_indices(3)] = moments[4:]
    second -= moments[0] * np.outer(centroid, centroid)
    inertia = (np.trace(second) * np.eye(3) - second) * scale**5
    com = centroid * scale + np.asarray(surface.shift_mm)
    return MassProperties.from_arrays(float(moments[0]) * scale**3, com, inertia)


def _moments(surface: InsetSurface, order: int) -> Array:
    """Moments of degree 0, 1 and 2 of the unshifted solid in units of the nominal radius, 10 numbers."""
    directions, weights = sphere_quadrature(order)
    total = np.zeros(10)
    scale = surface.body.radius_mm
    for i in range(0, len(directions), _CHUNK):
        u = directions[i : i + _CHUNK]
        here = surface.body.surface(u)
        radius = np.linalg.norm(here.position_mm, axis=1)
        # dA = r² dω / (u·n)
        element = radius**2 / np.einsum("nx,nx->n", u, here.normal)
        stretch = np.eye(2) - surface.inset_mm * here.shape_operator_per_mm
        area = weights[i : i + _CHUNK] * element * np.linalg.det(stretch) / scale**2
        x = (here.position_mm - surface.inset_mm * here.normal) / scale
        cone = area * np.einsum("nx,nx->n", x, here.normal)
        second = np.einsum("n,ni,nj->ij", cone / 5.0, x, x, optimize=True)
        total += np.concatenate([[cone.sum() / 3.0], (cone / 4.0) @ x, second[np.triu_indices(3)]])
    return total
