"""The rests of bodies as made, found exactly from where the screening saw them or could not decide.

Likely rests are refined by Newton's method. The cells that the screening left open are split until the slope,
and how fast it may change, tell that there is no rest in them or that the height is convex in them, so that
Newton's method finds the only one. A variant with two rests known needs no more.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray, IntArray, unit
from gomboc_cad.tolerance.made_bodies import MadeBodies, Slopes
from gomboc_cad.tolerance.screening import Changes, Screened
from gomboc_cad.tolerance.support_grid import SupportGrid
from gomboc_cad.tolerance.variants import SeamPlane

_NEWTON_STEPS = 25
_CONVERGED = 1e-12
"""Last Newton step, in units of R₀."""

_SAME = 1e-6
"""Distance, in units of R₀, of rests that are one."""

_FORETOLD = 0.25
"""How far a rest may be from where it was expected, in units of the reach of the cell."""

_STRAY = 4.0
"""How far Newton's method may lead away from its start, in units of the reach of the cell."""

_CHILD = 0.53
"""Reach of the parts of a cell, in units of its own; ½ on a plane."""

_DEEPEST = 14
_MOST_CELLS_PER_VARIANT = 3000
"""Cells looked into before a variant is given up as undecided."""

_TRIALS = 2
"""Cells of a variant from which Newton's method is tried before it is certain to end at a rest."""

_ENOUGH = 2
"""Rests of a multistable variant."""


@dataclass(eq=False)
class FoundRests:
    """Rests of smooth surfaces of n variants, as they are found.

    Attributes:
        count: How many are known of each variant, shape (n,).
        undecided: Whether there may be others, shape (n,).
        row: Variant of each rest, shape (k,).
        direction: Its surface parameter w, shape (k, 3).
        upper: Whether it is on the displaced upper part, shape (k,).
        slopes: Height and stiffness there.
    """

    count: IntArray
    undecided: BoolArray
    row: IntArray
    direction: Array
    upper: BoolArray
    slopes: Slopes

    @classmethod
    def none(cls, bodies: MadeBodies) -> FoundRests:
        """No rest yet."""
        empty = bodies.slopes(np.zeros(0, dtype=np.int64), np.zeros((0, 3)), np.zeros(0, dtype=bool))
        n = len(bodies.com_mm)
        return cls(
            np.zeros(n, dtype=np.int64),
            np.zeros(n, dtype=bool),
            np.zeros(0, dtype=np.int64),
            np.zeros((0, 3)),
            np.zeros(0, dtype=bool),
            empty,
        )

    def add(self, row: IntArray, direction: Array, upper: BoolArray, slopes: Slopes) -> None:
        """Add rests that are new, one per variant at most."""
        self.count = self.count + np.bincount(row, minlength=len(self.count))
        self.row = np.concatenate([self.row, row])
        self.direction = np.concatenate([self.direction, direction])
        self.upper = np.concatenate([self.upper, upper])
        joined = (np.concatenate(pair, axis=-1) for pair in zip(self.slopes, slopes, strict=True))
        self.slopes = Slopes(*joined)

    def near(self, row: IntArray, place: Array, upper: BoolArray, distance_mm: Array) -> BoolArray:
        """Whether places (3, k) of variants are nearer to a known rest than a distance, shape (k,)."""
        result = np.zeros(len(row), dtype=bool)
        order = np.argsort(self.row, kind="stable")
        start = np.searchsorted(self.row[order], row)
        stop = np.searchsorted(self.row[order], row, side="right")
        for number in range(int((stop - start).max(initial=0))):
            has = np.flatnonzero(start + number < stop)
            rest = order[start[has] + number]
            gap = place[:, has] - self.slopes.place[:, rest]
            close = (gap * gap).sum(axis=0) < distance_mm[has] ** 2
            result[has] |= close & (self.upper[rest] == upper[has])
        return result


class OpenPlaces(NamedTuple):
    """Cells of the grid that may hold a rest.

    Attributes:
        row: Variant of each, shape (k,).
        cell: Its number in the grid, shape (k,).
        upper: Whether the displaced upper part is meant, shape (k,).
    """

    row: IntArray
    cell: IntArray
    upper: BoolArray

    def of(self, variants: BoolArray) -> OpenPlaces:
        """Those of some variants, chosen by flags of shape (n,)."""
        chosen = variants[self.row]
        return OpenPlaces(self.row[chosen], self.cell[chosen], self.upper[chosen])


