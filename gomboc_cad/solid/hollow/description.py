"""What a hollow body is, said once and evaluated by two kernels that share nothing: B-rep and mesh."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.hollow.tools import Tool
from gomboc_cad.solid.offset import InsetSurface

_ENCLOSED_SKIN_MM = 1e-3
_FLUSH_SHARE = 1e-6
_OVERRUN_SHARE = 1e-4


@dataclass(frozen=True)
class HollowBody:
    """A body with a cavity of constant wall, bosses that stand in the cavity, holes and openings.

    The cavity, the bosses and the holes form the core; it moves rigidly by `core_shift_mm`, which is how a
    product puts its centre of mass where it should be. Bosses and holes are stated before that move.
    Openings belong to the outer surface and stay where they are.

    Attributes:
        body: The outer shape.
        wall_mm: Wall thickness along the normal, before the shift; None for a body without a cavity.
        core_shift_mm: Rigid displacement of the core; the thinnest wall is `wall_mm` less its length.
        bosses: Material in the cavity; what reaches into the wall does no harm.
        holes: What is taken away and moves with the core, whether open to the cavity, enclosed or open to
            the outside.
        openings: What is taken away at the end and does not move.

    Raises:
        GeometryError: If the wall is too thick for the body or the shifted cavity breaks through it.
    """

    body: Body
    wall_mm: float | None
    core_shift_mm: Vector = (0.0, 0.0, 0.0)
    bosses: tuple[Tool, ...] = ()
    holes: tuple[Tool, ...] = ()
    openings: tuple[Tool, ...] = ()

    def __post_init__(self) -> None:
        """Refuse walls that cannot be."""
        if self.wall_mm is None:
            return
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
        """Wall left on the side to which the core moved; infinite without a cavity."""
        return math.inf if self.wall_mm is None else self.wall_mm - math.hypot(*self.core_shift_mm)

    @property
    def outer(self) -> InsetSurface:
        """The outer surface."""
        return InsetSurface(self.body)

    @property
    def inner(self) -> InsetSurface | None:
        """The surface of the cavity, shifted, without bosses; None for a body without a cavity."""
        return None if self.wall_mm is None else InsetSurface(self.body, self.wall_mm, self.core_shift_mm)

    @property
    def core(self) -> HollowBody:
        """The core before its shift: cavity, bosses, and the holes that stay inside before and after it."""
        holes = tuple(hole for hole in self._cuts if self._encloses(hole))
        return replace(self, core_shift_mm=(0.0, 0.0, 0.0), holes=holes, openings=())

    @property
    def open_cuts(self) -> tuple[Tool, ...]:
        """Holes that reach the outside, after the core's shift, and the openings."""
        holes = (hole.moved(self.core_shift_mm) for hole in self._cuts if not self._encloses(hole))
        return (*holes, *self._placed_openings)

    @property
    def placed_bosses(self) -> tuple[Tool, ...]:
        """Bosses after the core's shift; none without a cavity."""
        return () if self.wall_mm is None else _moved(self.bosses, self.core_shift_mm)

    @property
    def placed_cuts(self) -> tuple[Tool, ...]:
        """Holes after the core's shift, and the openings, run on into the void where they end flush with it.

        Rounding would leave a skin of no thickness over a mouth that ends in the plane of a boss's end.
        """
        return (*_moved(self._cuts, self.core_shift_mm), *self._placed_openings)

    def in_cavity(self, points_mm: Array) -> NDArray[np.bool_]:
        """Whether points (n, 3) clearly lie in the cavity, bosses or not, and not in a hole."""
        inside = np.zeros(len(points_mm), dtype=bool)
        if self.inner is not None:
            inside |= self.inner.signed_distance_mm(points_mm) < -self._clearance_mm
        for hole in self.placed_cuts:
            inside &= ~hole.within(points_mm, self._clearance_mm)
        return inside

    def in_wall(self, points_mm: Array) -> NDArray[np.bool_]:
        """Whether points (n, 3) clearly lie between the outer surface and the cavity, holes or not."""
        inside: NDArray[np.bool_] = self.outer.signed_distance_mm(points_mm) < -self._clearance_mm
        if self.inner is not None:
            inside &= self.inner.signed_distance_mm(points_mm) > self._clearance_mm
        return inside

    @property
    def _clearance_mm(self) -> float:
        """Distance from a surface at which the side of it is beyond doubt."""
        return _OVERRUN_SHARE * self.body.diameter_mm

    @cached_property
    def _cuts(self) -> tuple[Tool, ...]:
        """The holes before the shift, run on where an end is flush with the void."""
        unshifted = replace(self, core_shift_mm=(0.0, 0.0, 0.0), openings=())
        return unshifted._run_on(self.holes, self.holes)

    @cached_property
    def _placed_openings(self) -> tuple[Tool, ...]:
        """The openings, run on where an end is flush with the void."""
        return self._run_on(self.openings, (*_moved(self.holes, self.core_shift_mm), *self.openings))

    def _run_on(self, tools: Sequence[Tool], cuts: Sequence[Tool]) -> tuple[Tool, ...]:
        """Run tools on beyond those of their flat ends that have the void outside and not inside."""
        ends = [tool.ends() for tool in tools]
        counts = [len(points) for points, _ in ends]
        if not sum(counts):
            return tuple(tools)
        points, normals = (np.concatenate(arrays) for arrays in zip(*ends, strict=True))
        owners = np.repeat(np.arange(len(tools)), counts)
        nudge = _FLUSH_SHARE * self.body.diameter_mm * normals
        flush = self._in_void(points + nudge, owners, tools, cuts)
        flush &= ~self._in_void(points - nudge, owners, tools, cuts)
        by_mm = np.split(_OVERRUN_SHARE * self.body.diameter_mm * flush, np.cumsum(counts)[:-1])
        return tuple(tool.run_on(by) if by.any() else tool for tool, by in zip(tools, by_mm, strict=True))

    def _in_void(
        self, points_mm: Array, owners: NDArray[np.int64], tools: Sequence[Tool], cuts: Sequence[Tool]
    ) -> NDArray[np.bool_]:
        """Whether points lie in the cavity beside the bosses, or in a cut but the tool that owns them."""
        void = np.zeros(len(points_mm), dtype=bool)
        if self.inner is not None:
            void = self.inner.signed_distance_mm(points_mm) < 0.0
            for boss in self.placed_bosses:
                void &= ~boss.contains(points_mm)
        for cut in cuts:
            own = [cut is tool for tool in tools]
            void |= cut.contains(points_mm) & ~np.array(own)[owners]
        return void

    def _encloses(self, hole: Tool) -> bool:
        """Whether a hole stays under the outer surface before and after the shift."""
        hull = hole.hull_mm()
        points = np.concatenate([hull, hull + np.array(self.core_shift_mm)])
        return bool(np.all(self.outer.signed_distance_mm(points) < -_ENCLOSED_SKIN_MM))


def _moved(tools: Sequence[Tool], by_mm: Vector) -> tuple[Tool, ...]:
    return tuple(tool.moved(by_mm) for tool in tools)
