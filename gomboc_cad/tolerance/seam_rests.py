"""Rests on the edge of a displaced half.

The outer surface is parted by a plane, and the upper part is displaced by d against the lower one. In each
direction the body is as high as the higher of the two, `h = max(h_L, h_U + d·u)`. A half that is not touched
on its smooth surface is touched on its rim, where the height falls off on both sides, so the rim alone is no
rest. But where both halves touch the table, one on its smooth surface and the other one on its rim, they
carry the body together as soon as the foot of the perpendicular from the centre of mass (COM) falls between
the two points.

To second order the touching point of such a place is about `sqrt(2 ρ |d·u|)` from the seam, ρ the radius of
curvature across it; this tells for all variants at once where along the seam they may rest, and the places
are then found exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray, IntArray, unit
from gomboc_cad.tolerance.made_bodies import MadeBodies
from gomboc_cad.tolerance.screening import Changes
from gomboc_cad.tolerance.seam_line import RimPoints, SeamLine, scalar_products

_ROWS = 64
_SLACK = 0.15
"""How far outside of the two touching points the foot may be to be looked at, in their distance."""

_STEPS = 16
_REFRESHED = 2
"""Newton steps, and after how many of them the derivative is taken anew."""

_LONGEST_STEP = 0.1
_LEAST_STEP = 1e-3
"""Step, in units of R₀, that is allowed however near the touching point is to the seam."""

_NOISE = 1e-9
"""Change of the slope along the edge from one station to the next, in units of R₀, that is rounding."""

_CONVERGED = 1e-9
"""Residual of a rest on the seam, in units of R₀."""

_DOUBTFUL = 1e-4
"""Residual, in units of R₀, below which a place where the search did not end may still be a rest."""

_DIFFERENCE = 1e-5


class EdgeRests(NamedTuple):
    """Rests on which both halves touch the table.

    Attributes:
        row: Variant of each, shape (k,).
        direction: Normal that points down, shape (k, 3).
        height: Height of the COM, shape (k,).
        along: Stiffness along the edge, shape (k,); across it the height has a kink.
        undecided: Whether there may be others, for every variant, shape (n,).
    """

    row: IntArray
    direction: Array
    height: Array
    along: Array
    undecided: BoolArray


class Edge(NamedTuple):
    """Where both halves touch, to second order, for n variants at m stations, all (n, m).

    Attributes:
        below: How far the touching point of the lower half is above the foot of the COM, across the seam.
        above: The same for the upper half.
        along: Slope of the height along the edge.
        offset: Distance of the touching point on the smooth surface from the seam.
    """

    below: Array
    above: Array
    along: Array
    offset: Array


def edges(line: SeamLine, changes: Changes) -> Edge:
    """Where the halves of variants touch together; the number of variants is a multiple of 64."""
    flat = line.linear.reshape(len(line.linear), -1)
    count = len(changes.coordinates)
    jets = np.concatenate([changes.coordinates[i : i + _ROWS] @ flat for i in range(0, count, _ROWS)]).astype(
        float
    )
    g1, g2, _, h12, h22 = jets.reshape(count, 5, -1).transpose(1, 0, 2)
    shift = changes.upper_shift_mm
    frames = line.frames
    out, tau, nu = (
        scalar_products(shift, vectors) for vectors in (frames.normal, *frames.frame.transpose(1, 0, 2))
    )
    height = frames.height
    radius = h22 + height
    # The rim of the other half is lower by ½ ξ²/ρ and displaced by d, which is seen from a normal turned by
    # ξ/ρ.
    side = np.where(out > 0.0, -1.0, 1.0)
    offset = side * (np.sqrt(nu * nu + 2.0 * np.abs(radius * out)) - nu)
    turn = offset / radius
    slant = h12 * turn
    foot = height * turn - g2
    lower_smooth = offset < 0.0
    below = np.where(lower_smooth, offset, 0.0) - foot
    above = np.where(lower_smooth, 0.0, offset) + nu - foot
    distance = above - below
    share = np.clip(-below / np.where(distance > 0.0, distance, np.inf), 0.0, 1.0)
    lower, upper = np.where(lower_smooth, slant, 0.0), np.where(lower_smooth, 0.0, slant) + tau
    along = (1.0 - share) * lower + share * upper + g1
    return Edge(below, above, along, offset)


def edge_margins_mm(edge: Edge, clear: BoolArray) -> Array:
    """How far the COM of each variant is from a rest on the seam, but for places that are not clear, (n,).

    The foot of the COM has to come between the two touching points, at a place where the height is a minimum
    along the edge. Infinite where there is none.
    """
    outside = np.maximum(np.maximum(edge.below, -edge.above), 0.0)
    # The change from one station to the next.
    rise = 0.5 * (np.roll(edge.along, -1, axis=1) - np.roll(edge.along, 1, axis=1))
    along = np.maximum(np.abs(edge.along) - 0.5 * np.abs(rise), 0.0)
    possible = (edge.above > edge.below) & (rise > 0.0) & clear
    result: Array = np.where(possible, np.hypot(outside, along), np.inf).min(axis=1)
    return result


def edge_rests(line: SeamLine, bodies: MadeBodies, changes: Changes, edge: Edge) -> EdgeRests:
    """Rests of variants on the edges of their halves."""
    row, station = _candidates(edge, changes.shift_mm, _NOISE * bodies.body.radius_mm)
    start = (
        line.frames.position[station] + (edge.offset[row, station])[:, None] * line.frames.frame[station, 1]
    )
    offset = edge.offset[row, station]
    # At the seam itself both halves are equally high, so no step may lead there.
    longest = 0.4 * np.abs(offset) + _LEAST_STEP * bodies.body.radius_mm
    search = _EdgeSearch(line, bodies, row, offset > 0.0, longest)
    return search.run(unit(start), len(changes.shift_mm))


def rim_heights_mm(
    line: SeamLine, bodies: MadeBodies, row: IntArray, normals: Array, upper: BoolArray
) -> Array:
    """Height of the COM over a table that touches the rim of a half only, shape (k,).

    Args:
        line: The seam.
        bodies: The bodies as made.
        row: Variants, shape (k,).
        normals: Normals v of the part before it is stretched, shape (k, 3).
        upper: Whether the rim is that of the displaced half, shape (k,).
    """
    rim = RimPoints.farthest(line, bodies, row, normals, upper)
    result: Array = (rim.arm * rim.normal).sum(axis=0)
    return result


def _candidates(edge: Edge, shift_mm: Array, noise_mm: float) -> tuple[IntArray, IntArray]:
    """Variants and stations before which the slope along the edge may change from falling to rising."""
    slack = _SLACK * np.abs(edge.above - edge.below) + 0.1 * shift_mm[:, None]
    between = (edge.below < slack) & (edge.above > -slack) & (shift_mm[:, None] > 0.0)
    here, there = edge.along, np.roll(edge.along, -1, axis=1)
    rising = (here <= 0.0) & (there > 0.0) & (there - here > noise_mm)
    rising &= between | np.roll(between, -1, axis=1)
    row, station = np.nonzero(rising)
    nearer = np.abs(there[row, station]) < np.abs(here[row, station])
    return row, (station + nearer) % edge.along.shape[1]


@dataclass(eq=False)
class _EdgeSearch:
    """Newton's method for places at which both halves touch and the height is stationary along the edge."""

    line: SeamLine
    bodies: MadeBodies
    row: IntArray
    smooth_upper: BoolArray
    longest_mm: Array
    """Longest step across the seam."""

    def run(self, start: Array, count: int) -> EdgeRests:
        """Refine candidates; `count` is the number of variants."""
        unit_mm = self.bodies.body.radius_mm
        state = self._state(start, None)
        probe = _DIFFERENCE * unit_mm
        share = np.ones(len(self.row))
        for number in range(_STEPS):
            if number % _REFRESHED == 0:
                probed = [self._state(state.moved(axis, probe), state.rim_direction) for axis in (0, 1)]
                jacobian = np.stack([(other.residual - state.residual) / probe for other in probed])
            (j11, j21), (j12, j22) = jacobian
            r1, r2 = state.residual
            determinant = j11 * j22 - j12 * j21
            safe = np.where(determinant == 0.0, np.inf, determinant)
            step = np.stack([j12 * r2 - j22 * r1, j21 * r1 - j11 * r2]) / safe
            step *= share * self._shortened(state, step)
            trial = self._state(state.stepped(step), state.rim_direction)
            better = (trial.residual**2).sum(axis=0) < (state.residual**2).sum(axis=0)
            share = np.where(better, np.minimum(1.0, 2.0 * share), 0.25 * share)
            state = trial.where(better, state)
        bend = self._bend(state, probe)
        reached = np.abs(state.residual).max(axis=0) < _CONVERGED * unit_mm
        rest = reached & state.carried() & (bend > 0.0)
        undecided = np.zeros(count, dtype=bool)
        # Where the search got stuck far from a solution there is none.
        left = np.abs(state.residual).max(axis=0)
        undecided[self.row[~reached & (left < _DOUBTFUL * unit_mm)]] = True
        index = self._distinct(np.flatnonzero(rest), state)
        return EdgeRests(
            self.row[index],
            state.normal[:, index].T,
            state.height[index],
            bend[index],
            undecided,
        )

    def _shortened(self, state: _EdgeState, step: Array) -> Array:
        """Factors that keep steps on their side of the seam, and short, shape (k,)."""
        way = step[0] * state.tangents[0] + step[1] * state.tangents[1]
        across = np.abs(np.array(self.line.plane.normal) @ way)
        length = np.sqrt((way * way).sum(axis=0))
        longest = _LONGEST_STEP * self.bodies.body.radius_mm
        shares = self.longest_mm / np.maximum(across, 1e-300), longest / np.maximum(length, 1e-300)
        result: Array = np.minimum(1.0, np.minimum(*shares))
        return result

    def _bend(self, state: _EdgeState, probe: float) -> Array:
        """Second derivative of the height along the edge, per turn of the normal, shape (k,)."""
        first, second = (self._state(state.moved(axis, probe), state.rim_direction) for axis in (0, 1))
        edge = state.edge()
        # A step along which the excess stays the same, and how far the normal turns with it.
        one, two = second.excess - state.excess, state.excess - first.excess
        change = one * (first.residual[1] - state.residual[1]) + two * (
            second.residual[1] - state.residual[1]
        )
        turned = one * (first.normal - state.normal) + two * (second.normal - state.normal)
        turn = (turned * edge).sum(axis=0)
        result: Array = change / np.where(turn == 0.0, np.inf, turn)
        return result

    def _distinct(self, index: IntArray, state: _EdgeState) -> IntArray:
        kept: list[int] = []
        for i in index.tolist():
            twins = [j for j in kept if self.row[j] == self.row[i]]
            if all(np.abs(state.normal[:, j] - state.normal[:, i]).max() > 1e-6 for j in twins):
                kept.append(i)
        return np.array(kept, dtype=np.int64)

    def _state(self, direction: Array, rim_direction: Array | None) -> _EdgeState:
        slopes = self.bodies.slopes(self.row, direction, self.smooth_upper)
        v = self.bodies.body.normal(direction)
        rim = RimPoints.farthest(self.line, self.bodies, self.row, v, ~self.smooth_upper, rim_direction)
        height = (rim.arm * rim.normal).sum(axis=0)
        return _EdgeState(
            place=slopes.place,
            tangents=slopes.tangents,
            rim_direction=rim.direction,
            normal=rim.normal,
            height=slopes.height,
            excess=height - slopes.height,
            smooth=slopes.slope[0] * slopes.frame[0] + slopes.slope[1] * slopes.frame[1],
            rim=rim.arm - height * rim.normal,
        )


