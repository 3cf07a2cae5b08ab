"""What a hollow body is, said once and evaluated by two kernels that share nothing: B-rep and mesh."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.offset import InsetSurface

_ENCLOSED_SKIN_MM = 1e-3
_FLUSH_SHARE = 1e-6
_OVERRUN_SHARE = 1e-4


@dataclass(frozen=True)
class Cylinder:
    """A right circular cylinder.

    Attributes:
        base_mm: Centre of the base.
        axis: Direction from the base to the other end, of any length but zero.
        radius_mm: Radius.
        length_mm: Length along the axis.

    Raises:
        GeometryError: If a size is not a positive length or the axis has no direction.
    """

    base_mm: Vector
    axis: Vector
    radius_mm: float
    length_mm: float

    def __post_init__(self) -> None:
        """Refuse sizes that make no cylinder."""
        if not all(math.isfinite(size) and size > 0.0 for size in (self.radius_mm, self.length_mm)):
            raise GeometryError(
                f"A cylinder needs a positive radius and length in mm, not {self.radius_mm!r} and "
                f"{self.length_mm!r}."
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

    def moved(self, by_mm: Vector) -> Cylinder:
        """Give the cylinder displaced rigidly."""
        x, y, z = (a + b for a, b in zip(self.base_mm, by_mm, strict=True))
        return replace(self, base_mm=(x, y, z))

    def extended(self, before_mm: float, after_mm: float) -> Cylinder:
        """Give the cylinder made longer at its base and at its other end."""
        x, y, z = (a - before_mm * b for a, b in zip(self.base_mm, self.direction, strict=True))
        return replace(self, base_mm=(x, y, z), length_mm=self.length_mm + before_mm + after_mm)

    def contains(self, points_mm: Array) -> NDArray[np.bool_]:
        """Whether points (n, 3) lie inside, shape (n,)."""
        arm = points_mm - np.array(self.base_mm)
        height = arm @ np.array(self.direction)
        beside = np.linalg.norm(arm - height[:, None] * np.array(self.direction), axis=1) < self.radius_mm
        inside: NDArray[np.bool_] = beside & (height > 0.0) & (height < self.length_mm)
        return inside

    def rims_mm(self, count: int = 64) -> Array:
        """Points around both ends, shape (2·count, 3); the cylinder is their convex hull."""
        direction = np.array(self.direction)
        side, up = np.linalg.svd(direction[None])[2][1:]
        angle = 2.0 * np.pi * np.arange(count) / count
        circle = self.radius_mm * (np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * up)
        return np.concatenate([circle, circle + self.length_mm * direction]) + np.array(self.base_mm)


@dataclass(frozen=True)
class HollowBody:
    """A body with a cavity of constant wall, bosses that stand in the cavity, and holes.

    The cavity, the bosses and the holes form the core; it moves rigidly by `core_shift_mm`, which is how a
    product puts its centre of mass where it should be. Bosses and holes are stated before that move.

    Attributes:
        body: The outer shape.
        wall_mm: Wall thickness along the normal, before the shift.
        core_shift_mm: Rigid displacement of the core; the thinnest wall is `wall_mm` less its length.
        bosses: Cylinders of material in the cavity; what reaches into the wall does no harm.
        holes: Cylinders taken away at the end, whether open to the cavity, enclosed or open to the outside.

    Raises:
        GeometryError: If the wall is too thick for the body or the shifted cavity breaks through it.
    """

    body: Body
    wall_mm: float
    core_shift_mm: Vector = (0.0, 0.0, 0.0)
    bosses: tuple[Cylinder, ...] = ()
    holes: tuple[Cylinder, ...] = ()

    def __post_init__(self) -> None:
        """Refuse walls that cannot be."""
        if not self.wall_mm > 0.0:
            raise GeometryError(f"The wall must be a positive thickness in mm, not {self.wall_mm!r}.")
        if self.thinnest_wall_mm <= 0.0:
            raise GeometryError(
                f"Moving the cavity by {math.hypot(*self.core_shift_mm):.4g} mm breaks through the wall of "
                f"{self.wall_mm:g} mm; make the wall thicker or the shift smaller."
            )
        # Raises where the wall is too thick for the body.
        _ = self.inner

    @property
    def thinnest_wall_mm(self) -> float:
        """Wall left on the side to which the core moved."""
        return self.wall_mm - math.hypot(*self.core_shift_mm)

    @property
    def outer(self) -> InsetSurface:
        """The outer surface."""
        return InsetSurface(self.body)

    @property
    def inner(self) -> InsetSurface:
        """The surface of the cavity, shifted, without bosses."""
        return InsetSurface(self.body, self.wall_mm, self.core_shift_mm)

    @property
    def core(self) -> HollowBody:
        """The core before its shift: cavity, bosses, and the holes that stay inside before and after it."""
        holes = tuple(hole for hole in self._cuts if self._encloses(hole))
        return replace(self, core_shift_mm=(0.0, 0.0, 0.0), holes=holes)

    @property
    def open_holes(self) -> tuple[Cylinder, ...]:
        """Holes that reach the outside, after the core's shift."""
        return tuple(hole.moved(self.core_shift_mm) for hole in self._cuts if not self._encloses(hole))

    @property
    def placed_bosses(self) -> tuple[Cylinder, ...]:
        """Bosses after the core's shift."""
        return tuple(boss.moved(self.core_shift_mm) for boss in self.bosses)

    @property
    def placed_holes(self) -> tuple[Cylinder, ...]:
        """Holes after the core's shift, run on into the void where their mouth is flush with it.

        Rounding would leave a skin of no thickness over a mouth that ends in the plane of a boss's end.
        """
        return tuple(hole.moved(self.core_shift_mm) for hole in self._cuts)

    @cached_property
    def _cuts(self) -> tuple[Cylinder, ...]:
        """The holes before the shift, run on where their mouth is flush with the void."""
        nudge, overrun = _FLUSH_SHARE * self.body.diameter_mm, _OVERRUN_SHARE * self.body.diameter_mm
        cuts = []
        for hole in self.holes:
            along = np.array([-nudge, nudge, hole.length_mm - nudge, hole.length_mm + nudge])
            points = np.array(hole.base_mm) + along[:, None] * np.array(hole.direction)
            under, base, top, over = self._void(points, hole)
            cuts.append(hole.extended(overrun * (under and not base), overrun * (over and not top)))
        return tuple(cuts)

    def _void(self, points_mm: Array, but_for: Cylinder) -> list[bool]:
        """Whether points lie in the unshifted cavity beside the bosses, or in a hole other than one."""
        inner = InsetSurface(self.body, self.wall_mm)
        void = inner.signed_distance_mm(points_mm) < 0.0
        for boss in self.bosses:
            void &= ~boss.contains(points_mm)
        for hole in self.holes:
            if hole is not but_for:
                void |= hole.contains(points_mm)
        return void.tolist()

    def _encloses(self, hole: Cylinder) -> bool:
        """Whether a hole stays under the outer surface before and after the shift."""
        rims = np.concatenate([hole.rims_mm(), hole.moved(self.core_shift_mm).rims_mm()])
        return bool(np.all(self.outer.signed_distance_mm(rims) < -_ENCLOSED_SKIN_MM))
