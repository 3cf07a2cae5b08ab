"""Where thousands of variants may rest, told for all of them at once.

In each cell of a `SupportGrid` the slope g of a variant is known with two derivatives and a bound on the rest
of the expansion. A cell holds no rest where the slope cannot vanish in it, or where the height is not a
minimum wherever it does. Of what is left most is decided by the expansion: at the bottom of the valley
through the cell the slope along it changes its sign once, upwards, or not at all. A cell that cannot be
decided is handed on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gomboc_cad.body.sphere import Array, BoolArray, IntArray
from gomboc_cad.tolerance.harmonics import derivative_bounds_mm, highest_degree, largest_bends_mm
from gomboc_cad.tolerance.support_grid import SYMMETRIC, SupportGrid
from gomboc_cad.tolerance.variants import Nominal, Variants

_ROWS = 64
"""Variants at a time: their arrays fit into the cache. Fixed, so that every row is multiplied alike."""

STARTS = 8
"""Places from which the S-margin is looked for."""

_APART = np.cos(np.radians(12.0))
"""Starts of the search for the S-margin are farther apart than this angle, whose cosine it is."""

_MUCH_FARTHER = 12.0
"""A nominal focal point that is so many times as far as the nearest one is not made the nearest one."""

_ROUNDING = 1e-6
"""Relative rounding error of the matrix products, which are in single precision."""

_FARTHEST = 3.0
"""How far from the centre of a cell the zero of its expansion may be to be worth anything, in its reach."""

_FLOOR_REACH = 1.5
"""How far a valley may be from the centre of a cell to be its own, in units of its reach."""


@dataclass(frozen=True, eq=False)
class Changes:
    """Variants as small changes of the nominal body.

    Attributes:
        coordinates: What multiplies the rows of `SupportGrid.linear`, float32, shape (n, D).
        slope_error_mm: What their slopes lack because the stretch counts to first order, shape (n,).
        bend_error_mm: The same for the Hessians.
        bend_mm: Bound on the change of the Hessian by the variant, shape (n,).
        third_mm: Bound on the change of its derivative.
        fourth_mm: Bound on the change of its second derivative.
        stretch: Size of the anisotropic stretch, shape (n,).
        shift_mm: Size of the displacement of the upper part, shape (n,).
        roughness_mm: Bound on what the form error takes from a radius of curvature, shape (n,).
    """

    coordinates: NDArray[np.float32]
    slope_error_mm: Array
    bend_error_mm: Array
    bend_mm: Array
    third_mm: Array
    fourth_mm: Array
    stretch: Array
    shift_mm: Array
    roughness_mm: Array

    @classmethod
    def of(cls, nominal: Nominal, grid: SupportGrid, variants: Variants) -> Changes:
        """Changes of variants.

        With `S⁻² = m (1 + μ)` the height is, but for a factor, `(h + δ − S⁻¹c·v) (1 + vᵀμv)^(−½)`.
        """
        inverse = np.linalg.inv(variants.stretch)
        metric = inverse @ inverse
        mean = np.trace(metric, axis1=1, axis2=2) / 3.0
        mu = metric / mean[:, None, None] - np.eye(3)
        shift = (inverse @ variants.com_mm[:, :, None])[:, :, 0] - np.array(nominal.com_mm)
        upper = (inverse @ variants.upper_shift_mm[:, :, None])[:, :, 0]
        stretching = np.stack([mu[:, i, j] for i, j in SYMMETRIC], axis=1)
        one = np.ones((len(mean), 1))
        coordinates = np.concatenate([variants.form_mm, shift, stretching, upper, one], axis=1)
        # The largest |vᵀμv|, and the largest change of the height by it.
        size = np.abs(np.linalg.eigvalsh(mu)).max(axis=1)
        linear = grid.height_mm * size
        displaced = np.linalg.norm(upper, axis=1)
        moved = np.linalg.norm(shift, axis=1) + displaced
        value, slope, _, third, fourth = derivative_bounds_mm(variants.form_mm).T
        # By Bernstein's inequality a derivative is N times as large at most.
        degree = highest_degree(variants.form_mm.shape[1])
        bend = largest_bends_mm(variants.form_mm)
        roughness = bend + value
        third = np.minimum(third, degree * bend)
        fourth = np.minimum(fourth, degree * third)
        # What the stretch does to second order, and what it does to the other changes.
        squared = linear * size
        return cls(
            coordinates=coordinates.astype(np.float32),
            slope_error_mm=2.0 * squared + size * (0.5 * slope + value + moved),
            bend_error_mm=8.0 * squared + size * (0.5 * bend + 2.0 * slope + 2.0 * value + 2.0 * moved),
            bend_mm=bend + moved + 2.0 * linear,
            third_mm=third + slope + moved + 12.0 * linear,
            fourth_mm=fourth + 4.0 * bend + moved + 32.0 * linear,
            stretch=size,
            shift_mm=displaced,
            roughness_mm=roughness,
        )

    @property
    def upper_shift_mm(self) -> Array:
        """Displacement S⁻¹ d of the upper part before the stretch, shape (n, 3)."""
        return self.coordinates[:, -4:-1].astype(float)

    def part(self, rows: slice) -> Changes:
        """Some of the variants."""
        return Changes(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))


class Screened(NamedTuple):
    """What the screening leaves to be done exactly.

    Attributes:
        row: Variant of each likely rest, shape (k,).
        place: Where it should be, as a direction w, shape (k, 3).
        cell: Its cell, shape (k,).
        open_row: Variant of each cell that could not be decided, shape (j,).
        open_cell: The cell, shape (j,).
        start: Where a focal point seems nearest to the COM, several directions w per variant, shape
            (n, STARTS, 3).
        start_cell: Their cells, shape (n, STARTS).
    """

    row: IntArray
    place: Array
    cell: IntArray
    open_row: IntArray
    open_cell: IntArray
    start: Array
    start_cell: IntArray


def screen(grid: SupportGrid, changes: Changes) -> Screened:
    """Screen variants; their number is a multiple of 64."""
    parts = list(_screened(grid, changes))
    return Screened(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def _screened(grid: SupportGrid, changes: Changes) -> Iterator[Screened]:
    flat = grid.linear.reshape(len(grid.linear), -1)
    allowed, worth = _allowed_rows(grid), _worth_a_start(grid)
    for first in range(0, len(changes.coordinates), _ROWS):
        part = changes.part(slice(first, first + _ROWS))
        jets = (part.coordinates @ flat).reshape(_ROWS, 5, -1)
        size = np.abs(jets)
        allowance = _allowances(part) @ allowed
        allowance += size[:, 3]
        left = size[:, 0] <= size[:, 2] + allowance
        left &= size[:, 1] <= size[:, 4] + allowance
        row, cell = np.nonzero(left)
        cells = _Cells.of(grid, part, jets, row, cell)
        rests, undecided, place = cells.judged()
        # In a cell at the seam the upper part has slopes of its own, which the expansion only brackets.
        seam = (grid.upper[cell] == 0.5) & (part.shift_mm[row] > 0.0)
        undecided, rests = undecided | (seam & ~cells.never()), rests & ~seam
        start, start_cell = _starts(grid, jets, worth)
        yield Screened(
            row=row[rests] + first,
            place=_places(grid, cell[rests], place[rests]),
            cell=cell[rests],
            open_row=row[undecided] + first,
            open_cell=cell[undecided],
            start=start,
            start_cell=start_cell,
        )


def _allowances(changes: Changes) -> NDArray[np.float32]:
    """Factors of the rows of `_allowed_rows` for variants, shape (n, 6)."""
    one = np.ones(len(changes.stretch))
    columns = [
        one + changes.stretch,
        changes.third_mm,
        changes.bend_mm,
        changes.bend_error_mm,
        changes.slope_error_mm,
        changes.shift_mm,
    ]
    return np.stack(columns, axis=1).astype(np.float32)


def _allowed_rows(grid: SupportGrid) -> NDArray[np.float32]:
    """By how much the slope in a cell may be off its linear expansion, for each cause, shape (6, m)."""
    kappa, reach = grid.curvature_per_mm[:, 0], grid.reach_mm
    rows = [
        0.5 * grid.rate_per_mm * reach**2,
        0.5 * kappa**2 * reach**2,
        0.5 * grid.curvature_rate * reach**2,
        kappa * reach,
        np.ones_like(kappa),
        0.5 * (grid.upper == 0.5) * (1.0 + kappa * reach),
    ]
    return np.stack(rows).astype(np.float32)


def _places(grid: SupportGrid, cells: IntArray, offset: Array) -> Array:
    """Directions w at offsets (k, 2) in the tangent planes of cells."""
    target = grid.position_mm[cells] + np.einsum("ka,kax->kx", offset, grid.frame[cells])
    result: Array = target / np.sqrt(np.einsum("kx,kx->k", target, target))[:, None]
    return result


def _starts(grid: SupportGrid, jets: NDArray[np.float32], worth: IntArray) -> tuple[Array, IntArray]:
    """The places, apart from each other, where a focal point seems nearest to the COM, and their cells.

    Args:
        grid: The cells.
        jets: Slopes and Hessians of variants, shape (n, 5, m).
        worth: Cells that are looked at.
    """
    distance = _focal_squares(grid, jets[:, :, worth], worth)
    centers = grid.centers[worth]
    places, cells = [], []
    for _ in range(STARTS):
        nearest = distance.argmin(axis=1)
        cells.append(worth[nearest])
        places.append(_floor_places(grid, jets, cells[-1]))
        distance[(centers @ centers[nearest].T).T > _APART] = np.inf
    return np.stack(places, axis=1), np.stack(cells, axis=1)


def _worth_a_start(grid: SupportGrid) -> IntArray:
    """Cells in which a focal point of the nominal body is not much farther than the nearest one."""
    squares = _focal_squares(grid, grid.linear[-1][None], np.arange(len(grid)))[0]
    return np.flatnonzero(squares <= _MUCH_FARTHER**2 * squares.min())


def _focal_squares(grid: SupportGrid, jets: NDArray[np.float32], cells: IntArray) -> NDArray[np.float32]:
    """Squares of the distances of focal points in cells from the COM, for jets (n, 5, k), shape (n, k).

    A cell stands for the bottom of a valley that passes near its centre: across the valley, along the stiff
    direction, a slope counts as far only as it does not vanish within reach.
    """
    kappa, reach = grid.curvature_per_mm[cells].astype(np.float32), grid.reach_mm[cells].astype(np.float32)
    g1, g2 = jets[:, 0], jets[:, 1]
    h11, h12, h22 = (jets[:, 2 + k] * (1.0 / (kappa[:, k // 2] * reach)) for k in range(3))
    half, mean = 0.5 * (h11 - h22), 0.5 * (h11 + h22)
    spread = np.hypot(half, h12)
    squares, difference = g1 * g1 + g2 * g2, g1 * g1 - g2 * g2
    turned = (half * difference + 2.0 * h12 * g1 * g2) / np.maximum(spread, np.float32(1e-30))
    stiff = np.sqrt(np.maximum(0.5 * (squares + turned), np.float32(0.0)))
    stiff -= np.float32(_FLOOR_REACH) * kappa[:, 1] * reach * np.abs(mean + spread)
    np.maximum(stiff, np.float32(0.0), out=stiff)
    result: NDArray[np.float32] = (
        np.maximum(0.5 * (squares - turned), np.float32(0.0)) + stiff * stiff + (mean - spread) ** 2
    )
    return result


def _floor_places(grid: SupportGrid, jets: NDArray[np.float32], cell: IntArray) -> Array:
    """Places near the centres of cells (n,) on the bottom of the valleys through them, shape (n, 3)."""
    rows = np.arange(len(jets))
    g1, g2, h11, h12, h22 = jets[rows, :, cell].T.astype(float)
    (k1, k2), reach = grid.curvature_per_mm[cell].T, grid.reach_mm[cell]
    h11, h12, h22 = h11 / (k1 * reach), h12 / (k1 * reach), h22 / (k2 * reach)
    angle = 0.5 * np.arctan2(h12, 0.5 * (h11 - h22))
    x, y = np.cos(angle), np.sin(angle)
    stiffness = 0.5 * (h11 + h22) + np.hypot(0.5 * (h11 - h22), h12)
    turn = -(x * g1 + y * g2) / np.where(stiffness == 0.0, np.inf, stiffness)
    offset = np.stack([turn * x / k1, turn * y / k2], axis=1)
    length = np.hypot(offset[:, 0], offset[:, 1])
    offset *= np.minimum(1.0, _FLOOR_REACH * reach / np.maximum(length, 1e-300))[:, None]
    return _places(grid, cell, offset)


@dataclass(frozen=True, eq=False)
class _Cells:
    """Expansions of the slope of variants in cells; x and y are the principal directions of the centre.

    Attributes:
        slope: g, shape (2, k).
        rate: A as rows 11, 12, 21, 22, shape (4, k).
        second: Second derivatives of g₁ by xx, xy, yy, then of g₂, shape (6, k).
        reach: Reach of the cells, shape (k,).
        twist: Bounds on how far the principal directions turn in the cells, seen from each, shape (2, k).
        remainder: Bound on what the expansion of g lacks, of third order in the reach, shape (k,).
        offset: Bound on an error of g that is the same all over the cell, shape (k,).
        tilt: Bound on an error of A that is the same all over the cell, shape (k,).
    """

    slope: Array
    rate: Array
    second: Array
    reach: Array
    twist: Array
    remainder: Array
    offset: Array
    tilt: Array

    @classmethod
    def of(
        cls, grid: SupportGrid, changes: Changes, jets: NDArray[np.float32], row: IntArray, cell: IntArray
    ) -> _Cells:
        """Expansions for pairs of variants and cells."""
        g1, g2, h11, h12, h22 = jets[row, :, cell].T.astype(float)
        used, places = np.unique(cell, return_inverse=True)
        second = (grid.second[used] @ changes.coordinates.T)[places, :, row].T.astype(float)
        reach, roundness = grid.reach_mm[cell], grid.curvature_rate[cell]
        k1, k2 = grid.curvature_per_mm[cell].T
        a12 = h12 / reach
        fourth = changes.fourth_mm[row] * k1**3 + 4.0 * changes.third_mm[row] * k1 * roundness
        half = 0.5 * (grid.upper[cell] == 0.5) * changes.shift_mm[row]
        return cls(
            slope=np.stack([g1, g2]),
            rate=np.stack([h11 / reach, a12 * k2 / k1, a12, h22 / reach]),
            second=second,
            reach=reach,
            twist=roundness * reach / np.stack([k1, k2]),
            remainder=grid.remainder_mm[cell] * (1.0 + changes.stretch[row]) + fourth * reach**3 / 6.0,
            offset=changes.slope_error_mm[row] + half + _ROUNDING * grid.height_mm,
            tilt=(changes.bend_error_mm[row] + half) * k1 + _ROUNDING,
        )

    def _bend(self) -> Array:
        """Bound on the error of A that the expansion gives, shape (k,)."""
        return 3.0 * self.remainder / self.reach + self.tilt

    def never(self) -> BoolArray:
        """Whether the height is a minimum nowhere in a cell, shape (k,).

        At a minimum `κ A = κ ∇²f κ` is positive, so its diagonal is: `A₁₁ + κ₁₂/κ₁₁ A₂₁ ≥ 0`, and alike for
        2.
        """
        a11, a12, a21, a22 = self.rate
        t = np.abs(self.second)
        span, bend = self.reach, self._bend()
        first = a11 + (t[0] + t[1]) * span + bend
        first += self.twist[0] * (np.abs(a21) + (t[3] + t[4]) * span + bend)
        second = a22 + (t[4] + t[5]) * span + bend
        second += self.twist[1] * (np.abs(a12) + (t[1] + t[2]) * span + bend)
        result: BoolArray = (first < 0.0) | (second < 0.0)
        return result

    def _sloping(self) -> BoolArray:
        """Whether one component of the slope vanishes nowhere in a cell, shape (k,)."""
        a11, a12, a21, a22 = self.rate
        t, r = np.abs(self.second), self.reach
        error = self.remainder + self.offset + self.tilt * r
        first = np.hypot(a11, a12) * r + (0.5 * t[0] + t[1] + 0.5 * t[2]) * r * r + error
        second = np.hypot(a21, a22) * r + (0.5 * t[3] + t[4] + 0.5 * t[5]) * r * r + error
        result: BoolArray = (np.abs(self.slope[0]) > first) | (np.abs(self.slope[1]) > second)
        return result

    def judged(self) -> tuple[BoolArray, BoolArray, Array]:
        """Which cells hold a rest, which cannot be decided, and where the rests are, shape (k, 2).

        On the line on which g₂ vanishes, `y = y₀ + βx + η` with η bounded, what is left of g₁ when g₂ is
        eliminated is `c₀ + c₁x + ½ q x²` but for an error.
        """
        (g1, g2), (a11, a12, a21, a22), r = self.slope, self.rate, self.reach
        t111, t112, t122, t211, t212, t222 = self.second
        with np.errstate(all="ignore"):
            y0 = -g2 / a22
            for _ in range(2):
                y0 = y0 - (g2 + a22 * y0 + 0.5 * t222 * y0 * y0) / (a22 + t222 * y0)
            b11, b12, b21, b22 = a11 + t112 * y0, a12 + t122 * y0, a21 + t212 * y0, a22 + t222 * y0
            beta, ratio = -b21 / b22, b12 / b22
            q2 = np.abs(t211 + 2.0 * t212 * beta + t222 * beta * beta)
            q = t111 + 2.0 * t112 * beta + t122 * beta * beta
            q -= ratio * (t211 + 2.0 * t212 * beta + t222 * beta * beta)
            mixed2 = np.abs(t212 + t222 * beta)
            mixed = np.abs(t112 + t122 * beta - ratio * (t212 + t222 * beta))
            stiff = np.abs(b22)
            whole = self.remainder + self.offset
            aside = 2.0 * (0.5 * q2 * r * r + whole) / stiff
            clear = mixed2 * r + np.abs(t222) * aside + self._bend() < 0.5 * stiff
            # In the cell g₂ has one zero for each x, and the expansion about it is no wide extrapolation.
            clear &= (np.abs(t212) + np.abs(t222)) * r + self._bend() < np.abs(a22)
            clear &= (b22 * a22 > 0.0) & (np.abs(y0) < _FARTHEST * r)
            across = mixed * r * aside + 0.5 * np.abs(t122 - ratio * t222) * aside * aside
            error = (self.remainder + self.offset) * (1.0 + np.abs(ratio)) + across
            c0 = g1 + a12 * y0 + 0.5 * t122 * y0 * y0
            c0 -= ratio * (g2 + a22 * y0 + 0.5 * t222 * y0 * y0)
            c1 = b11 + b12 * beta
            wavering = np.abs(q) * r + 2.0 * mixed * aside + self._bend() * (1.0 + np.abs(ratio)) ** 2
            x = -c0 / c1
            for _ in range(3):
                x = x - (c0 + c1 * x + 0.5 * q * x * x) / (c1 + q * x)
            away = np.abs(y0) - np.abs(beta) * r - aside > r
            steady = np.abs(c0) > np.abs(c1) * r + 0.5 * np.abs(q) * r * r + error
            rises = c1 > wavering
            outside = rises & (np.abs(x) > r + error / (c1 - wavering))
            no_minimum = (b22 < 0.0) | (c1 < -wavering)
        none = self.never() | self._sloping() | (clear & (away | steady | outside | no_minimum))
        rests = clear & rises & (b22 > 0.0) & ~none
        return rests, ~none & ~rests, np.stack([x, y0 + beta * x], axis=1)
