"""The surfaces that a part is made of, as mathematics: what files read back are measured against."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, fibonacci_directions
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.solid.hollow.description import HollowBody
from gomboc_cad.solid.hollow.seam import Seam
from gomboc_cad.solid.hollow.tools import Ellipsoid, Tool
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
        center_mm: Centre of a ball that holds all of it, shape (3,); None for a surface of any extent.
        reach_mm: Radius of that ball.
    """

    distance_mm: Callable[[Array], Array]
    outward: float
    center_mm: Array | None = None
    reach_mm: float = np.inf


@dataclass(frozen=True)
class Boundary:
    """The analytic boundary of a body, of a hollow body, of one side of it, or of a plug.

    Attributes:
        outer: The outer surface.
        cavity: The surface of the cavity, None for a part without one.
        bosses: Material in the cavity.
        cuts: What is taken away: holes, openings, the groove of a stepped seam.
        plane: The plane that cuts the part off, None for a whole body.
        tongue: Where material beyond that plane belongs to the part.
        limits: Tools outside of which the part has no material, as with a plug.
    """

    outer: InsetSurface
    cavity: InsetSurface | None = None
    bosses: tuple[Tool, ...] = ()
    cuts: tuple[Tool, ...] = ()
    plane: Plane | None = None
    tongue: tuple[Tool, ...] = ()
    limits: tuple[Tool, ...] = ()

    @classmethod
    def of_body(cls, body: Body) -> Boundary:
        """Boundary of a solid body."""
        return cls(InsetSurface(body))

    @classmethod
    def of_hollow(cls, hollow: HollowBody) -> Boundary:
        """Boundary of a whole hollow body."""
        return cls(hollow.outer, hollow.inner, hollow.placed_bosses, hollow.placed_cuts)

    @classmethod
    def of_plug(cls, body: Body, tool: Tool) -> Boundary:
        """Boundary of the material of a solid body inside a tool; see `plug_brep`."""
        return cls(InsetSurface(body), limits=(tool,))

    def split(self, seam: Seam) -> tuple[Boundary, Boundary]:
        """Boundaries of the parts below and above a seam; see `split_brep`."""
        up = Plane(seam.origin_mm, seam.normal)
        down = Plane(seam.origin_mm, as_vector(-np.array(seam.normal)))
        lower = replace(self, plane=up, cuts=(*self.cuts, *seam.taken_below))
        return lower, replace(self, plane=down, tongue=seam.tongue)

    def moved(self, by_mm: Vector) -> Boundary:
        """The same boundary displaced rigidly."""

        def all_moved(tools: tuple[Tool, ...]) -> tuple[Tool, ...]:
            return tuple(tool.moved(by_mm) for tool in tools)

        plane = self.plane
        if plane is not None:
            plane = replace(plane, origin_mm=as_vector(np.add(plane.origin_mm, by_mm)))
        return Boundary(
            _moved_surface(self.outer, by_mm),
            None if self.cavity is None else _moved_surface(self.cavity, by_mm),
            all_moved(self.bosses),
            all_moved(self.cuts),
            plane,
            all_moved(self.tongue),
            all_moved(self.limits),
        )

    @property
    def curved_surfaces(self) -> tuple[InsetSurface | Ellipsoid, ...]:
        """The doubly curved surfaces: the outer one, the cavity's if there is one, and ellipsoids."""
        inset = (self.outer,) if self.cavity is None else (self.outer, self.cavity)
        return (*inset, *_ellipsoids((*self.bosses, *self.cuts, *self.tongue, *self.limits)))

    def surfaces(self) -> list[BoundarySurface]:
        """All surfaces, those that cost least to measure first."""
        result = [] if self.plane is None else [BoundarySurface(self.plane.height_mm, 1.0)]
        for tools, outward in (((*self.limits, *self.tongue, *self.bosses), 1.0), (self.cuts, -1.0)):
            for tool in tools:
                ball = _ball(tool)
                result.extend(BoundarySurface(distance, outward, *ball) for distance in tool.distances_mm)
        result.append(BoundarySurface(self.outer.signed_distance_mm, 1.0))
        if self.cavity is not None:
            result.append(BoundarySurface(self.cavity.signed_distance_mm, -1.0))
        return result

    def samples(self, count: int, margin_mm: float) -> list[tuple[Array, Array]]:
        """Points that must lie on the part, away by a margin from where its surfaces meet.

        Returns:
            Points and normals, each (n, 3), of the outer surface, of the cavity where there is one, and of
            each ellipsoid that is cut into the wall or into a part without a cavity.
        """
        directions = fibonacci_directions(count)
        result = []
        for surface in (self.outer, self.cavity, *_ellipsoids(self.cuts)):
            if surface is None:
                continue
            points = surface.position_mm(directions)
            keep = self._clear_of_tools(points, surface, margin_mm)
            if isinstance(surface, Ellipsoid):
                keep &= self._in_wall(points, margin_mm)
            result.append((points[keep], surface.normal(directions[keep])))
        return result

    def _clear_of_tools(
        self, points_mm: Array, surface: InsetSurface | Ellipsoid, margin_mm: float
    ) -> NDArray[np.bool_]:
        """Whether points of a surface are left by the plane and by all tools but the surface itself."""
        keep = np.ones(len(points_mm), dtype=bool)
        if self.plane is not None:
            keep &= self.plane.height_mm(points_mm) < -margin_mm
        for tool in self.limits:
            keep &= tool.within(points_mm, -margin_mm)
        # Bosses may run on through the wall, where they change nothing.
        tools = (*self.bosses, *self.cuts) if surface is self.cavity else self.cuts
        for tool in tools:
            if tool is not surface:
                keep &= ~tool.within(points_mm, margin_mm)
        return keep

    def _in_wall(self, points_mm: Array, margin_mm: float) -> NDArray[np.bool_]:
        """Whether points lie between the outer surface and the cavity."""
        inside: NDArray[np.bool_] = self.outer.signed_distance_mm(points_mm) < -margin_mm
        if self.cavity is not None:
            inside &= self.cavity.signed_distance_mm(points_mm) > margin_mm
        return inside


def _ball(tool: Tool) -> tuple[Array, float]:
    """Centre and radius of a ball that holds a tool."""
    hull = tool.hull_mm()
    center = 0.5 * (hull.min(axis=0) + hull.max(axis=0))
    return center, float(np.linalg.norm(hull - center, axis=1).max())


def _ellipsoids(tools: Iterable[Tool]) -> tuple[Ellipsoid, ...]:
    return tuple(tool for tool in tools if isinstance(tool, Ellipsoid))


def _moved_surface(surface: InsetSurface, by_mm: Vector) -> InsetSurface:
    return replace(surface, shift_mm=as_vector(np.add(surface.shift_mm, by_mm)))
