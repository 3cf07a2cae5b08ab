"""The source paper's equilibrium count by drainage basins, kept to reproduce its tables and for nothing else.

The oracle (arXiv 2604.17095 v1, section "Oracle Implementation") evaluates the height of the COM at 5,000
directions of a Fibonacci spiral, lets each direction drain to the lowest of its 12 nearest neighbours until
nothing is lower, and merges basins whose *sinks* differ by less than a hundredth of the range of heights. The
number of merged basins is its Equilibrium Count Score, ECS.

No verdict of this package rests on it, for three reasons.

* It compares the depths of two rests and never looks at the barrier between them. Two equally deep rests are
  made one however high the ridge is: an ellipsoid, which has two, reads 1, and a cube, which has six, 3.
  Bodies of the Sloan families are symmetric under a half-turn, so their rests come in pairs of one height.
* On a shallow landscape it counts what sampling and facets make: a sphere reads some dozens, and one ring
  more in the mesh decides whether the primary of the catalogue reads 1 or 2.
* The count changes when the same directions are turned against the body. A number of equilibria cannot.

`smooth_census` and `mesh_census` have none of these faults. The text of the paper leaves several choices
open; each is a named option here, and `DrainageOptions.paper` is the set that comes nearest to its tables.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple, Self

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from gomboc_cad.body.mass import mesh_mass
from gomboc_cad.body.sphere import Array, BoolArray, IntArray, cross, lengths
from gomboc_cad.equilibria.convexity import as_point
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import CensusError

_BLOCK = 1 << 17
"""Vertices times directions that are multiplied at once: the products stay in the cache, and are too few for
the threads of a BLAS, which only wait for each other here."""

Axis = Literal["x", "y", "z"]
Centre = Literal["volume", "surface", "vertices"]
Descent = Literal["lowest", "steepest"]
Linkage = Literal["lowest", "single"]
Share = Literal["largest", "deepest"]
Steepness = Literal["secant", "gradient"]


@dataclass(frozen=True)
class DrainageOptions:
    """What the paper fixes, and a name for each choice that it leaves open.

    Attributes:
        directions: Number N of sampled directions.
        neighbours: Number k of nearest neighbours of a direction, not counting itself.
        merge_fraction: Threshold τ: sinks that differ by less than this part of the range of heights merge.
        spiral_axis: Axis of the spiral: where its two ends lie on the body.
        spiral_offset: Offset o in `z_i = 1 − 2 (i + o)/(N − 1 + 2 o)`, `φ_i = π (1 + √5) (i + o)`. One half
            puts every direction in the middle of a zone of equal area; zero puts the first and the last
            on the axis.
        centre: Centroid that stands for the COM where none is given: of the homogeneous solid, of its
            surface, or of the vertices.
        descent: Whether water runs to the lowest neighbour or down the steepest slope.
        adjacent_only: Whether basins must touch to be merged, as the paper's text has it. Its tables come
            nearest without.
        linkage: Order of merging. `lowest`: sinks are taken from the lowest up, and each joins the first
            cluster whose lowest sink is within τ. `single`: any two sinks within τ are in one cluster, and so
            on along a chain, in whatever order.
        share: Whose share of the directions the basin of attraction (BOA) is: that of the largest
            cluster or that of the deepest.
        steepness: `secant`: mean of (h − h_min) over the angle from the deepest sink. `gradient`: mean of
            |Δh| over the angle between neighbours.
    """

    directions: int = 5000
    neighbours: int = 12
    merge_fraction: float = 0.01
    spiral_axis: Axis = "z"
    spiral_offset: float = 0.5
    centre: Centre = "volume"
    descent: Descent = "lowest"
    adjacent_only: bool = False
    linkage: Linkage = "lowest"
    share: Share = "largest"
    steepness: Steepness = "secant"

    def __post_init__(self) -> None:
        """Raise CensusError if a number is out of range."""
        if not 1 <= self.neighbours < self.directions:
            raise CensusError(
                f"The drainage count needs at least one neighbour and more directions than neighbours, not "
                f"{self.neighbours} of {self.directions}."
            )
        if not 0.0 <= self.merge_fraction <= 1.0:
            raise CensusError(
                "The merge fraction must be between 0 and 1, such as 0.01 for one percent, not "
                f"{self.merge_fraction!r}."
            )
        if not 0.0 <= self.spiral_offset <= 1.0:
            raise CensusError(f"The spiral offset must be between 0 and 1, not {self.spiral_offset!r}.")

    @classmethod
    def paper(cls) -> Self:
        """The choices that come nearest to the tables of arXiv 2604.17095 v1; they are the defaults."""
        return cls()


def spiral_directions(count: int, offset: float = 0.5, axis: Axis = "z") -> Array:
    """Directions of the Fibonacci spiral that `DrainageOptions` describes, shape (count, 3).

    Source of the offset: Roberts, "How to evenly distribute points on a sphere more effectively than the
    canonical Fibonacci lattice" (2020).
    """
    index = np.arange(count) + offset
    z = 1.0 - 2.0 * index / (count - 1 + 2.0 * offset)
    azimuth = np.pi * (1.0 + np.sqrt(5.0)) * index
    radius = np.sqrt(np.maximum(0.0, 1.0 - z * z))
    along_z = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), z], axis=-1)
    return np.roll(along_z, "zxy".index(axis), axis=1)


class DirectionGraph(NamedTuple):
    """Directions and their nearest neighbours, over which water runs.

    Attributes:
        directions: Unit vectors, shape (N, 3).
        neighbours: Indices of the nearest other directions of each, the nearest first, shape (N, k).
    """

    directions: Array
    neighbours: IntArray

    @classmethod
    def of(cls, directions: Array, neighbours: int) -> Self:
        """Connect each direction with its nearest neighbours."""
        nearest = np.asarray(KDTree(directions).query(directions, neighbours + 1)[1], dtype=np.int64)
        return cls(directions, nearest[:, 1:])

    def angles(self) -> Array:
        """Angles in rad between each direction and its neighbours, shape (N, k)."""
        chords = np.linalg.norm(self.directions[:, None] - self.directions[self.neighbours], axis=-1)
        result: Array = 2.0 * np.arcsin(0.5 * chords)
        return result


@lru_cache(maxsize=4)
def _spiral_graph(count: int, offset: float, axis: Axis, neighbours: int) -> DirectionGraph:
    graph = DirectionGraph.of(spiral_directions(count, offset, axis), neighbours)
    for array in graph:
        array.flags.writeable = False
    return graph


@dataclass(frozen=True)
class DrainageCluster:
    """A basin, or several that the oracle takes for one.

    Attributes:
        direction: Body direction that points down at its lowest sink.
        height_mm: Height of the COM over the table there.
        sinks: Number of basins that were merged.
        share: Share of the sampled directions that drain into it.
    """

    direction: Vector
    height_mm: float
    sinks: int
    share: float


@dataclass(frozen=True)
class DrainageResult:
    """What the paper's oracle reads off a landscape of heights; not a verdict.

    Attributes:
        options: The choices that were made.
        clusters: The merged basins, the lowest first.
        height_range_mm: Highest less lowest sampled height (the paper's h-range).
        sre_mm: Mean drop from a sampled direction to the lowest (the paper's Self-Righting Energy).
        steepness_mm_per_rad: Mean slope, as `options.steepness` defines it.
        boa: Share of one cluster, as `options.share` chooses it (the paper's Basin of Attraction).
    """

    options: DrainageOptions
    clusters: tuple[DrainageCluster, ...]
    height_range_mm: float
    sre_mm: float
    steepness_mm_per_rad: float
    boa: float

    @property
    def ecs(self) -> int:
        """The paper's Equilibrium Count Score: how many basins are left after merging."""
        return len(self.clusters)

    @property
    def sinks(self) -> int:
        """Number of basins before merging."""
        return sum(cluster.sinks for cluster in self.clusters)


def drainage_count(
    vertices: Array,
    faces: IntArray,
    com: Sequence[float] | Array | None = None,
    options: DrainageOptions | None = None,
    *,
    turn: Array | None = None,
) -> DrainageResult:
    """Read the paper's figures off a mesh.

    Args:
        vertices: Corners in mm, shape (n, 3).
        faces: Indices of the corners of each triangle, shape (m, 3), of a closed, outward oriented mesh; not
            used where the COM is given.
        com: Centre of mass in mm, shape (3,); by default the centroid that the options name.
        options: The choices; by default those of the paper.
        turn: Orthogonal matrix that turns the directions against the body, shape (3, 3).

    Raises:
        CensusError: If the vertices or the COM are no finite points, or the mesh has no centroid of its own.
    """
    options = options or DrainageOptions.paper()
    points = np.asarray(vertices, dtype=float)
    if points.ndim != 2 or points.shape[1:] != (3,) or not len(points) or not np.isfinite(points).all():
        raise CensusError("A drainage count needs finite vertices of shape (n, 3).")
    center = _centroid(points, np.asarray(faces), options.centre) if com is None else as_point(com)
    graph = _spiral_graph(options.directions, options.spiral_offset, options.spiral_axis, options.neighbours)
    if turn is not None:
        graph = graph._replace(directions=graph.directions @ np.asarray(turn).T)
    return drain(graph, _heights(points, center, graph.directions), options)


def rotated_counts(
    vertices: Array,
    faces: IntArray,
    com: Sequence[float] | Array | None = None,
    options: DrainageOptions | None = None,
    *,
    rotations: int = 30,
    seed: int = 0,
) -> IntArray:
    """Count again and again with the same directions, turned at random: the ECS of each, shape (rotations,).

    The body is the same each time, so every spread in these numbers is an error of the method.

    Args:
        vertices: Corners in mm, shape (n, 3).
        faces: Indices of the corners of each triangle, shape (m, 3).
        com: Centre of mass in mm; by default the centroid that the options name.
        options: The choices; by default those of the paper.
        rotations: Number of rotations, uniform over the rotation group.
        seed: Seed of the random numbers.
    """
    turns = random_rotations(rotations, seed)
    counts = [drainage_count(vertices, faces, com, options, turn=turn).ecs for turn in turns]
    return np.array(counts, dtype=np.int64)


def random_rotations(count: int, seed: int) -> Array:
    """Draw rotation matrices uniformly, shape (count, 3, 3).

    Two independent normal vectors, orthonormalised, have no preferred direction.
    """
    first, second = np.random.default_rng(seed).normal(size=(2, count, 3))
    x = first / lengths(first)[:, None]
    z = cross(x, second)
    z /= lengths(z)[:, None]
    return np.stack([x, cross(z, x), z], axis=1)


def drain(graph: DirectionGraph, heights_mm: Array, options: DrainageOptions) -> DrainageResult:
    """Count the basins of a sampled landscape.

    Args:
        graph: Directions d that point up, and their neighbours.
        heights_mm: Height at each direction, shape (N,).
        options: Threshold, descent, order of merging, share and steepness.
    """
    directions = graph.directions
    sink_of = _sinks(graph, heights_mm, options.descent)
    sinks, basin = np.unique(sink_of, return_inverse=True)
    order = np.argsort(heights_mm[sinks], kind="stable")
    sinks, basin = sinks[order], np.argsort(order)[basin]
    floor, height_range = float(heights_mm.min()), float(np.ptp(heights_mm))
    mergeable = _touching(graph, basin, len(sinks)) if options.adjacent_only else None
    merge = _single_linkage if options.linkage == "single" else _join_the_lowest
    cluster = merge(heights_mm[sinks], options.merge_fraction * height_range, mergeable)
    shares = np.bincount(cluster[basin]) / len(directions)
    merged = np.bincount(cluster)
    lowest = np.unique(cluster, return_index=True)[1]
    clusters = tuple(
        DrainageCluster(as_vector(-directions[sink]), float(heights_mm[sink]), int(count), float(share))
        for sink, count, share in zip(sinks[lowest], merged, shares, strict=True)
    )
    return DrainageResult(
        options=options,
        clusters=clusters,
        height_range_mm=height_range,
        sre_mm=float(heights_mm.mean()) - floor,
        steepness_mm_per_rad=_steepness(graph, heights_mm, options.steepness),
        boa=float(shares.max() if options.share == "largest" else shares[0]),
    )


def _centroid(points: Array, faces: IntArray, centre: Centre) -> Array:
    if faces.shape[1:] != (3,) or not len(faces) or not np.issubdtype(faces.dtype, np.integer):
        raise CensusError("The faces must be rows of three vertex indices; give those or a centre of mass.")
    if faces.min() < 0 or faces.max() >= len(points):
        raise CensusError("A triangle of the mesh refers to a vertex that does not exist; repair the file.")
    if centre == "vertices":
        result: Array = points.mean(axis=0)
        return result
    if centre == "surface":
        corners = points[faces]
        areas = lengths(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
        center: Array = areas @ corners.mean(axis=1) / areas.sum()
        return center
    with np.errstate(invalid="ignore", divide="ignore"):
        mass = mesh_mass(points, faces)
    if not mass.volume_mm3 > 0.0:
        raise CensusError(
            "The mesh is flat or turned inside out, so it has no centre of mass of its own; repair it or "
            "give a centre of mass."
        )
    return np.array(mass.com_mm)


def _heights(points: Array, center: Array, directions: Array) -> Array:
    """Height `c·d − min v·d` over the vertices v, for directions d that point up, shape (N,)."""
    arms = np.ascontiguousarray((points - center).T)
    step = max(1, _BLOCK // len(points))
    blocks = [directions[start : start + step] for start in range(0, len(directions), step)]
    return -np.concatenate([np.min(block @ arms, axis=1) for block in blocks])


def _sinks(graph: DirectionGraph, heights: Array, descent: Descent) -> IntArray:
    """The direction in which the descent from each one ends, shape (N,)."""
    drops = heights[:, None] - heights[graph.neighbours]
    rates = drops / graph.angles() if descent == "steepest" else drops
    best = np.argmax(rates, axis=1)
    here = np.arange(len(heights))
    below: IntArray = np.where(drops[here, best] > 0.0, graph.neighbours[here, best], here)
    # Pointers are doubled: 2^n steps of the descent in n rounds.
    while np.any(below != below[below]):
        below = below[below]
    return below


def _touching(graph: DirectionGraph, basin: IntArray, count: int) -> BoolArray:
    """Whether two basins hold directions that are neighbours, shape (count, count)."""
    touch = np.zeros((count, count), dtype=bool)
    touch[np.repeat(basin, graph.neighbours.shape[1]), basin[graph.neighbours].ravel()] = True
    result: BoolArray = touch | touch.T
    return result


def _join_the_lowest(heights: Array, threshold: float, mergeable: BoolArray | None) -> IntArray:
    """Put each sink, in order of height, into the first cluster whose lowest sink is less than τ below it."""
    cluster = np.full(len(heights), -1)
    floors: list[float] = []
    for sink, height in enumerate(heights.tolist()):
        known = range(len(floors)) if mergeable is None else np.unique(cluster[:sink][mergeable[sink, :sink]])
        near = (int(k) for k in known if height - floors[k] < threshold)
        cluster[sink] = next(near, len(floors))
        if cluster[sink] == len(floors):
            floors.append(height)
    return cluster


def _single_linkage(heights: Array, threshold: float, mergeable: BoolArray | None) -> IntArray:
    """Put sinks that are less than τ apart into one cluster, along chains; clusters are numbered upwards."""
    linked = np.abs(heights[:, None] - heights) < threshold
    if mergeable is not None:
        linked &= mergeable
    # Components are numbered in the order of their first, and so lowest, sinks.
    return np.asarray(connected_components(coo_array(linked), directed=False)[1], dtype=np.int64)


def _steepness(graph: DirectionGraph, heights: Array, kind: Steepness) -> float:
    if kind == "gradient":
        climbs = np.abs(heights[graph.neighbours] - heights[:, None])
        return float(np.mean(climbs / graph.angles()))
    rest = int(np.argmin(heights))
    half_chords = 0.5 * lengths(graph.directions - graph.directions[rest])
    angles = 2.0 * np.arcsin(np.minimum(1.0, half_chords))
    others = np.arange(len(heights)) != rest
    return float(np.mean((heights[others] - heights[rest]) / angles[others]))
