"""How deep a part floats, for many orientations at once: exact clipping and safe Newton for the heave.

The part of a polyhedron below a plane is integrated by the divergence theorem: tetrahedra from the pivot
to the wetted facets and to the waterplane. A facet that the plane cuts has one corner alone on its side,
and the small triangle there has the share `s r` of the facet, s and r being the places of the cuts on the
two edges. The displaced volume rises with the waterplane at the rate of the waterplane area, so
a bracketed Newton iteration finds the level of heave equilibrium. Where the level is known roughly, only
the facets that reach into a slab around it take part in the iteration.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray, IntArray, tangent_frame
from gomboc_cad.hydrostatics.surface import WettedSurface

_VOLUME_TOLERANCE = 1e-9
"""Of the displaced volume; what is left is corrected in closed form and enters the energy squared."""

_ROUNDING = 1e-13
"""Of the whole volume: what its sum over the facets is good for."""

_SLAB = 0.01
"""Half thickness of the slab around a guessed level, in units of the size of the part."""

_MAX_STEPS = 200
_CHUNK_PAIRS = 2**19
_MAX_CHUNK = 2048


class Immersion(NamedTuple):
    """Heave equilibria for k orientations; points are relative to the pivot of the surface.

    Attributes:
        level_mm: Height of the waterplane over the pivot, shape (k,).
        buoyancy_mm: Centres of buoyancy, shape (k, 3).
        area_mm2: Areas of the waterplane, shape (k,).
        flotation_mm: Centroids of the waterplane, shape (k, 3).
        frame: Axes of the waterplane, shape (k, 2, 3).
        second_mm4: Second moments `∫ x xᵀ` of the waterplane about its centroid in these axes, (k, 2, 2).
    """

    level_mm: Array
    buoyancy_mm: Array
    area_mm2: Array
    flotation_mm: Array
    frame: Array
    second_mm4: Array


def immerse(
    surface: WettedSurface, ups: Array, volume_mm3: float, guess_mm: Array | None = None
) -> Immersion:
    """Let the part float with a displaced volume in each orientation.

    Args:
        surface: The outer surface.
        ups: Unit directions of the body that point up, shape (k, 3).
        volume_mm3: Displaced volume, between 0 and that of the part.
        guess_mm: Levels of the waterplane to start from, NaN where unknown, shape (k,).
    """
    guess = np.full(len(ups), np.nan) if guess_mm is None else guess_mm
    width = min(_MAX_CHUNK, max(1, _CHUNK_PAIRS // len(surface.faces)))
    chunks = [slice(i, i + width) for i in range(0, len(ups), width)]
    parts = [_immerse(surface, ups[chunk], volume_mm3, guess[chunk]) for chunk in chunks]
    return Immersion(*(np.concatenate(field) for field in zip(*parts, strict=True)))


def _immerse(surface: WettedSurface, ups: Array, volume: float, guess: Array) -> Immersion:
    heights = surface.corners_mm @ ups.T
    low, high = heights.min(axis=0), heights.max(axis=0)
    known = (guess > low) & (guess < high)
    level = np.where(known, guess, low + (high - low) * (volume / surface.volume_mm3))
    reach = np.where(known, _SLAB * surface.size_mm, np.inf)
    bottom, top = np.maximum(low, level - reach), np.minimum(high, level + reach)
    band = _band(surface, ups, heights, bottom, top)
    level, found = _heave(surface, band, level, bottom, top, volume)
    if not found.all():
        # The guess was not good enough: without one, the level is always found.
        return _immerse(surface, ups, volume, np.where(found, level, np.nan))
    return _integrate(surface, ups, band, level, volume)


class _Band(NamedTuple):
    """Facets that reach into the slabs, b in all, and integrals of those that lie below them.

    Attributes:
        column: Orientation of each, shape (b,).
        face: Facet, shape (b,).
        heights: Of its corners over the pivot, shape (b, 3).
        projected: Area of the facet seen from above, negative from below, shape (b,).
        below: Volumes and first moments, summed over the facets below the slab, shape (k, 4).
        below_area: Sums of their areas seen from above, shape (k,).
    """

    column: IntArray
    face: IntArray
    heights: Array
    projected: Array
    below: Array
    below_area: Array

    def of(self, columns: BoolArray) -> _Band:
        """The same with the facets of some orientations only."""
        kept = columns[self.column]
        return self._replace(
            column=self.column[kept],
            face=self.face[kept],
            heights=self.heights[kept],
            projected=self.projected[kept],
        )


def _band(surface: WettedSurface, ups: Array, heights: Array, bottom: Array, top: Array) -> _Band:
    side = (heights < bottom).view(np.int8) - (heights > top).view(np.int8)
    a, b, c = surface.faces.T
    where = side[a]
    where += side[b]
    where += side[c]
    face, column = np.divmod(np.flatnonzero(np.abs(where) < 3), len(ups))
    below = (surface.integrals.T @ (where == 3).astype(float)).T
    projected = np.einsum("bx,bx->b", surface.integrals[face, 4:], ups[column])
    below_area = np.einsum("kx,kx->k", below[:, 4:], ups)
    corner_heights = heights[surface.faces[face], column[:, None]]
    return _Band(column, face, corner_heights, projected, below[:, :4], below_area)


class _Cuts(NamedTuple):
    """Facets of a band at given levels.

    Attributes:
        wet: Share of each facet of the band that is below the water, shape (b,).
        facet: Those that are cut, shape (c,).
        lead: Which of their corners is alone on its side, shape (c,).
        lone_below: Whether that one is below the water, shape (c,).
        share: Places of the cuts on the edges from it to the other two, shape (2, c).
    """

    wet: Array
    facet: IntArray
    lead: IntArray
    lone_below: BoolArray
    share: Array


def _cut(heights: Array, level: Array) -> _Cuts:
    """Cut facets with corner heights (b, 3) at levels (b,)."""
    below = heights < level[:, None]
    count = below.sum(axis=1)
    wet = (count == 3).astype(float)
    index = np.flatnonzero((count == 1) | (count == 2))
    lone_below = count[index] == 1
    lead = np.argmax(below[index] == lone_below[:, None], axis=1)
    lone, right, left = (heights[index, (lead + k) % 3] for k in range(3))
    share = (level[index] - lone) / np.stack([right - lone, left - lone])
    small = share[0] * share[1]
    wet[index] = np.where(lone_below, small, 1.0 - small)
    return _Cuts(wet, index, lead, lone_below, share)


def _heave(
    surface: WettedSurface, band: _Band, start: Array, bottom: Array, top: Array, volume: float
) -> tuple[Array, BoolArray]:
    """Levels (k,) at which the displaced volume is the given one, and whether they were found."""
    level, low, high = start.copy(), bottom.copy(), top.copy()
    tolerance = _VOLUME_TOLERANCE * volume + _ROUNDING * surface.volume_mm3
    found = np.zeros(len(level), dtype=bool)
    searching = ~found
    count = len(level)
    for _ in range(_MAX_STEPS):
        band = band.of(searching)
        wet = _cut(band.heights, level[band.column]).wet
        tetrahedra = surface.integrals[band.face, 0]
        area = -band.below_area - np.bincount(band.column, band.projected * wet, count)
        excess = band.below[:, 0] + np.bincount(band.column, tetrahedra * wet, count) - volume
        excess += level * area / 3.0
        found |= searching & (np.abs(excess) <= tolerance)
        high = np.where(searching & (excess > 0.0), level, high)
        low = np.where(searching & (excess <= 0.0), level, low)
        searching &= ~found & (high - low > 4.0 * np.spacing(np.abs(high) + np.abs(low)))
        if not searching.any():
            break
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = level - excess / area
        inside = (newton > low) & (newton < high)
        level = np.where(searching, np.where(inside, newton, 0.5 * (low + high)), level)
    # With all facets in the band, a closed bracket is as good as rounding allows.
    at_end = (level - bottom <= tolerance / surface.size_mm**2) | (
        top - level <= tolerance / surface.size_mm**2
    )
    return level, found | ~at_end


def _integrate(surface: WettedSurface, ups: Array, band: _Band, level: Array, volume: float) -> Immersion:
    count = len(ups)
    cuts = _cut(band.heights, level[band.column])
    column, face = band.column[cuts.facet], band.face[cuts.facet]
    corners = [surface.corners_mm[surface.faces[face, (cuts.lead + k) % 3]] for k in range(3)]
    on_right, on_left = (
        corners[0] + s[:, None] * (end - corners[0]) for s, end in zip(cuts.share, corners[1:], strict=True)
    )
    frame = np.stack(tangent_frame(ups), axis=1)
    area, first, second = _plane_moments(on_left, on_right, cuts.lone_below, frame[column], column, count)
    wet = surface.integrals[band.face, :4] * cuts.wet[:, None]
    small = surface.integrals[face, 0] * cuts.share[0] * cuts.share[1]
    triangle = small[:, None] * (corners[0] + on_right + on_left) / 4.0
    whole = surface.integrals[face, 1:4]
    wet[cuts.facet, 1:] = np.where(cuts.lone_below[:, None], triangle, whole - triangle)
    submerged = band.below + np.stack([np.bincount(band.column, part, count) for part in wet.T], axis=1)
    safe_area = np.where(area > 0.0, area, np.inf)
    center = first / safe_area[:, None]
    flotation = level[:, None] * ups + np.einsum("ka,kax->kx", center, frame)
    # The waterplane is the base of a cone with its tip at the pivot.
    lid = level * area / 3.0
    first_moment = submerged[:, 1:] + 0.75 * lid[:, None] * flotation
    # The last Newton step in closed form: a slab of the excess volume at the waterplane goes.
    excess = submerged[:, 0] + lid - volume
    return Immersion(
        level_mm=level - excess / safe_area,
        buoyancy_mm=(first_moment - excess[:, None] * flotation) / volume,
        area_mm2=area,
        flotation_mm=flotation,
        frame=frame,
        second_mm4=second - area[:, None, None] * center[:, :, None] * center[:, None, :],
    )


def _plane_moments(
    on_left: Array, on_right: Array, swap: BoolArray, frame: Array, column: IntArray, count: int
) -> tuple[Array, Array, Array]:
    """Area (k,), first (k, 2) and second moments (k, 2, 2) of the waterplane by Green's theorem.

    Seen from above, each cut runs counter-clockwise from its right end to its left one, or back if
    swapped.
    """
    ends = np.stack([on_right, on_left])
    x, y = (np.einsum("ecx,cx->ec", ends, frame[:, axis]) for axis in range(2))
    twice = np.where(swap, -1.0, 1.0) * (x[0] * y[1] - x[1] * y[0])

    def total(weights: Array) -> Array:
        result: Array = np.bincount(column, twice * weights, count).astype(float)
        return result

    def product(p: Array, q: Array) -> Array:
        return total((p[0] + p[1]) * (q[0] + q[1]) + p[0] * q[0] + p[1] * q[1]) / 24.0

    area = 0.5 * total(np.ones_like(twice))
    first = np.stack([total(x.sum(axis=0)), total(y.sum(axis=0))], axis=1) / 6.0
    xy = product(x, y)
    second = np.stack([product(x, x), xy, xy, product(y, y)], axis=1).reshape(-1, 2, 2)
    return area, first, second


def waterline_edges(surface: WettedSurface, up: Array, level_mm: float) -> IntArray:
    """Edges of the surface between which each segment of a waterline runs, counter-clockwise from above.

    Args:
        surface: The outer surface.
        up: Unit direction that points up, shape (3,).
        level_mm: Height of the waterplane over the pivot.

    Returns:
        Pairs of corners in rising order, for the starts and the ends, shape (2, c, 2).
    """
    heights = (surface.corners_mm @ up)[surface.faces]
    cuts = _cut(heights, np.full(len(heights), level_mm))
    lone, right, left = (surface.faces[cuts.facet, (cuts.lead + k) % 3] for k in range(3))
    sides = np.stack([np.stack([lone, right], axis=1), np.stack([lone, left], axis=1)])
    sides.sort(axis=2)
    result: IntArray = np.where(cuts.lone_below[None, :, None], sides[::-1], sides)
    return result
