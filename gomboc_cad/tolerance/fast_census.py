"""The smooth census of thousands of bodies as made.

A grid of cells over the nominal body tells for all variants at once where they may rest; what it sees and
what it cannot decide is settled exactly, by Newton's method and by splitting cells. See `screening` and
`exact_rests`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, BoolArray, IntArray
from gomboc_cad.equilibria import find_equilibria
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.tolerance.exact_rests import FoundRests, OpenPlaces, RestSearch
from gomboc_cad.tolerance.harmonics import highest_degree
from gomboc_cad.tolerance.made_bodies import MadeBodies
from gomboc_cad.tolerance.opening_rests import OpeningCensus, nominal_rim_direction
from gomboc_cad.tolerance.s_margin import s_margins_mm
from gomboc_cad.tolerance.screening import Changes, Screened, screen
from gomboc_cad.tolerance.seam_line import SeamLine, seam_line
from gomboc_cad.tolerance.seam_rests import (
    Edge,
    edge_margins_mm,
    edge_rests,
    edges,
    rim_heights_mm,
)
from gomboc_cad.tolerance.support_grid import SupportGrid, support_grid
from gomboc_cad.tolerance.variants import (
    MONOSTABLE,
    MULTISTABLE,
    UNDECIDED,
    Nominal,
    Outcomes,
    Variants,
)

_BLOCK = 512
"""Variants at a time."""

_BESIDE = np.cos(np.radians(20.0))
"""Places of the seam nearer than this angle to the rest, whose cosine it is, are the rest's own."""

_MULTIPLE = 64
"""Blocks are filled up to a multiple of this with copies, so that every variant is computed alike."""


