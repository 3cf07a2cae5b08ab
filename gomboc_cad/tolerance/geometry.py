"""The outer surface of one variant as geometry: points of the part as it was really made.

A point of the part with outward normal v is `p = x + ∇δ + δ v`, x the touching point of the body as designed:
the boundary of the solid whose support function is that of the body plus the form error δ. The flat parting
plane cuts the part and cylinders drill it, then it shrinks to `S p`, its normals turn to `S⁻¹ v`, and the
upper half sits where step and gap have put it.

Where the form error is so rough that no convex solid has this support function, the normals of neighbouring
points turn against each other. Then the part is made of the really displaced points `x + δ v`, with dents.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.optimize.elementwise import find_root

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, BoolArray, IntArray, lengths, tangent_frame, unit
from gomboc_cad.body.surface import SurfacePoints
from gomboc_cad.errors import GeometryError
from gomboc_cad.tolerance.harmonics import form_error
from gomboc_cad.tolerance.variants import Nominal, SeamPlane, Variants

if TYPE_CHECKING:
    from gomboc_cad.products.openings.placed_opening import PlacedOpening

_FEWEST_CURVE_POINTS = 180

_PAST_RIM = 3.0
"""How far from the middle of a mouth its rim is looked for, in radii of the circle around it."""


class PartPoints(NamedTuple):
    """Points of the outer surface of a part.

    Attributes:
        directions: Parameter of each on the body as designed, shape (n, 3).
        part_mm: Before it shrank and the halves were displaced, shape (n, 3).
        own_mm: As made, each in the frame of its own half, shape (n, 3).
        position_mm: As made and put together, shape (n, 3).
        normal: Outward unit normals as made, shape (n, 3).
        foot_mm: From the foot of the perpendicular from the COM on the tangent plane to the point, which is
            the gradient of the height of the COM over the table, shape (n, 3).
    """

    directions: Array
    part_mm: Array
    own_mm: Array
    position_mm: Array
    normal: Array
    foot_mm: Array

    def chosen(self, rows: IntArray) -> PartPoints:
        """Some of them."""
        return PartPoints(*(column[rows] for column in self))

    def and_also(self, others: PartPoints) -> PartPoints:
        """These points and others behind them."""
        return PartPoints(*(np.concatenate(pair) for pair in zip(self, others, strict=True)))


@dataclass(frozen=True, eq=False)
class MadePart:
    """One variant, ready to be asked for points of its surface.

    Attributes:
        body: The outer shape as designed.
        com_mm: Centre of mass of the finished assembly, shape (3,).
        stretch: Symmetric S, shape (3, 3).
        form_mm: Coefficients of the form error, shape (K,).
        upper_shift_mm: Displacement of the upper half, shape (3,).
        seam: Where the halves part; None for a part in one piece.
        holes: Openings that are not plugged.
        dented: Whether the points are displaced along the normal, by δ, instead of δ being added to the
            support function.
    """

    body: Body
    com_mm: Array
    stretch: Array
    form_mm: Array
    upper_shift_mm: Array
    seam: SeamPlane | None = None
    holes: tuple[PlacedOpening, ...] = ()
    dented: bool = False

    @classmethod
    def of(cls, nominal: Nominal, variants: Variants, row: int) -> MadePart:
        """The part that a row of the variants describes."""
        return cls(
            body=nominal.body,
            com_mm=variants.com_mm[row],
            stretch=variants.stretch[row],
            form_mm=variants.form_mm[row],
            upper_shift_mm=variants.upper_shift_mm[row],
            seam=nominal.seam,
            holes=tuple(opening for opening in nominal.openings if opening.state != "plugged"),
        )

    @property
    def has_step(self) -> bool:
        """Whether the halves are out of place, so that the part can rest on both of them at the seam."""
        return self.seam is not None and bool(np.any(self.upper_shift_mm))

    @cached_property
    def _turning(self) -> Array:
        """S⁻¹, which turns the normals."""
        return np.asarray(np.linalg.inv(self.stretch), dtype=float)

    def at(self, directions: Array) -> PartPoints:
        """Points for parameters of the body as designed, unit vectors (n, 3)."""
        surface = self.body.surface(directions)
        part, normal = self._with_form_error(surface)
        own = part @ self.stretch
        position = own
        if self.has_step:
            position = own + (self.seam_height_mm(part) > 0.0)[:, None] * self.upper_shift_mm
        normal = unit(normal @ self._turning)
        return self._seen_from_com(PartPoints(directions, part, own, position, normal, position))

    def _seen_from_com(self, points: PartPoints) -> PartPoints:
        """The same points with the feet that belong to their positions."""
        arm = points.position_mm - self.com_mm
        height = np.einsum("nx,nx->n", arm, points.normal)
        return points._replace(foot_mm=arm - height[:, None] * points.normal)

    def _with_form_error(self, surface: SurfacePoints) -> tuple[Array, Array]:
        """Points of the part before it shrinks, and its normals there."""
        if self.form_mm.size == 0:
            return surface.position_mm, surface.normal
        form = form_error(surface.normal, self.form_mm)
        moved = surface.position_mm + form.value_mm[:, None] * surface.normal
        if not self.dented:
            return moved + form.gradient_mm, surface.normal
        # Along the surface δ has the slope A ∇δ, A the shape operator; lengths there grow by I + δ A.
        bend = surface.shape_operator_per_mm
        slope = bend @ np.einsum("nax,nx->na", surface.tangents, form.gradient_mm)[:, :, None]
        lever = np.eye(2) + form.value_mm[:, None, None] * bend
        tilt = np.linalg.solve(lever, slope)[:, :, 0]
        return moved, unit(surface.normal - np.einsum("na,nax->nx", tilt, surface.tangents))

    def seam_height_mm(self, part_mm: Array) -> Array:
        """Height of points (n, 3) of the part, before it shrinks, over the parting plane, shape (n,).

        Raises:
            GeometryError: If the part has no seam.
        """
        if self.seam is None:
            raise GeometryError("The body has no seam; give the nominal a seam, or the variants no step.")
        result: Array = (part_mm - np.array(self.seam.origin_mm)) @ np.array(self.seam.normal)
        return result

    def in_mouth(self, part_mm: Array) -> BoolArray:
        """Which points (n, 3) of the part, before it shrinks, have been drilled away, shape (n,)."""
        gone = np.zeros(len(part_mm), dtype=bool)
        for hole in self.holes:
            across, along = _polar(hole, part_mm)
            gone |= (across < hole.tool.radius_mm) & (along > -hole.rim_radius_mm)
        return gone

    def rims(self, sag_mm: float) -> list[PartPoints]:
        """The curves in which the smooth surface ends: around each hole, then at the seam if it has a step.

        Args:
            sag_mm: Largest depth that is missed between neighbouring points.

        Raises:
            GeometryError: If the parting plane does not cut the part, or a hole only grazes it.
        """
        rims = [self._mouth_rim(hole, sag_mm) for hole in self.holes]
        if self.seam is not None and self.has_step:
            up = np.array(self.seam.normal)
            rim = self._curve(up, np.pi, lambda part: -self.seam_height_mm(part), sag_mm)
            sides = (rim.own_mm, rim.own_mm + self.upper_shift_mm)
            rims += [self._seen_from_com(rim._replace(position_mm=side)) for side in sides]
        return rims

    def _mouth_rim(self, hole: PlacedOpening, sag_mm: float) -> PartPoints:
        middle = np.array(hole.position_mm)
        reach = float(np.linalg.norm(middle))
        farthest = float(np.arcsin(min(1.0, _PAST_RIM * hole.rim_radius_mm / reach)))

        def outside(part_mm: Array) -> Array:
            return _polar(hole, part_mm)[0] - hole.tool.radius_mm

        return self._curve(middle / reach, farthest, outside, sag_mm, np.array(hole.tool.direction))

    def _curve(
        self,
        middle: Array,
        farthest: float,
        outside: Callable[[Array], Array],
        sag_mm: float,
        axis: Array | None = None,
    ) -> PartPoints:
        """The closed curve around a direction where a function of the part's points becomes positive.

        Between neighbouring points at a distance l the curve bulges by `k l²/8`, k its curvature vector. At a
        rim only what lies along its normals, from the surface's to the axis of the hole, makes it higher.
        """
        one, other = (axes[0] for axes in tangent_frame(middle[None]))

        def at(angle: Array, turn: Array) -> PartPoints:
            side = np.cos(turn)[:, None] * one + np.sin(turn)[:, None] * other
            return self.at(np.cos(angle)[:, None] * middle + np.sin(angle)[:, None] * side)

        def past_curve(angle: Array, turn: Array) -> Array:
            return outside(at(angle, turn).part_mm)

        count = _FEWEST_CURVE_POINTS
        while True:
            turns = 2.0 * np.pi * np.arange(count) / count
            ends = np.zeros(count), np.full(count, farthest)
            found = find_root(past_curve, ends, args=(*turns[None],))
            if not np.all(found.success):
                raise GeometryError(
                    "The seam or a hole does not cut the part as made in a closed curve; check its place, or "
                    "whether the tolerances are larger than the part."
                )
            points = at(found.x, turns)
            if _bulge_mm(points, axis) <= sag_mm:
                return points
            count *= 2


def _bulge_mm(curve: PartPoints, axis: Array | None) -> float:
    """Largest bulge of a closed curve between its points, in space or along the normals of a rim."""
    ahead = np.roll(curve.own_mm, -1, axis=0) - curve.own_mm
    # For even steps the second difference is k l².
    bulge = 0.125 * (ahead - np.roll(ahead, 1, axis=0))
    if axis is None:
        return float(lengths(bulge).max())
    along_normal = np.abs(np.einsum("nx,nx->n", bulge, curve.normal))
    return float(np.maximum(along_normal, np.abs(bulge @ axis)).max())


def _polar(hole: PlacedOpening, points_mm: Array) -> tuple[Array, Array]:
    """Distance of points (n, 3) across the axis of a hole, and along it from its mouth, shapes (n,)."""
    axis = np.array(hole.tool.direction)
    arm = points_mm - np.array(hole.position_mm)
    along = arm @ axis
    return lengths(arm - along[:, None] * axis), along
