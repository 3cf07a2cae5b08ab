"""Openings of bodies as made: the directions they take away, and the rests on their rims.

Most variants change the slope at a rim by less than the distance of the centre of mass (COM) from a rest on
it, so that nothing changes there. For the others the rim is made anew, moved along the axis of the hole onto
the surface as made, and judged as the rim of any hole is.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, BoolArray, IntArray, unit
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.equilibria.rim import hole_rims_mm, mouths_mm, rim_clearance_mm, rim_rest
from gomboc_cad.tolerance.exact_rests import FoundRests
from gomboc_cad.tolerance.harmonics import derivative_bounds_mm, form_error
from gomboc_cad.tolerance.made_bodies import MadeBodies
from gomboc_cad.tolerance.screening import Changes
from gomboc_cad.tolerance.variants import Nominal, Variants

if TYPE_CHECKING:
    from gomboc_cad.products.openings.placed_opening import PlacedOpening

_SAFETY = 1.5
"""How much more than to first order a variant may move the foot of the COM on a rim."""


@dataclass(frozen=True, eq=False)
class Hole:
    """An opening that is not plugged.

    Attributes:
        base_mm: Inner end of its axis, shape (3,).
        axis: Unit vector out of the body, shape (3,).
        radius_mm: Radius.
        middle: Surface parameter w at the middle of its mouth, shape (3,).
        rim: Surface parameters of points of its rim, shape (k, 3).
        upper: Whether it is in the upper part.
        clearance_mm: How far the nominal COM is from a rest on the rim; 0 if there is one.
    """

    base_mm: Array
    axis: Array
    radius_mm: float
    middle: Array
    rim: Array
    upper: bool
    clearance_mm: float

    def holds(self, points_mm: Array) -> BoolArray:
        """Whether points of a surface (3, n) lie in its mouth, shape (n,)."""
        arm = points_mm - self.base_mm[:, None]
        along = self.axis @ arm
        beside = arm - self.axis[:, None] * along
        result: BoolArray = (along > 0.0) & ((beside * beside).sum(axis=0) < self.radius_mm**2)
        return result


class RimRests(NamedTuple):
    """Rests on rims: variant, direction that points down (k, 3) and height of the COM, for each."""

    row: IntArray
    direction: Array
    height: Array


def holes(nominal: Nominal) -> tuple[Hole, ...]:
    """The openings of a nominal product that are not plugged."""
    open_ones = tuple(opening for opening in nominal.openings if opening.state != "plugged")
    seam = nominal.seam
    above = None if seam is None else (seam.origin_mm, seam.normal)
    return _holes(nominal.body, nominal.com_mm, open_ones, above)


@lru_cache(maxsize=4)
def _holes(
    body: Body,
    com_mm: tuple[float, float, float],
    openings: tuple[PlacedOpening, ...],
    seam: tuple[tuple[float, float, float], tuple[float, float, float]] | None,
) -> tuple[Hole, ...]:
    result = []
    for opening in openings:
        base, axis = np.array(opening.tool.base_mm), unit(np.array(opening.tool.axis, dtype=float))
        mouth = mouths_mm(body, base[None], axis[None])
        rim = hole_rims_mm(body, mouth, axis[None], np.array([opening.tool.radius_mm]))[0]
        upper = seam is not None and float((mouth[0] - np.array(seam[0])) @ np.array(seam[1])) > 0.0
        clearance = rim_clearance_mm(rim, np.array(com_mm))
        result.append(Hole(base, axis, opening.tool.radius_mm, unit(mouth)[0], unit(rim), upper, clearance))
    return tuple(result)


def nominal_rim_direction(nominal: Nominal, smooth_rest: Vector) -> Vector:
    """Direction of the deepest rest of the nominal product on a rim; the smooth one if there is none."""
    com = np.array(nominal.com_mm)
    rims = (nominal.body.position_mm(hole.rim) for hole in holes(nominal))
    rests = [rest for rim in rims if (rest := rim_rest(rim, com)) is not None]
    return min(rests, key=lambda rest: rest.height_mm).direction if rests else smooth_rest


@dataclass(frozen=True, eq=False)
class OpeningCensus:
    """Openings of a block of variants."""

    nominal: Nominal
    variants: Variants
    bodies: MadeBodies
    changes: Changes

    def swallowed(self, found: FoundRests) -> BoolArray:
        """Which rests of the smooth surface lie in a mouth, shape (k,)."""
        result = np.zeros(len(found.row), dtype=bool)
        for hole in holes(self.nominal):
            result |= hole.holds(found.slopes.point)
        return result

    def rests(self, found: FoundRests) -> RimRests:
        """Rests on rims, one for each opening and variant at most."""
        rows, directions, heights = [], [], []
        for hole, effect in self._effects():
            # A smooth rest in the mouth has to be replaced by one on the rim, wherever that is.
            inside = found.row[hole.holds(found.slopes.point)]
            doubtful = effect >= hole.clearance_mm
            doubtful[inside] = True
            for row in np.flatnonzero(doubtful).tolist():
                rest = rim_rest(self._rim_mm(hole, row), self.variants.com_mm[row])
                if rest is not None:
                    rows.append(row)
                    directions.append(rest.direction)
                    heights.append(rest.height_mm)
        return RimRests(
            np.array(rows, dtype=np.int64),
            np.array(directions).reshape(-1, 3),
            np.array(heights, dtype=float),
        )

    def margins_mm(self, rows: IntArray, margin_mm: Array, resting: BoolArray) -> Array:
        """The smaller of S-margins and of the distances of the COM from a rest on a rim, shape (k,).

        Args:
            rows: Variants with one rest, shape (k,).
            margin_mm: Their S-margins without openings, shape (k,).
            resting: Whether a variant rests on a rim, shape (k,).
        """
        result = margin_mm.copy()
        for hole, effect in self._effects():
            near = np.flatnonzero(hole.clearance_mm - effect[rows] < result)
            for index in near.tolist():
                row = int(rows[index])
                clearance = rim_clearance_mm(self._rim_mm(hole, row), self.variants.com_mm[row])
                if clearance == 0.0 and resting[index]:
                    clearance = self._least_slope_mm(hole, row)
                result[index] = min(result[index], clearance)
        return result

    def _effects(self) -> Iterable[tuple[Hole, Array]]:
        """How far each variant may move the foot of the COM at the rim of each hole, shape (n,) each.

        First by what bounds the variant everywhere, then, where that is not enough, by its slope at the
        mouth.
        """
        everyone = np.arange(len(self.variants))
        bounds = derivative_bounds_mm(self.variants.form_mm)
        for hole in holes(self.nominal):
            middle = np.tile(hole.middle, (len(everyone), 1))
            surface = self.bodies.body.surface(hole.middle[None])
            kappa = float(surface.principal_curvatures_per_mm()[0, 0])
            factor = _SAFETY * max(1.0, kappa * float(np.linalg.norm(surface.position_mm)))
            moved = np.linalg.norm(self.variants.com_mm - np.array(self.nominal.com_mm), axis=1)
            # Widened by a tenth: the slopes of a bent surface are farther apart than its radius says.
            across = 1.1 * self.changes.bend_mm * kappa * hole.radius_mm
            stretch = 2.0 * self.changes.stretch / kappa
            effect = factor * (moved + self.changes.shift_mm + bounds[:, 1] + stretch) + across
            close = np.flatnonzero(effect >= hole.clearance_mm)
            if len(close):
                upper = np.full(len(close), hole.upper)
                here = self.bodies.slopes(close, middle[close], upper)
                arm = surface.position_mm[0] - np.array(self.nominal.com_mm)
                slope = arm - (arm @ surface.normal[0]) * surface.normal[0]
                change = here.slope[0] * here.frame[0] + here.slope[1] * here.frame[1] - slope[:, None]
                local = factor * (np.sqrt((change * change).sum(axis=0)) + across[close])
                effect[close] = np.minimum(effect[close], local)
            yield hole, effect

    def _rim_mm(self, hole: Hole, row: int) -> Array:
        """The rim of a hole of a variant as made, shape (k, 3)."""
        surface = self.bodies.body.surface(hole.rim)
        value = form_error(surface.normal, self.variants.form_mm[row]).value_mm
        slant = surface.normal @ hole.axis
        point = surface.position_mm + (value / slant)[:, None] * hole.axis
        result: Array = point @ self.variants.stretch[row].T
        return result + self.variants.upper_shift_mm[row] if hole.upper else result

    def _least_slope_mm(self, hole: Hole, row: int) -> float:
        """Least slope at the rim: how far the COM may move before the body rests beside the hole."""
        rows = np.full(len(hole.rim), row)
        slopes = self.bodies.slopes(rows, hole.rim, np.full(len(rows), hole.upper))
        return float(np.sqrt((slopes.slope * slopes.slope).sum(axis=0)).min())