@dataclass(frozen=True, eq=False)
class _EdgeState:
    """Directions in which the smooth surface of one half touches, against the rim of the other one.

    Attributes:
        place: Nominal surface point, shape (3, k).
        tangents: Its tangent frame, shape (2, 3, k).
        rim_direction: Surface parameter w of the point of the rim, shape (k, 3).
        normal: Normal as made, shape (3, k).
        height: Height of the COM on the smooth surface, shape (k,).
        excess: How much higher the rim is, shape (k,).
        smooth: Slope of the height on the smooth surface, shape (3, k).
        rim: Slope of the height on the rim, shape (3, k).
    """

    place: Array
    tangents: Array
    rim_direction: Array
    normal: Array
    height: Array
    excess: Array
    smooth: Array
    rim: Array

    def where(self, chosen: BoolArray, other: _EdgeState) -> _EdgeState:
        """These where chosen, else others."""
        mixed = {
            name: np.where(
                chosen[:, None] if name == "rim_direction" else chosen, value, getattr(other, name)
            )
            for name, value in vars(self).items()
        }
        return _EdgeState(**mixed)

    @property
    def residual(self) -> Array:
        """What has to vanish: the excess, and the slope along the edge, shape (2, k)."""
        return np.stack([self.excess, (self.smooth * self.edge()).sum(axis=0)])

    def edge(self) -> Array:
        """Unit direction of the edge among the normals, shape (3, k)."""
        kink = self.rim - self.smooth
        edge = np.cross(self.normal, kink, axis=0)
        result: Array = edge / np.maximum(np.sqrt((edge * edge).sum(axis=0)), 1e-300)
        return result

    def carried(self) -> BoolArray:
        """Whether the foot of the COM is between the two points."""
        kink = self.rim - self.smooth
        share = -(self.smooth * kink).sum(axis=0) / np.maximum((kink * kink).sum(axis=0), 1e-300)
        result: BoolArray = (share > 0.0) & (share < 1.0)
        return result

    def moved(self, axis: int, length: float) -> Array:
        """Directions w after a step along one tangent vector."""
        step = np.zeros((2, self.place.shape[1]))
        step[axis] = length
        return self.stepped(step)

    def stepped(self, step: Array) -> Array:
        """Directions w after steps (2, k) along the nominal surface."""
        target = (self.place + step[0] * self.tangents[0] + step[1] * self.tangents[1]).T
        return unit(target)
