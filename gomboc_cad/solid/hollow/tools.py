"""Shapes that are added to a hollow body or taken from it: cylinders and tubes, ellipsoids, boxes."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from gomboc_cad.body.sphere import Array, geodesic_triangulation
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import GeometryError

Distance = Callable[[Array], Array]
"""Signed distance of points (n, 3) from a surface, shape (n,)."""

_RIM_POINTS = 64
_SPOKES = 12
_SHARES = (0.05, 0.35, 0.65, 0.95)
_FEWEST_SEGMENTS = 12
_OUTLINE_LEVEL = 2
_SQUARE_TOLERANCE = 1e-6
_HALVINGS = 64
_TINY = 1e-100


class _Bounded(ABC):
    """What is common to all tools: they are where all their signed distances are negative."""

    @property
    @abstractmethod
    def distances_mm(self) -> tuple[Distance, ...]:
        """Signed distances from the surfaces that bound the tool, positive outside of it."""

    def within(self, points_mm: Array, margin_mm: float) -> NDArray[np.bool_]:
        """Whether points (n, 3) lie inside, or outside by less than a margin, shape (n,)."""
        inside = np.ones(len(points_mm), dtype=bool)
        for distance in self.distances_mm:
            inside &= distance(points_mm) < margin_mm
        return inside

    def contains(self, points_mm: Array) -> NDArray[np.bool_]:
        """Whether points (n, 3) lie inside, shape (n,)."""
        return self.within(points_mm, 0.0)

    @abstractmethod
    def hull_mm(self) -> Array:
        """Points, shape (n, 3), whose convex hull holds the tool and hardly more."""

    def inside_mm(self) -> Array:
        """Points spread over the inside, shape (n, 3)."""
        hull = self.hull_mm()
        center = hull.mean(axis=0)
        return np.concatenate([center + share * (hull - center) for share in _SHARES])


@dataclass(frozen=True)
class Cylinder(_Bounded):
    """A right circular cylinder, or a tube.

    Attributes:
        base_mm: Centre of the base.
        axis: Direction from the base to the other end, of any length but zero.
        radius_mm: Radius.
        length_mm: Length along the axis.
        inner_radius_mm: Radius of the bore of a tube or ring; 0 for a full cylinder.

    Raises:
        GeometryError: If a size is not a positive length, the axis has no direction, or the bore is not
            smaller than the cylinder.
    """

    base_mm: Vector
    axis: Vector
    radius_mm: float
    length_mm: float
    inner_radius_mm: float = 0.0

    def __post_init__(self) -> None:
        """Refuse sizes that make no cylinder."""
        if not all(math.isfinite(size) and size > 0.0 for size in (self.radius_mm, self.length_mm)):
            raise GeometryError(
                f"A cylinder needs a positive radius and length in mm, not {self.radius_mm!r} and "
                f"{self.length_mm!r}."
            )
        if not 0.0 <= self.inner_radius_mm < self.radius_mm:
            raise GeometryError(
                f"The bore of a tube needs a radius from 0 to the tube's own {self.radius_mm:g} mm, not "
                f"{self.inner_radius_mm!r}."
            )
        if not (np.all(np.isfinite([*self.base_mm, *self.axis])) and math.hypot(*self.axis) > 0.0):
            raise GeometryError(
                f"A cylinder needs a base and an axis, not {self.base_mm!r} and {self.axis!r}."
            )

    @property
    def direction(self) -> Vector:
        """Unit vector along the axis."""
        length = math.hypot(*self.axis)
        x, y, z = (component / length for component in self.axis)
        return x, y, z

    @property
    def bore(self) -> Cylinder | None:
        """What a tube lacks to be a full cylinder."""
        if not self.inner_radius_mm:
            return None
        return replace(self, radius_mm=self.inner_radius_mm, inner_radius_mm=0.0)

    def moved(self, by_mm: Vector) -> Cylinder:
        """Give the cylinder displaced rigidly."""
        return replace(self, base_mm=as_vector(np.add(self.base_mm, by_mm)))

    def extended(self, before_mm: float, after_mm: float) -> Cylinder:
        """Give the cylinder made longer at its base and at its other end."""
        x, y, z = (a - before_mm * b for a, b in zip(self.base_mm, self.direction, strict=True))
        return replace(self, base_mm=(x, y, z), length_mm=self.length_mm + before_mm + after_mm)

    @property
    def distances_mm(self) -> tuple[Distance, ...]:
        """Signed distances from the side, both ends and, of a tube, the bore."""
        walls = (lambda points: self._polar(points)[0] - self.radius_mm,)
        ends = (
            lambda points: -self._polar(points)[1],
            lambda points: self._polar(points)[1] - self.length_mm,
        )
        bore = (lambda points: self.inner_radius_mm - self._polar(points)[0],)
        return (*walls, *ends, *bore) if self.inner_radius_mm else (*walls, *ends)

    def _polar(self, points_mm: Array) -> tuple[Array, Array]:
        """Distance from the axis and height over the base."""
        arm = points_mm - np.asarray(self.base_mm)
        direction = np.asarray(self.direction)
        height = arm @ direction
        return np.linalg.norm(arm - height[:, None] * direction, axis=1), height

    def rims_mm(self, count: int = _RIM_POINTS) -> Array:
        """Points around both ends, shape (2·count, 3)."""
        direction = np.array(self.direction)
        side, up = np.linalg.svd(direction[None])[2][1:]
        angle = 2.0 * np.pi * np.arange(count) / count
        circle = self.radius_mm * (np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * up)
        return np.concatenate([circle, circle + self.length_mm * direction]) + np.array(self.base_mm)

    def hull_mm(self) -> Array:
        """Points, shape (n, 3), whose convex hull holds the cylinder and hardly more."""
        radius_mm = self.radius_mm / math.cos(math.pi / _RIM_POINTS)
        return replace(self, radius_mm=radius_mm).rims_mm()

    def inside_mm(self) -> Array:
        """Points spread over the inside, shape (n, 3)."""
        inner_mm, outer_mm = self.inner_radius_mm, self.radius_mm
        radii_mm = [inner_mm + share * (outer_mm - inner_mm) for share in _SHARES]
        rings = [
            replace(self, radius_mm=r, inner_radius_mm=0.0).rims_mm(_SPOKES).reshape(2, -1, 3)
            for r in radii_mm
        ]
        return np.concatenate([(1.0 - t) * base + t * top for base, top in rings for t in _SHARES])

    def ends(self) -> tuple[Array, Array]:
        """A point on each of the flat ends and the outward normal there, both (2, 3)."""
        direction = np.array(self.direction)
        side = np.linalg.svd(direction[None])[2][1]
        middle = 0.5 * (self.inner_radius_mm + self.radius_mm) if self.inner_radius_mm else 0.0
        base = np.array(self.base_mm) + middle * side
        return np.array([base, base + self.length_mm * direction]), np.array([-direction, direction])

    def run_on(self, by_mm: Array) -> Cylinder:
        """Give the cylinder run on beyond each of its ends, shape (2,)."""
        return self.extended(*by_mm.tolist())


@dataclass(frozen=True)
class Ellipsoid(_Bounded):
    """An ellipsoid.

    Attributes:
        center_mm: Its centre.
        axes: Three orthonormal vectors.
        semi_axes_mm: Its half-lengths along them.

    Raises:
        GeometryError: If a half-length is not positive or the axes are not orthonormal.
    """

    center_mm: Vector
    axes: tuple[Vector, Vector, Vector]
    semi_axes_mm: Vector

    def __post_init__(self) -> None:
        """Refuse sizes and axes that make no ellipsoid."""
        if not all(math.isfinite(size) and size > 0.0 for size in self.semi_axes_mm):
            raise GeometryError(
                f"An ellipsoid needs three positive half-lengths in mm, not {self.semi_axes_mm!r}."
            )
        frame = self.frame
        if not (
            np.all(np.isfinite(self.center_mm))
            and frame.shape == (3, 3)
            and np.allclose(frame @ frame.T, np.eye(3), rtol=0.0, atol=_SQUARE_TOLERANCE)
        ):
            raise GeometryError(
                f"An ellipsoid needs a centre and three orthonormal axes, not {self.center_mm!r} and "
                f"{self.axes!r}."
            )

    @property
    def frame(self) -> Array:
        """The axes as rows, shape (3, 3)."""
        return np.array(self.axes, dtype=float)

    def moved(self, by_mm: Vector) -> Ellipsoid:
        """Give the ellipsoid displaced rigidly."""
        return replace(self, center_mm=as_vector(np.add(self.center_mm, by_mm)))

    def position_mm(self, directions: Array) -> Array:
        """Surface points that the ellipsoid's affine map makes of unit vectors (n, 3), shape (n, 3)."""
        return (directions * np.array(self.semi_axes_mm)) @ self.frame + np.array(self.center_mm)

    def normal(self, directions: Array) -> Array:
        """Outward unit normals at the points that `position_mm` gives, shape (n, 3)."""
        normals = (directions / np.array(self.semi_axes_mm)) @ self.frame
        result: Array = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        return result

    @property
    def distances_mm(self) -> tuple[Distance, ...]:
        """Signed distance from the surface."""
        return (self.signed_distance_mm,)

    def signed_distance_mm(self, points_mm: Array) -> Array:
        """Distance of points (n, 3), positive outside, shape (n,).

        The foot x of the perpendicular from y has `xᵢ = aᵢ² yᵢ / (t + aᵢ²)`, where t is the largest root
        of `Σ (aᵢ yᵢ / (t + aᵢ²))² = 1` (D. Eberly, "Distance from a point to an ellipse, an ellipsoid, or a
        hyperellipsoid", 2013). It is found by bisection, which no point in a plane of symmetry upsets.
        """
        scale = max(self.semi_axes_mm)
        a = np.array(self.semi_axes_mm) / scale
        y = np.abs((points_mm - np.array(self.center_mm)) @ self.frame.T) / scale
        # One term of the sum alone is 1 at the lower end; all with the shortest axis are 1 at the upper.
        low = (a * y - a * a).max(axis=1)
        high = np.linalg.norm(a * y, axis=1) - a.min() ** 2
        for _ in range(_HALVINGS):
            t = 0.5 * (low + high)
            beyond = (((a * y) / np.maximum(t[:, None] + a * a, _TINY)) ** 2).sum(axis=1) > 1.0
            low, high = np.where(beyond, t, low), np.where(beyond, high, t)
        # The foot over the half-lengths is a unit vector. Its component along the shortest axis follows from
        # the others, also where the foot lies off the plane of symmetry that the point lies in.
        w = np.minimum(a * y / np.maximum(t[:, None] + a * a, _TINY), 1.0)
        short = int(a.argmin())
        w[:, short] = 0.0
        w /= np.maximum(np.linalg.norm(w, axis=1, keepdims=True), 1.0)
        w[:, short] = np.sqrt(np.maximum(1.0 - (w * w).sum(axis=1), 0.0))
        result: Array = scale * t * np.linalg.norm(w / a, axis=1)
        return result

    def hull_mm(self) -> Array:
        """Points, shape (n, 3), whose convex hull holds the ellipsoid and hardly more."""
        vertices, faces = geodesic_triangulation(_OUTLINE_LEVEL)
        corners = vertices[faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        heights = np.einsum("nx,nx->n", normals, corners[:, 0]) / np.linalg.norm(normals, axis=1)
        return self.position_mm(vertices / heights.min())

    def ends(self) -> tuple[Array, Array]:
        """Flat ends and their normals, of which there are none."""
        return np.empty((0, 3)), np.empty((0, 3))

    def run_on(self, by_mm: Array) -> Ellipsoid:
        """Give the ellipsoid itself, as it has no flat ends."""
        return self


@dataclass(frozen=True)
class Box(_Bounded):
    """A rectangular box.

    Attributes:
        center_mm: Its middle.
        x_axis: Direction of its first edge, of any length but zero.
        z_axis: Direction of its third edge, square to the first; the second completes a right-handed frame.
        size_mm: Its lengths along the three.

    Raises:
        GeometryError: If a length is not positive or the two directions are not square to each other.
    """

    center_mm: Vector
    x_axis: Vector
    z_axis: Vector
    size_mm: Vector

    def __post_init__(self) -> None:
        """Refuse sizes and axes that make no box."""
        if not all(math.isfinite(size) and size > 0.0 for size in self.size_mm):
            raise GeometryError(f"A box needs three positive lengths in mm, not {self.size_mm!r}.")
        lengths = math.hypot(*self.x_axis), math.hypot(*self.z_axis)
        if not (
            np.all(np.isfinite([*self.center_mm, *lengths]))
            and min(lengths) > 0.0
            and abs(np.dot(self.x_axis, self.z_axis)) <= _SQUARE_TOLERANCE * math.prod(lengths)
        ):
            raise GeometryError(
                f"A box needs a middle and two directions square to each other, not {self.center_mm!r}, "
                f"{self.x_axis!r} and {self.z_axis!r}."
            )

    @cached_property
    def frame(self) -> Array:
        """Unit vectors along the three edges as rows, shape (3, 3)."""
        z = np.array(self.z_axis) / math.hypot(*self.z_axis)
        y = np.cross(z, self.x_axis)
        y /= np.linalg.norm(y)
        return np.array([np.cross(y, z), y, z])

    def moved(self, by_mm: Vector) -> Box:
        """Give the box displaced rigidly."""
        return replace(self, center_mm=as_vector(np.add(self.center_mm, by_mm)))

    @property
    def distances_mm(self) -> tuple[Distance, ...]:
        """Signed distances from the planes of the six faces."""
        points, normals = self.ends()
        return tuple(
            partial(_over_plane, normal, height)
            for normal, height in zip(normals, np.einsum("nx,nx->n", points, normals), strict=True)
        )

    def hull_mm(self) -> Array:
        """The corners, shape (8, 3)."""
        signs = np.stack(np.meshgrid(*[(-0.5, 0.5)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        result: Array = (signs * np.array(self.size_mm)) @ self.frame + np.array(self.center_mm)
        return result

    def ends(self) -> tuple[Array, Array]:
        """Middles of the faces and the outward normals there, against and along each edge, both (6, 3)."""
        normals = np.stack([-self.frame, self.frame], axis=1).reshape(6, 3)
        reach = np.repeat(0.5 * np.array(self.size_mm), 2)
        return np.array(self.center_mm) + reach[:, None] * normals, normals

    def run_on(self, by_mm: Array) -> Box:
        """Give the box run on beyond each of its faces, shape (6,)."""
        before, after = np.asarray(by_mm).reshape(3, 2).T
        center = np.array(self.center_mm) + 0.5 * (after - before) @ self.frame
        size = np.array(self.size_mm) + before + after
        return replace(self, center_mm=as_vector(center), size_mm=as_vector(size))


Tool = Cylinder | Ellipsoid | Box


def segments(radius_mm: float, sag_um: float) -> int:
    """Number of sides of a polygon inscribed in a circle that keeps a sag."""
    half_angle = math.acos(max(-1.0, 1.0 - 1e-3 * sag_um / radius_mm))
    return max(_FEWEST_SEGMENTS, math.ceil(math.pi / half_angle))


def _over_plane(normal: Array, height_mm: float, points_mm: Array) -> Array:
    """Signed distance of points (n, 3) from a plane, shape (n,)."""
    result: Array = points_mm @ normal - height_mm
    return result
