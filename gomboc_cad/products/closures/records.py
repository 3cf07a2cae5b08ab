"""Where a closure goes, and what it asks of the parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from build123d import Location, Plane

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, geodesic_triangulation
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.assembly import Part
from gomboc_cad.products.common_spec import ShellSpec
from gomboc_cad.products.openings.sites import PlacedOpening, judged_opening
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.solid.hollow.seam import Seam
from gomboc_cad.solid.hollow.tools import Cylinder, Tool

_NORMALS_LEVEL = 6
_LEVEL_ENOUGH = 1e-3
_ALONG = 200


@dataclass(frozen=True)
class ClosureSite:
    """Where a closure goes.

    Attributes:
        body: The outer shape.
        frame: Frame of the resting pose.
        shell: Wall, material and least wall.
        seam_height_mm: Height of the seam over the body's origin.
        com_mm: Where the centre of mass is to be; what the drill map is about.
        keep_out: What the closure must stay clear of.
        bore_radius_mm: Radius about the vertical through the origin of the pocket that a body without a
            cavity has at the seam; None for a hollow body.
        sag_um: How fine the meshes of made rings are.
    """

    body: Body
    frame: RestFrame
    shell: ShellSpec
    seam_height_mm: float
    com_mm: Vector
    keep_out: tuple[Cylinder, ...] = ()
    bore_radius_mm: float | None = None
    sag_um: float = 10.0

    def point(self, first: float, second: float, above_seam: float) -> Vector:
        """Place in the body's frame of a point given across the vertical and over the seam."""
        return as_vector(self.frame.point(first, second, self.seam_height_mm + above_seam))

    def upright(
        self,
        place: tuple[float, float],
        below_seam_mm: float,
        above_seam_mm: float,
        radius_mm: float,
        inner_radius_mm: float = 0.0,
    ) -> Cylinder:
        """A cylinder or tube along the vertical, from below the seam to above it."""
        base = self.point(*place, -below_seam_mm)
        return Cylinder(base, self.frame.up, radius_mm, below_seam_mm + above_seam_mm, inner_radius_mm)

    def column(self, place: tuple[float, float], radius_mm: float) -> Cylinder:
        """A column through the whole cavity; it starts outside, as only what lies in the cavity counts."""
        far = 1.5 * self.body.radius_mm
        base = as_vector(self.frame.point(*place, -far))
        return Cylinder(base, self.frame.up, radius_mm, 2.0 * far)

    def location(self, place: tuple[float, float], above_seam_mm: float, downwards: bool = False) -> Location:
        """Where a part stands whose own axis is z, upwards or downwards."""
        axis = as_vector(-np.array(self.frame.up)) if downwards else self.frame.up
        origin = self.point(*place, above_seam_mm)
        return Plane(origin=origin, x_dir=self.frame.first, z_dir=axis).location

    def across(self, tool: Cylinder) -> tuple[float, float]:
        """Where the axis of an upright tool is across the vertical."""
        first, second, _ = (self.frame.matrix() @ np.array(tool.base_mm)).tolist()
        return first, second

    def seam(self, tongue: tuple[Tool, ...] = (), groove: tuple[Tool, ...] = ()) -> Seam:
        """The seam, with what reaches across it."""
        return Seam(self.point(0.0, 0.0, 0.0), self.frame.up, tongue, groove)

    def check_clear(self, what: str, columns: Sequence[Cylinder]) -> None:
        """Refuse columns that meet each other or what they must stay clear of.

        Raises:
            GeometryError: With the two that meet.
        """
        for index, column in enumerate(columns):
            for other in columns[:index]:
                if (gap := _gap_mm(column, other)) < 0.0:
                    raise GeometryError(
                        f"The bosses of two {what}s meet, by {-gap:.2f} mm; take fewer or thinner ones, or "
                        "a larger diameter."
                    )
            for other in self.keep_out:
                if (gap := _gap_mm(column, other)) < 0.0:
                    raise GeometryError(
                        f"The boss of a {what} meets another part of the interior, by {-gap:.2f} mm; turn "
                        "closure.angle_deg, use thinner ones or a larger diameter."
                    )

    def widest_ring_mm(self, below_seam_mm: float, above_seam_mm: float, cover_mm: float) -> float:
        """Largest radius about the vertical that stays a distance under the surface over a range of heights.

        A convex body is where `x·n ≤ h(n)` for every normal n, h being its support function. So the circle
        of radius r and middle c keeps the cover while `c·n + r |n⊥| ≤ h(n) − cover`, n⊥ being the level
        part of n. Of the heights, the two ends decide.

        Raises:
            GeometryError: If the vertical itself does not stay that deep.
        """
        directions = geodesic_triangulation(_NORMALS_LEVEL)[0]
        normals = self.body.normal(directions)
        support = np.einsum("nx,nx->n", self.body.position_mm(directions), normals)
        level = np.linalg.norm(normals @ self.frame.matrix()[:2].T, axis=1)
        middles = [self.point(0.0, 0.0, height) for height in (-below_seam_mm, above_seam_mm)]
        spare = support - cover_mm - (normals @ np.array(middles).T).max(axis=1)
        if spare.min() <= 0.0:
            raise GeometryError(
                f"A closure that reaches from {below_seam_mm:g} mm below the seam to {above_seam_mm:g} mm "
                f"above it does not stay {cover_mm:.3g} mm under the surface; make it shorter, move "
                "split.height_mm to the middle, or take a larger diameter."
            )
        return float((spare / np.maximum(level, _LEVEL_ENOUGH)).min())


