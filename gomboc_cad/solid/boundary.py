"""The surfaces that a part is made of, as mathematics: what files read back are measured against."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, fibonacci_directions
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.solid.hollow.description import Cylinder, HollowBody
from gomboc_cad.solid.offset import InsetSurface


@dataclass(frozen=True)
class Plane:
    """A plane that bounds a part.

    Attributes:
        origin_mm: A point of it.
        normal: Its normal, out of the part, of any length but zero.
    """

    origin_mm: Vector
    normal: Vector

    def height_mm(self, points_mm: Array) -> Array:
        """Signed distance of points (n, 3), positive outside the part."""
        direction = np.asarray(self.normal) / np.linalg.norm(self.normal)
        result: Array = (points_mm - np.asarray(self.origin_mm)) @ direction
        return result


class BoundarySurface(NamedTuple):
    """One surface of a boundary.

    Attributes:
        distance_mm: Signed distance of points (n, 3), positive on the side its own normal points to.
        outward: +1 where that normal points out of the material, −1 where it points into it.
    """

    distance_mm: Callable[[Array], Array]
    outward: float


@dataclass(frozen=True)
class Boundary:
    """The analytic boundary of a body, of a hollow body, or of one side of it.

    Attributes:
        outer: The outer surface.
        cavity: The surface of the cavity, None for a solid body.
        bosses: Cylinders of material in the cavity.
        holes: Cylinders taken away.
        plane: The plane that cuts the part off, None for a whole body.
    """

    outer: InsetSurface
    cavity: InsetSurface | None = None
    bosses: tuple[Cylinder, ...] = ()
    holes: tuple[Cylinder, ...] = ()
    plane: Plane | None = None

    @classmethod
    def of_body(cls, body: Body) -> Boundary:
        """Boundary of a solid body."""
        return cls(InsetSurface(body))

    @classmethod
    def of_hollow(cls, hollow: HollowBody) -> Boundary:
        """Boundary of a whole hollow body."""
        return cls(hollow.outer, hollow.inner, hollow.placed_bosses, hollow.placed_holes)

    def split(self, origin_mm: Vector, normal: Vector) -> tuple[Boundary, Boundary]:
        """Boundaries of the parts below and above a plane; see `split_brep`."""
        x, y, z = normal
        below, above = Plane(origin_mm, (x, y, z)), Plane(origin_mm, (-x, -y, -z))
        return replace(self, plane=below), replace(self, plane=above)

    @property
    def inset_surfaces(self) -> tuple[InsetSurface, ...]:
        """The outer surface and, where there is one, the cavity's."""
        return (self.outer,) if self.cavity is None else (self.outer, self.cavity)

    def surfaces(self) -> list[BoundarySurface]:
        """All surfaces, those that cost least to measure first."""
        result = [] if self.plane is None else [BoundarySurface(self.plane.height_mm, 1.0)]
        for cylinders, outward in ((self.bosses, 1.0), (self.holes, -1.0)):
            for cylinder in cylinders:
                result.extend(
                    BoundarySurface(distance, outward) for distance in _cylinder_distances(cylinder)
                )
        result.append(BoundarySurface(self.outer.signed_distance_mm, 1.0))
        if self.cavity is not None:
            result.append(BoundarySurface(self.cavity.signed_distance_mm, -1.0))
        return result

    def samples(self, count: int, margin_mm: float) -> list[tuple[Array, Array]]:
        """Points that must lie on the part, away by a margin from where its surfaces meet.

        Returns:
            Points and normals, each (n, 3), of the outer surface and, where there is one, of the cavity.
        """
        directions = fibonacci_directions(count)
        result = []
        for surface in self.inset_surfaces:
            points = surface.position_mm(directions)
            keep = np.ones(count, dtype=bool)
            if self.plane is not None:
                keep &= self.plane.height_mm(points) < -margin_mm
            # Bosses may run on through the wall, where they change nothing.
            cylinders = self.holes if surface is self.outer else (*self.bosses, *self.holes)
            for cylinder in cylinders:
                keep &= ~_within(cylinder, points, margin_mm)
            result.append((points[keep], surface.normal(directions[keep])))
        return result


def _cylinder_coordinates(cylinder: Cylinder, points_mm: Array) -> tuple[Array, Array]:
    """Distance from the axis and height over the base."""
    arm = points_mm - np.asarray(cylinder.base_mm)
    direction = np.asarray(cylinder.direction)
    height = arm @ direction
    return np.linalg.norm(arm - height[:, None] * direction, axis=1), height


def _cylinder_distances(cylinder: Cylinder) -> list[Callable[[Array], Array]]:
    """Signed distances from the side and from the planes of both ends."""
    return [
        lambda points: _cylinder_coordinates(cylinder, points)[0] - cylinder.radius_mm,
        lambda points: -_cylinder_coordinates(cylinder, points)[1],
        lambda points: _cylinder_coordinates(cylinder, points)[1] - cylinder.length_mm,
    ]


def _within(cylinder: Cylinder, points_mm: Array, margin_mm: float) -> NDArray[np.bool_]:
    radius, height = _cylinder_coordinates(cylinder, points_mm)
    beside = np.abs(height - 0.5 * cylinder.length_mm) < 0.5 * cylinder.length_mm + margin_mm
    inside: NDArray[np.bool_] = beside & (radius < cylinder.radius_mm + margin_mm)
    return inside
