"""A body: a star-shaped surface `x = r(u) u` with its differential geometry."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from gomboc_cad.body.families import ShapeFunction
from gomboc_cad.body.sphere import Array, geodesic_triangulation, tangent_frame, unit
from gomboc_cad.errors import BodyError

DEFAULT_RADIUS_MM = 50.0
_SMALLEST_RADIUS_MM = 1e-9
_LARGEST_RADIUS_MM = 1e9
_CHECK_LEVEL = 3


class RadialJet(NamedTuple):
    """The radius and its covariant derivatives on the sphere, in a tangent frame.

    Attributes:
        radius_mm: r, shape (n,).
        gradient_mm: ∇r in the frame, shape (n, 2).
        hessian_mm: ∇²r in the frame, shape (n, 2, 2).
        frame: The two tangent vectors as rows, shape (n, 2, 3).
    """

    radius_mm: Array
    gradient_mm: Array
    hessian_mm: Array
    frame: Array


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Geometry of the surface at n directions.

    Attributes:
        directions: The directions u, shape (n, 3).
        position_mm: Surface points x = r u, shape (n, 3).
        normal: Outward unit normals, shape (n, 3).
        tangents: Orthonormal basis of each tangent plane as rows, shape (n, 2, 3).
        shape_operator_per_mm: Second fundamental form in that basis, positive for a sphere,
            shape (n, 2, 2).
    """

    directions: Array
    position_mm: Array
    normal: Array
    tangents: Array
    shape_operator_per_mm: Array

    def principal_curvatures_per_mm(self) -> Array:
        """Principal curvatures κ₁ ≥ κ₂, shape (n, 2)."""
        mean = 0.5 * (self.shape_operator_per_mm[:, 0, 0] + self.shape_operator_per_mm[:, 1, 1])
        half = 0.5 * (self.shape_operator_per_mm[:, 0, 0] - self.shape_operator_per_mm[:, 1, 1])
        spread = np.hypot(half, self.shape_operator_per_mm[:, 0, 1])
        return np.stack([mean + spread, mean - spread], axis=-1)

    def principal_directions(self) -> Array:
        """Unit principal directions of κ₁ and κ₂ as rows, shape (n, 2, 3)."""
        _, vectors = np.linalg.eigh(self.shape_operator_per_mm)
        result: Array = np.einsum("nai,nax->nix", vectors[:, :, ::-1], self.tangents)
        return result


@dataclass(frozen=True)
class Body:
    """A star-shaped body `r⁴ = R₀⁴ (1 + 4 f(u))`.

    Attributes:
        name: Catalogue name, or a description of the parameters.
        shape: The shape function f.
        radius_mm: Nominal radius R₀, the unit of the parametrisation.

    Raises:
        BodyError: If R₀ is not a sensible positive length or if 1 + 4 f is not positive.
    """

    name: str
    shape: ShapeFunction
    radius_mm: float = DEFAULT_RADIUS_MM

    def __post_init__(self) -> None:
        """Check the size and that the radius is real all over the sphere."""
        if not _SMALLEST_RADIUS_MM <= self.radius_mm <= _LARGEST_RADIUS_MM:
            raise BodyError(
                f"The nominal radius must be between {_SMALLEST_RADIUS_MM:g} and {_LARGEST_RADIUS_MM:g} mm, "
                f"not {self.radius_mm!r}."
            )
        self._fourth_power(self.shape.ambient_jet(geodesic_triangulation(_CHECK_LEVEL)[0]).value)

    def _fourth_power(self, value: Array) -> Array:
        """Form `1 + 4 f`, which the coarse check at the start cannot see everywhere."""
        result: Array = 1.0 + 4.0 * value
        if not np.all(result > 0.0):
            raise BodyError(
                f"The coefficients of {self.name!r} are too large: the radius is not real and positive "
                "everywhere."
            )
        return result

    @property
    def diameter_mm(self) -> float:
        """Nominal diameter 2 R₀."""
        return 2.0 * self.radius_mm

    def with_diameter(self, diameter_mm: float) -> Body:
        """Give the same shape with another nominal diameter."""
        return replace(self, radius_mm=0.5 * diameter_mm)

    def radius_at(self, directions: Array) -> Array:
        """Radius r(u) in mm at unit vectors (n, 3)."""
        value = self.shape.ambient_jet(directions).value
        result: Array = self.radius_mm * np.sqrt(np.sqrt(self._fourth_power(value)))
        return result

    def position_mm(self, directions: Array) -> Array:
        """Surface points x(u) = r(u) u, shape (n, 3)."""
        return self.radius_at(directions)[:, None] * directions

    def radial_jet(self, directions: Array) -> RadialJet:
        """Radius with analytic first and second covariant derivatives at unit vectors (n, 3)."""
        jet = self.shape.ambient_jet(directions)
        frame = np.stack(tangent_frame(directions), axis=1)
        slope = np.einsum("nax,nx->na", frame, jet.gradient)
        radial = np.einsum("nx,nx->n", directions, jet.gradient)
        bend = frame @ jet.hessian @ frame.transpose(0, 2, 1)
        bend[:, [0, 1], [0, 1]] -= radial[:, None]
        s = self._fourth_power(jet.value)
        r = self.radius_mm * s**0.25
        gradient = (r / s)[:, None] * slope
        outer = slope[:, :, None] * slope[:, None, :]
        hessian = (r / s)[:, None, None] * (bend - (3.0 / s)[:, None, None] * outer)
        return RadialJet(r, gradient, hessian, frame)

    def surface(self, directions: Array) -> SurfacePoints:
        """Position, normal and shape operator at unit vectors (n, 3).

        With v = ∇r and N = sqrt(r² + |v|²) the first form is `r² I + v vᵀ` and the second
        `(r² I + 2 v vᵀ − r ∇²r) / N`; both are brought to an orthonormal basis by the closed form of
        the inverse root of the first.
        """
        r, v, hessian, frame = self.radial_jet(directions)
        norm = np.sqrt(r * r + np.einsum("na,na->n", v, v))
        eye = np.eye(2)
        outer = v[:, :, None] * v[:, None, :]
        radius = r[:, None, None]
        second = (radius**2 * eye + 2.0 * outer - radius * hessian) / norm[:, None, None]
        root = eye / radius - outer / (r * norm * (norm + r))[:, None, None]
        tangents = radius * (root @ frame) + (v / norm[:, None])[:, :, None] * directions[:, None, :]
        gradient = np.einsum("na,nax->nx", v, frame)
        normal = (r[:, None] * directions - gradient) / norm[:, None]
        return SurfacePoints(directions, r[:, None] * directions, normal, tangents, root @ second @ root)

    def normal(self, directions: Array) -> Array:
        """Outward unit normals at unit vectors (n, 3)."""
        r, v, _, frame = self.radial_jet(directions)
        return unit(r[:, None] * directions - np.einsum("na,nax->nx", v, frame))

    def offset_mm(self, directions: Array, distance_mm: float) -> Array:
        """Points moved inwards along the normal by `distance_mm`, shape (n, 3)."""
        return self.position_mm(directions) - distance_mm * self.normal(directions)