def judge(nominal: Nominal, variants: Variants) -> Outcomes:
    """How bodies as made rest.

    The outcome of a variant does not depend on those that are judged with it, as long as matrix products run
    in one thread.

    Args:
        nominal: What is varied.
        variants: The bodies as made.

    Raises:
        NotConvexError: If the nominal body is not strictly convex.
        DegenerateEquilibriaError: If the equilibria of the nominal product are not isolated.
        CensusError: If its COM lies outside the body.
        GombocError: If the number of coefficients of the form error is not that of whole degrees.
    """
    grid = support_grid(nominal, highest_degree(variants.form_mm.shape[1]))
    blocks = []
    for start in range(0, len(variants), _BLOCK):
        rows = np.arange(start, min(start + _BLOCK, len(variants)))
        filled = np.resize(rows, -(-len(rows) // _MULTIPLE) * _MULTIPLE)
        blocks.append(_Block.of(nominal, grid, variants.rows(filled)).outcomes(len(rows)))
    return _joined(blocks)


def nominal_rest_direction(nominal: Nominal) -> Vector:
    """Outward normal that points down at the deepest rest of the nominal product.

    Raises:
        DegenerateEquilibriaError: If its equilibria are not isolated.
        CensusError: If its COM lies outside the body.
    """
    rest = smooth_rest_direction(nominal.body, nominal.com_mm)
    if any(opening.state == "rest" for opening in nominal.openings):
        return nominal_rim_direction(nominal, rest)
    return rest


@lru_cache(maxsize=16)
def smooth_rest_direction(body: Body, com_mm: Vector) -> Vector:
    """Direction of the deepest rest of a body without openings; kept, because every block asks for it."""
    return find_equilibria(body, com_mm)[0].direction


@dataclass(frozen=True, eq=False)
class _Rests:
    """Rests of whatever kind: variant, direction (k, 3), height of the COM, and stiffness (k, 2)."""

    row: IntArray
    direction: Array
    height: Array
    stiffness: Array

    @classmethod
    def joined(cls, parts: list[_Rests]) -> _Rests:
        names = ("row", "direction", "height", "stiffness")
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


@dataclass(frozen=True, eq=False)
class _Block:
    """Variants that are judged together."""

    nominal: Nominal
    grid: SupportGrid
    variants: Variants
    bodies: MadeBodies
    changes: Changes
    screened: Screened

    @classmethod
    def of(cls, nominal: Nominal, grid: SupportGrid, variants: Variants) -> _Block:
        changes = Changes.of(nominal, grid, variants)
        bodies = MadeBodies.of(nominal.body, variants)
        return cls(nominal, grid, variants, bodies, changes, screen(grid, changes))

    def outcomes(self, count: int) -> Outcomes:
        """Outcomes of the first so many."""
        n = len(self.variants)
        search = RestSearch(self.grid, self.bodies, self.changes, self.nominal.seam)
        openings = OpeningCensus(self.nominal, self.variants, self.bodies, self.changes)
        left, found, edge = search.refine(self.screened), search.found, self.edge()
        parts, elsewhere, undecided = [], np.zeros(n, dtype=np.int64), ~self.convex()
        if edge is not None:
            on_edge = edge_rests(self.line(), self.bodies, self.changes, edge)
            undecided |= on_edge.undecided
            across = np.stack([on_edge.along, np.full(len(on_edge.along), np.inf)], axis=1)
            parts.append(_Rests(on_edge.row, on_edge.direction, on_edge.height, across))
            elsewhere = np.bincount(on_edge.row, minlength=n)
        kept = self.look_into(left, search, elsewhere, openings)
        undecided |= found.undecided
        on_rim = openings.rests(found)
        parts.append(_Rests(*on_rim, np.full((len(on_rim.row), 2), np.inf)))
        slopes = found.slopes.rows(kept)
        parts.append(_Rests(found.row[kept], slopes.normal.T, slopes.height, slopes.stiffness().T))
        rests = _Rests.joined(parts)
        stable = np.bincount(rests.row, minlength=n)
        # The search ends at two rests, of which an opening may have taken one away.
        undecided |= (
            (stable < 2) & (found.count > np.bincount(found.row[kept], minlength=n)) & (found.count > 1)
        )
        undecided &= (stable < 2) | ~self.convex()
        verdict = np.where(stable > 1, MULTISTABLE, MONOSTABLE)
        verdict[undecided | (stable == 0)] = UNDECIDED
        direction, stiffness = self.deepest(rests)
        margin = np.where(verdict == MULTISTABLE, 0.0, np.nan)
        single = np.flatnonzero(verdict == MONOSTABLE)
        smooth = self.margins(single, found, edge, direction)
        resting = np.isin(single, on_rim.row)
        margin[single] = openings.margins_mm(single, smooth, resting)
        return Outcomes(
            verdict=verdict.astype(np.int8)[:count],
            stable=stable[:count],
            rest_direction=direction[:count],
            tilt_deg=angles_deg(direction, np.array(nominal_rest_direction(self.nominal)))[:count],
            s_margin_mm=margin[:count],
            stiffness_mm=stiffness[:count],
        )

    def look_into(
        self, left: OpenPlaces, search: RestSearch, elsewhere: IntArray, openings: OpeningCensus
    ) -> BoolArray:
        """Look into what the screening left open, until two rests of a variant are known.

        Returns:
            Which smooth rests neither an opening nor the rim of the other half takes away, shape (k,).
        """
        found, n = search.found, len(self.variants)

        def kept() -> BoolArray:
            result: BoolArray = ~openings.swallowed(found) & ~self.overtopped(found)
            return result

        search.look_into(left, elsewhere)
        number = np.bincount(found.row[kept()], minlength=n) + elsewhere
        # Two were known with one that is taken away.
        cut_short = (found.count + elsewhere > 1) & (found.count < 2) & (number < 2)
        if cut_short.any():
            search.look_into(left.of(cut_short), np.zeros(n, dtype=np.int64))
        return kept()

    def line(self) -> SeamLine:
        """The seam of the nominal body."""
        assert self.nominal.seam is not None
        degree = highest_degree(self.variants.form_mm.shape[1])
        return seam_line(self.nominal.body, self.nominal.com_mm, self.nominal.seam, degree)

    def edge(self) -> Edge | None:
        """Where the halves touch together, if there are two that are displaced."""
        if self.nominal.seam is None or not self.changes.shift_mm.any():
            return None
        return edges(self.line(), self.changes)

    def convex(self) -> BoolArray:
        """Whether the form errors leave the surfaces strictly convex, shape (n,)."""
        result: BoolArray = self.changes.roughness_mm < self.grid.smallest_radius_mm
        return result

    def overtopped(self, found: FoundRests) -> BoolArray:
        """Smooth rests that the rim of the other half keeps off the table, shape (k,)."""
        result = np.zeros(len(found.row), dtype=bool)
        index = np.flatnonzero(self.changes.shift_mm[found.row] > 0.0)
        if len(index):
            row, upper = found.row[index], ~found.upper[index]
            normals = self.nominal.body.normal(found.direction[index])
            rim = rim_heights_mm(self.line(), self.bodies, row, normals, upper)
            result[index] = rim > found.slopes.height[index]
        return result

    def deepest(self, rests: _Rests) -> tuple[Array, Array]:
        """Direction (n, 3) and stiffness (n, 2) of the deepest rest known; NaN if there is none."""
        n = len(self.variants)
        direction, stiffness = np.full((n, 3), np.nan), np.full((n, 2), np.nan)
        # The deepest is written last.
        order = np.argsort(-rests.height, kind="stable")
        direction[rests.row[order]] = rests.direction[order]
        stiffness[rests.row[order]] = rests.stiffness[order]
        return direction, stiffness

    def margins(self, rows: IntArray, found: FoundRests, edge: Edge | None, direction: Array) -> Array:
        """S-margins of variants with one rest, without openings, shape (k,)."""
        shifted = self.changes.shift_mm[rows] > 0.0
        upper = (self.grid.upper[self.screened.start_cell[rows]] == 1.0) & shifted[:, None]
        margin: Array = s_margins_mm(self.bodies, rows, self.screened.start[rows], upper)
        # At a rest the nearest focal point is as far as its stiffness.
        soft = np.full(len(self.variants), np.inf)
        soft[found.row] = found.slopes.softest()
        np.minimum(margin, soft[rows], out=margin)
        if edge is not None:
            clear = self.line().frames.normal @ direction[rows].T < _BESIDE
            on_edge = edge_margins_mm(Edge(*(values[rows] for values in edge)), clear.T)
            margin[shifted] = np.minimum(margin, on_edge)[shifted]
        return margin


def angles_deg(directions: Array, other: Array) -> Array:
    """Angles between unit vectors (n, 3) and another one, to all digits, shape (n,)."""
    across = np.cross(directions, other)
    cosine = directions[:, 0] * other[0] + directions[:, 1] * other[1] + directions[:, 2] * other[2]
    sine = np.sqrt(across[:, 0] ** 2 + across[:, 1] ** 2 + across[:, 2] ** 2)
    result: Array = np.degrees(np.arctan2(sine, cosine))
    return result


def _joined(blocks: list[Outcomes]) -> Outcomes:
    if not blocks:
        return Outcomes(
            np.zeros(0, dtype=np.int8),
            np.zeros(0, dtype=np.int64),
            np.zeros((0, 3)),
            np.zeros(0),
            np.zeros(0),
            np.zeros((0, 2)),
        )
    names = ("verdict", "stable", "rest_direction", "tilt_deg", "s_margin_mm", "stiffness_mm")
    return Outcomes(*(np.concatenate([getattr(block, name) for block in blocks]) for name in names))