@dataclass(eq=False)
class RestSearch:
    """Finds the rests of the smooth surface of a block of variants.

    Attributes:
        grid: The cells.
        bodies: The bodies as made.
        changes: The same as small changes.
        seam: Outer parting, if there is one.
        found: What is known so far.
    """

    grid: SupportGrid
    bodies: MadeBodies
    changes: Changes
    seam: SeamPlane | None
    found: FoundRests = field(init=False)

    def __post_init__(self) -> None:
        """Start with nothing."""
        self.found = FoundRests.none(self.bodies)

    @property
    def _unit_mm(self) -> float:
        return self.bodies.body.radius_mm

    def refine(self, screened: Screened) -> OpenPlaces:
        """Find the rests that a screening foresees; what is left to be looked into."""
        cell = screened.cell
        upper = self._is_upper(screened.row, cell)
        failed = self._refine(screened.row, screened.place, self.grid.reach_mm[cell], upper)
        row = np.concatenate([screened.open_row, screened.row[failed]])
        cell = np.concatenate([screened.open_cell, cell[failed]])
        split = (self.grid.upper[cell] == 0.5) & (self.changes.shift_mm[row] > 0.0)
        upper = np.concatenate([self._is_upper(row, cell), np.ones(int(split.sum()), dtype=bool)])
        return OpenPlaces(np.concatenate([row, row[split]]), np.concatenate([cell, cell[split]]), upper)

    def _is_upper(self, row: IntArray, cell: IntArray) -> BoolArray:
        """Whether a cell is in the displaced part; without a displacement it does not matter."""
        result: BoolArray = (self.grid.upper[cell] == 1.0) & (self.changes.shift_mm[row] > 0.0)
        return result

    def _refine(self, row: IntArray, start: Array, reach: Array, upper: BoolArray) -> BoolArray:
        """Refine likely rests; True where there turned out to be none, shape (k,)."""
        failed = np.zeros(len(row), dtype=bool)
        pending = np.arange(len(row))
        place = self.bodies.body.position_mm(start).T if len(row) else np.zeros((3, 0))
        while len(pending):
            # The places of one rest are told by several cells; the first of each variant speaks for them.
            first = pending[np.unique(row[pending], return_index=True)[1]]
            good = self._descend(row[first], start[first], reach[first], upper[first])
            failed[first[~good]] = True
            pending = np.setdiff1d(pending, first, assume_unique=True)
            told = self.found.near(
                row[pending], place[:, pending], upper[pending], _FORETOLD * reach[pending]
            )
            pending = pending[~told]
        return failed

    def _descend(self, row: IntArray, start: Array, reach: Array, upper: BoolArray) -> BoolArray:
        """Newton from one place per variant; notes new rests, and tells where one was reached, shape (k,)."""
        direction = start.copy()
        origin = self.bodies.body.position_mm(start).T
        active = np.arange(len(row))
        result = np.zeros(len(row), dtype=bool)
        for _ in range(_NEWTON_STEPS):
            if len(active) == 0:
                break
            slopes = self.bodies.slopes(row[active], direction[active], upper[active])
            step = slopes.step()
            length = np.sqrt((step * step).sum(axis=0))
            stray = slopes.place - origin[:, active]
            lost = np.sqrt((stray * stray).sum(axis=0)) > _STRAY * reach[active]
            done = ~lost & (length <= _CONVERGED * self._unit_mm)
            stable = done & (slopes.softest() > 0.0)
            self._note(row[active], direction[active], upper[active], slopes, stable)
            result[active[stable]] = True
            step *= np.minimum(1.0, 2.0 * reach[active] / np.maximum(length, 1e-300))
            going = ~(done | lost)
            direction[active] = slopes.moved(step)
            active = active[going]
        return result

    def _note(
        self, row: IntArray, direction: Array, upper: BoolArray, slopes: Slopes, stable: BoolArray
    ) -> None:
        """Add those that are stable, new, and on the part of the surface that they are meant for."""
        index = np.flatnonzero(stable)
        if self.seam is not None:
            above = np.array(self.seam.normal) @ (
                slopes.point[:, index] - np.array(self.seam.origin_mm)[:, None]
            )
            shifted = self.changes.shift_mm[row[index]] > 0.0
            index = index[~shifted | ((above > 0.0) == upper[index])]
        same = np.full(len(index), _SAME * self._unit_mm)
        known = self.found.near(row[index], slopes.place[:, index], upper[index], same)
        index = index[~known]
        self.found.add(row[index], direction[index], upper[index], slopes.rows(index))

    def look_into(self, places: OpenPlaces, elsewhere: IntArray) -> None:
        """Split cells until it is known whether a rest is in them.

        Args:
            places: The cells.
            elsewhere: How many rests each variant has besides, shape (n,); two in all settle it.
        """
        grid, changes = self.grid, self.changes
        row, cell, upper = places
        kappa = grid.curvature_per_mm[cell, 0]
        rate = grid.rate_per_mm[cell] * (1.0 + changes.stretch[row]) + changes.third_mm[row] * kappa**2
        rate = rate + changes.bend_mm[row] * grid.curvature_rate[cell]
        cells = _OpenCells(row, grid.corners[cell], grid.reach_mm[cell], rate, upper)
        visited = np.zeros(len(self.found.count), dtype=np.int64)
        for _ in range(_DEEPEST):
            visited += np.bincount(cells.row, minlength=len(visited))
            wanted = (self.found.count + elsewhere < _ENOUGH) & (visited < _MOST_CELLS_PER_VARIANT)
            cells = cells.rows(wanted[cells.row]).split()
            if len(cells.row) == 0:
                break
            cells = cells.rows(self._left(cells))
        open_rows = np.bincount(cells.row, minlength=len(visited)) > 0
        open_rows |= visited >= _MOST_CELLS_PER_VARIANT
        self.found.undecided |= open_rows & (self.found.count + elsewhere < _ENOUGH)

    def _left(self, cells: _OpenCells) -> BoolArray:
        """Which cells are still undecided, shape (k,); rests that are met on the way are noted."""
        centers, reach = cells.centers(), cells.reach
        slopes = self.bodies.slopes(cells.row, centers, cells.upper)
        change = cells.rate * reach
        left = ~_empty(slopes, reach, change) & ~self._settled(cells, slopes)
        softest, step = _lowest_rate(slopes), slopes.step()
        convex = left & (softest > change)
        # Two rests settle a variant sooner than all of its cells.
        hopeful = left & ~convex & (softest > 0.0) & ((step * step).sum(axis=0) < reach * reach)
        starts = _one_per_row(np.flatnonzero(convex), cells.row)
        starts += _one_per_row(np.flatnonzero(hopeful), cells.row)[:_TRIALS]
        for turn in starts:
            self._descend(cells.row[turn], centers[turn], reach[turn], cells.upper[turn])
        return left & ~convex

    def _settled(self, cells: _OpenCells, slopes: Slopes) -> BoolArray:
        """Cells so near to a known rest that the height is convex all the way: they hold no other."""
        found = self.found
        radius = np.full(len(found.count), 0.0)
        np.maximum.at(radius, found.row, _lowest_rate(found.slopes))
        distance = np.maximum(radius[cells.row] / cells.rate - cells.reach, 0.0)
        return found.near(cells.row, slopes.place, cells.upper, distance)


