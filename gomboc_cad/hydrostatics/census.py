"""The floating census: every orientation in which a part floats in equilibrium, and which are stable.

The energy is computed exactly on a geodesic triangulation, and Newton's method on the exact energy finds
the poses from there. Where they satisfy S − H + U = 2 (Poincaré–Hopf) their barriers are exact, too;
otherwise the 0-dimensional persistence of the samples tells basins from what the sampling makes up. The
facets of a mesh make poses of their own, as on a table; barriers below the sag do not count.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from gomboc_cad.body.sphere import Array, BoolArray, IntArray, lengths
from gomboc_cad.equilibria.extent import Relief
from gomboc_cad.equilibria.hull import convex_polyhedron
from gomboc_cad.equilibria.persistence import MergeTree, merge_tree
from gomboc_cad.equilibria.records import CensusVerdict, Extent, Kind, as_vector
from gomboc_cad.equilibria.resolution import edge_sags_mm
from gomboc_cad.errors import GeometryError
from gomboc_cad.hydrostatics.landscape import (
    FloatingLandscape,
    Samples,
    kinds,
    refine,
    sample,
)
from gomboc_cad.hydrostatics.records import (
    FloatingCensus,
    FloatingEvidence,
    FloatingPose,
    FloatingState,
    energy_mj,
)
from gomboc_cad.hydrostatics.skeleton import CriticalPoints, critical_points, pose_tree
from gomboc_cad.hydrostatics.state import floating_landscape, state_at
from gomboc_cad.hydrostatics.water import SEA_WATER, Water

DEFAULT_LEVEL = 5
_LEVELS = range(2, 8)

_KINDS: tuple[Kind, Kind] = ("stable", "unstable")

_SOFT = 0.05
"""Along a ring the stiffness is at most this share of that across it."""

_ROUNDING = 1e-9
"""Barriers that are lower, in units of the size of the part, are not told from rounding."""

_COARSEST = 0.06
"""A barrier that is a larger part of the energy range can hide a second pose of any consequence."""


def floating_census(
    vertices: Array,
    faces: IntArray,
    mass_g: float,
    com_mm: Sequence[float] | Array,
    water: Water = SEA_WATER,
    *,
    level: int = DEFAULT_LEVEL,
    barrier_mm: float | None = None,
    sag_mm: float | None = None,
) -> FloatingCensus:
    """Count and describe the floating equilibria of a part in water at rest.

    Args:
        vertices: Corners of the outer surface in mm, shape (n, 3).
        faces: Indices of the corners of each triangle, counter-clockwise from outside, shape (m, 3).
        mass_g: Mass of the part with all that it carries.
        com_mm: Its centre of mass, shape (3,).
        water: What it floats in.
        level: Subdivisions of the icosahedron: 10·4^level + 2 orientations.
        barrier_mm: Poses with a lower barrier do not count; by default the sag and, where Newton's method
            does not find all poses, twice the resolution of the sampling.
        sag_mm: Largest distance between the mesh and the surface that it stands for; by default estimated
            from the hull of the mesh. Zero for a part that really has these facets.

    Raises:
        GeometryError: If the surface is not closed and oriented outwards, the part is too heavy to
            float or has no positive mass, the COM is not finite, or an option is out of range.
    """
    if level not in _LEVELS:
        raise GeometryError(
            f"The level must be a whole number from {_LEVELS[0]} to {_LEVELS[-1]}, not {level!r}."
        )
    for name, value in (("barrier", barrier_mm), ("sag", sag_mm)):
        if value is not None and not 0.0 <= value < np.inf:
            raise GeometryError(f"The {name} must be a length of zero or more, not {value!r}.")
    landscape = floating_landscape(vertices, faces, mass_g, com_mm, water)
    if sag_mm is None:
        sag_mm = float(edge_sags_mm(convex_polyhedron(landscape.surface.corners_mm)).max())
    search = _Search(landscape, sample(landscape, level), sag_mm, barrier_mm)
    return _census(_Floating(landscape, mass_g, water), search)


class _Floating(NamedTuple):
    """What floats, and in what."""

    landscape: FloatingLandscape
    mass_g: float
    water: Water

    def state(self, up: Array) -> FloatingState:
        return state_at(self.landscape, up, self.mass_g, self.water)


def _census(floating: _Floating, search: _Search) -> FloatingCensus:
    points = search.points
    sides = search.sides()
    low, high = sides[0], sides[-1]
    energy_range = search.range_mm if high is low else float(high.heights_mm.max() - low.heights_mm.min())
    poses = [pose for side in sides for pose in _poses(side, floating, energy_range)]
    if any(extent != "point" for side in sides for extent in side.extents):
        points = None  # along a ring, what Newton finds is made by the facets
    else:
        everything = points is not None and all(len(side.ups) == len(points.of(side.kind)) for side in sides)
        # Trees of equally high passes may both choose the same one.
        saddles = points.saddle if points is not None and everything else _joined(sides)
        poses += [FloatingPose("saddle", floating.state(up)) for up in saddles]
    poses.sort(key=lambda pose: pose.state.com_over_buoyancy_mm)
    evidence = FloatingEvidence(
        orientations=search.orientations,
        spacing_deg=float(np.degrees(search.spacing)),
        resolution_mm=search.resolution_mm,
        sag_mm=search.sag_mm,
        barrier_mm=search.barrier_mm,
        highest_uncounted_mm=low.highest_uncounted_mm,
        exact_stable=len(points.stable) if points else None,
        exact_saddles=len(points.saddle) if points else None,
        exact_unstable=len(points.unstable) if points else None,
    )
    verdict, reason = _judge(low.extents, evidence, energy_range)
    surface = floating.landscape.surface
    return FloatingCensus(
        water=floating.water,
        mass_g=floating.mass_g,
        com_mm=as_vector(floating.landscape.com_mm + surface.pivot_mm),
        poses=tuple(poses),
        energy_range_mm=energy_range,
        verdict=verdict,
        reason=reason,
        evidence=evidence,
    )


def _joined(sides: Sequence[_Side]) -> Array:
    return np.concatenate([side.passes for side in sides])


class _Grid(NamedTuple):
    """Edges (m, 2) of the triangulation and the triangles (m, 2) on both sides of each."""

    edges: IntArray
    cells: IntArray

    @classmethod
    def of(cls, triangles: IntArray) -> _Grid:
        edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        order = np.lexsort((edges[:, 1], edges[:, 0]))
        return cls(edges[order[::2]], np.stack([order[::2], order[1::2]], axis=1) // 3)


class _Side(NamedTuple):
    """Minima of the energy, or maxima, that count.

    Attributes:
        kind: Kind of the poses.
        ups: Directions of the poses, the deepest first, shape (p, 3).
        heights_mm: Their energies, shape (p,).
        barriers_mm: Rises to the passes into other ones, infinite if there is no other, shape (p,).
        extents: Whether each is a point, a ring or a sphere.
        passes: Directions of the passes between them, shape (p - 1, 3).
        highest_uncounted_mm: Highest barrier of those that do not count, None if all do.
    """

    kind: Kind
    ups: Array
    heights_mm: Array
    barriers_mm: Array
    extents: list[Extent]
    passes: Array
    highest_uncounted_mm: float | None


class _Search:
    """One census; energies are per weight, in mm."""

    def __init__(
        self,
        landscape: FloatingLandscape,
        samples: Samples,
        sag_mm: float,
        barrier_mm: float | None,
    ) -> None:
        self._landscape, self._samples = landscape, samples
        self.sag_mm = sag_mm
        self.orientations = len(samples.ups)
        self.range_mm = float(np.ptp(samples.jet.height_mm))
        self._grid = _Grid.of(samples.triangles)
        ends = samples.ups[self._grid.edges]
        self.spacing = 2.0 * float(np.arcsin(0.5 * lengths(ends[:, 0] - ends[:, 1]).max()))
        # Linear interpolation on a triangle of circumradius r is good to |∇²E| r²/2.
        steepest = float(np.abs(np.linalg.eigvalsh(samples.jet.hessian_mm)).max())
        self.resolution_mm = steepest * self.spacing**2 / 6.0
        # Both a bottom and a pass may be off by the resolution.
        self._sampled_barrier = 2.0 * self.resolution_mm + sag_mm
        self.points: CriticalPoints | None = None
        self._trees: dict[Kind, MergeTree] = {}
        self._neutral = self.range_mm <= self._sampled_barrier
        if not self._neutral:
            self.points = critical_points(landscape, samples, self.spacing)
        if self.points is not None and self.points.complete:
            trees = {kind: pose_tree(landscape, self.points, kind) for kind in _KINDS}
            known = {kind: tree for kind, tree in trees.items() if tree is not None}
            self._trees = known if len(known) == len(_KINDS) else {}
        rounding = _ROUNDING * landscape.surface.size_mm
        default = max(sag_mm, rounding) if self._trees else self._sampled_barrier
        self.barrier_mm = default if barrier_mm is None else barrier_mm
        if self._neutral:
            self.barrier_mm = max(self.barrier_mm, self._sampled_barrier)

    def sides(self) -> list[_Side]:
        """The stable poses, and the unstable ones unless the part floats neutrally in every pose."""
        if self._neutral:
            lowest = np.array([np.argmin(self._samples.jet.height_mm)])
            ups, heights = self._samples.ups[lowest], self._samples.jet.height_mm[lowest]
            return [_Side("stable", ups, heights, np.full(1, np.inf), ["sphere"], np.empty((0, 3)), None)]
        if self.points is not None and self._trees:
            return [self._exact_side(kind, tree, self.points) for kind, tree in self._trees.items()]
        return [self._sampled_side(kind) for kind in _KINDS]

    def _exact_side(self, kind: Kind, tree: MergeTree, points: CriticalPoints) -> _Side:
        counted = tree.counted(self.barrier_mm)
        chosen = points.of(kind)[tree.bottom[counted]]
        heights = self._landscape.jet(points.of(kind)).height_mm
        climbs = tree.climb(heights if kind == "stable" else -heights, counted)[counted]
        extents: list[Extent] = ["point"] * len(chosen)
        if not counted.all():
            nearest = np.asarray(cKDTree(self._samples.ups).query(chosen)[1], dtype=np.int64)
            extents = self._extents(kind, nearest)
        passes = points.saddle[tree.pass_edge[counted & (tree.pass_edge >= 0)]]
        return _Side(
            kind, chosen, heights[tree.bottom[counted]], climbs, extents, passes, _highest(tree, counted)
        )

    def _extents(self, kind: Kind, nodes: IntArray) -> list[Extent]:
        heights = self._samples.jet.height_mm * (1.0 if kind == "stable" else -1.0)
        edges, cells = self._grid
        tops = heights[self._samples.triangles].max(axis=1)
        relief = Relief(heights, tops, heights[edges].max(axis=1), edges, cells)
        return [relief.extent(node, max(self.barrier_mm, self._sampled_barrier)) for node in nodes.tolist()]

    def _sampled_side(self, kind: Kind) -> _Side:
        sign = -1.0 if kind == "unstable" else 1.0
        heights = sign * self._samples.jet.height_mm
        edges = self._grid.edges
        tree = merge_tree(heights, edges, heights[edges].max(axis=1), _downhill(heights, edges))
        counted = tree.counted(self.barrier_mm)
        bottoms = tree.bottom[counted]
        extents = self._extents(kind, bottoms)
        neutral = any(extent != "point" for extent in extents)
        ups, exact = self._settle(bottoms, kind, neutral)
        pass_edges = tree.pass_edge[counted & (tree.pass_edge >= 0)]
        over = edges[pass_edges]
        over = over[np.arange(len(over)), np.argmax(heights[over], axis=1)]
        passes, pass_heights = self._settle(over, "saddle", neutral)
        climbs = tree.climb(heights, counted)[counted]
        barriers = np.full(len(climbs), np.inf)
        if len(over):
            # Every climb ends at one of the passes; Newton says how high that is.
            sampled = heights[bottoms] + climbs
            match = np.argmin(np.abs(heights[over] - sampled[:, None]), axis=1)
            barriers = sign * (pass_heights[match] - exact)
        return _Side(kind, ups, exact, barriers, extents, passes, _highest(tree, counted))

    def _settle(self, nodes: IntArray, kind: Kind, neutral: bool) -> tuple[Array, Array]:
        """Refine samples to poses of a kind; where Newton finds none nearby, the sample stays.

        Returns:
            Directions, shape (k, 3), and energies, shape (k,).
        """
        starts = self._samples.ups[nodes]
        heights = self._samples.jet.height_mm[nodes].copy()
        if not len(nodes):
            return starts, heights
        ups, settled = refine(self._landscape, starts, self.spacing, _SOFT if neutral else 0.0)
        jet = self._landscape.jet(ups)
        settled &= np.abs(jet.height_mm - heights) <= 2.0 * self.resolution_mm
        if not neutral:
            settled &= np.array(kinds(jet)) == kind
        heights[settled] = jet.height_mm[settled]
        return np.where(settled[:, None], ups, starts), heights


def _highest(tree: MergeTree, counted: BoolArray) -> float | None:
    """Highest barrier of the basins that do not count."""
    others = tree.persistence[~counted]
    return float(others.max()) if len(others) else None


def _downhill(heights: Array, edges: IntArray) -> IntArray:
    """The lowest neighbour of each node that lies below it; itself if there is none."""
    start, end = np.concatenate([edges, edges[:, ::-1]]).T
    falls = heights[end] < heights[start]
    start, end = start[falls], end[falls]
    order = np.argsort(-heights[end], kind="stable")
    result = np.arange(len(heights))
    result[start[order]] = end[order]  # the last one written, the lowest neighbour, stays
    return result


def _poses(side: _Side, floating: _Floating, energy_range: float) -> list[FloatingPose]:
    poses = []
    for up, barrier, extent in zip(side.ups, side.barriers_mm.tolist(), side.extents, strict=True):
        rise = min(barrier, energy_range)
        poses.append(
            FloatingPose(side.kind, floating.state(up), rise, energy_mj(floating.mass_g, rise), extent)
        )
    return poses


def _judge(
    extents: list[Extent], evidence: FloatingEvidence, energy_range: float
) -> tuple[CensusVerdict, str]:
    """Say what barriers and counts prove."""
    barrier = f"{evidence.barrier_mm:.4g} mm"
    finer = "a higher level, which is a finer sampling, would decide it."
    if len(extents) > 1:
        return "multistable", f"{len(extents)} stable floating poses have barriers above {barrier}."
    if extents[0] != "point":
        where = "in a whole ring of poses" if extents[0] == "ring" else "in every pose"
        return "undecided", f"The part floats neutrally {where}, up to a barrier of {barrier}."
    if evidence.complete:
        if evidence.exact_stable == 1:
            return "monostable", "There is one stable floating pose, and Newton's method finds no other."
        return "monostable", f"There is one stable floating pose for every barrier above {barrier}."
    if evidence.barrier_mm > _COARSEST * energy_range:
        return "undecided", (
            f"Poses with barriers up to {barrier} may be hidden where the energy varies by "
            f"{energy_range:.4g} mm in all; {finer}"
        )
    return "monostable", f"There is one stable floating pose for every barrier above {barrier}."