@dataclass(frozen=True)
class ClosureLayout:
    """What a closure asks of the parts, and the parts that it brings.

    All of it belongs to the core. Bosses and holes are stated for the unmoved core, as `HollowBody` wants
    them; everything else is in place.

    Attributes:
        site: Where it is.
        seam: How the body is cut.
        bosses: Material in the cavity.
        holes: What is taken away, with the recesses that open the outer surface.
        openings: Those recesses, judged. They are among the holes and need not be cut again.
        plugs: Where the body's own material closes a recess flush; see `plug_parts`.
        parts: Bought parts and made rings.
        upper_parts: Names of those that stay with the upper part when it is moved.
        columns: What contents must stay clear of.
        notes: What a user should know, one sentence each.
    """

    site: ClosureSite
    seam: Seam
    bosses: tuple[Cylinder, ...] = ()
    holes: tuple[Cylinder, ...] = ()
    openings: tuple[PlacedOpening, ...] = ()
    plugs: tuple[Cylinder, ...] = ()
    parts: tuple[Part, ...] = ()
    upper_parts: tuple[str, ...] = ()
    columns: tuple[Cylinder, ...] = ()
    notes: tuple[str, ...] = ()

    def moved(self, shift_mm: Array) -> ClosureLayout:
        """The closure of a core that moved by a vector of the body's frame, shape (3,).

        Its openings are judged again, each where it is now.
        """
        shift = as_vector(shift_mm)
        return replace(
            self,
            seam=_moved_seam(self.seam, shift),
            openings=tuple(self._judged_at(opening, shift) for opening in self.openings),
            plugs=tuple(plug.moved(shift) for plug in self.plugs),
            parts=tuple(part.moved(np.asarray(shift)) for part in self.parts),
            columns=tuple(column.moved(shift) for column in self.columns),
        )

    def _judged_at(self, opening: PlacedOpening, shift: Vector) -> PlacedOpening:
        return judged_opening(
            self.site.body,
            self.site.com_mm,
            opening.name,
            opening.tool.moved(shift).extended(0.0, self.site.body.radius_mm),
            frame=self.site.frame,
            plug=opening.state == "plugged",
        )


def _moved_seam(seam: Seam, by_mm: Vector) -> Seam:
    return replace(
        seam,
        origin_mm=as_vector(np.add(seam.origin_mm, by_mm)),
        tongue=tuple(tool.moved(by_mm) for tool in seam.tongue),
        groove=tuple(tool.moved(by_mm) for tool in seam.groove),
    )


def _gap_mm(one: Cylinder, other: Cylinder) -> float:
    """Free space between the sides of two cylinders, by points along their axes; negative where they meet."""
    along = np.linspace(0.0, 1.0, _ALONG)[:, None]
    first, second = (
        np.array(cylinder.base_mm) + cylinder.length_mm * along * np.array(cylinder.direction)
        for cylinder in (one, other)
    )
    distance = np.linalg.norm(first[:, None] - second, axis=2).min()
    return float(distance) - one.radius_mm - other.radius_mm