class _OpenCells(NamedTuple):
    """Cells of variants that are looked into.

    Attributes:
        row: Variant of each, shape (k,).
        corners: Corners as directions w, shape (k, 3, 3).
        reach: Reach along the surface, shape (k,).
        rate: Bound on the change of A per mm, shape (k,).
        upper: Whether the displaced upper part is meant, shape (k,).
    """

    row: IntArray
    corners: Array
    reach: Array
    rate: Array
    upper: BoolArray

    def rows(self, chosen: BoolArray | IntArray) -> _OpenCells:
        """Some of the cells."""
        row, corners, reach, rate, upper = self
        return _OpenCells(row[chosen], corners[chosen], reach[chosen], rate[chosen], upper[chosen])

    def split(self) -> _OpenCells:
        """Each cell in four parts."""
        parent = np.repeat(np.arange(len(self.row)), 4)
        return self.rows(parent)._replace(corners=_parts(self.corners), reach=_CHILD * self.reach[parent])

    def centers(self) -> Array:
        """Directions w of their centres, shape (k, 3)."""
        return unit(self.corners.sum(axis=1))


def _parts(corners: Array) -> Array:
    """Spherical triangles (n, 3, 3) split into four each, shape (4 n, 3, 3)."""
    a, b, c = corners.transpose(1, 0, 2)
    ab, bc, ca = unit(a + b), unit(b + c), unit(c + a)
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.stack([np.stack(part, axis=1) for part in parts], axis=1).reshape(-1, 3, 3)


def _symmetric_part(slopes: Slopes) -> tuple[Array, Array, Array]:
    """Mean and half difference of the diagonal, and the other component, of the symmetric part of A."""
    a11, a12, a21, a22 = slopes.rate
    return 0.5 * (a11 + a22), 0.5 * (a11 - a22), 0.5 * (a12 + a21)


def _lowest_rate(slopes: Slopes) -> Array:
    """Smaller eigenvalue of the symmetric part of A."""
    mean, half, other = _symmetric_part(slopes)
    return mean - np.hypot(half, other)


def _empty(slopes: Slopes, reach: Array, change: Array) -> BoolArray:
    """Whether cells hold no rest: the slope vanishes nowhere in them, or the height is no minimum there."""
    a11, a12, a21, a22 = slopes.rate
    g1, g2 = slopes.slope
    _, half, other = _symmetric_part(slopes)
    angle = 0.5 * np.arctan2(other, half)
    c, s = np.cos(angle), np.sin(angle)
    result = np.zeros(len(g1), dtype=bool)
    for x, y in ((c, s), (-s, c)):
        size = np.hypot(x * a11 + y * a21, x * a12 + y * a22)
        result |= np.abs(x * g1 + y * g2) > (size + 0.5 * change) * reach
    total = np.abs(slopes.rate).sum(axis=0)
    determinant = a11 * a22 - a12 * a21 + change * total + 2.0 * change * change
    result |= (a11 + a22 + 2.0 * change < 0.0) | (determinant < 0.0)
    return result


def _one_per_row(index: IntArray, row: IntArray) -> list[IntArray]:
    """Split indices into groups in which no variant occurs twice."""
    groups = []
    while len(index):
        first = np.unique(row[index], return_index=True)[1]
        groups.append(index[first])
        index = np.delete(index, first)
    return groups
