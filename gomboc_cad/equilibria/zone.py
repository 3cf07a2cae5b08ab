"""The loading zone: where the centre of mass may be so that one stable rest stays.

The number of stable rests changes only when the COM crosses the sheet of κ₁ of the focal surface, `x − n/κ₁`.
So the zone around a COM with one rest is the part of the body that can be reached from it without crossing
that sheet. Nothing else is assumed of its shape: the sheet has cusps and crosses itself.

The body is filled with cells that are the finer the nearer they are to the COM. A node is clear when its
distance to the sheet and to the body's surface exceeds the size of its cells, so that no wall passes between
two neighbours that are clear; those that hang together with the COM make up the zone. Its boundary is drawn
around them and then moved to the walls.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from gomboc_cad.body.mass import mass_properties, mesh_mass
from gomboc_cad.body.sphere import Array, BoolArray, IntArray, unit
from gomboc_cad.body.support import depth_mm
from gomboc_cad.body.surface import Body
from gomboc_cad.equilibria.convexity import as_point
from gomboc_cad.equilibria.free_ball import Walls, best_place, grown, room_mm
from gomboc_cad.equilibria.margin import s_margin_mm
from gomboc_cad.equilibria.octree import Octree, boundary, distinct
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.equilibria.smooth import find_equilibria
from gomboc_cad.errors import CensusError
from gomboc_cad.progress import Progress, silent

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STAGES = 4
"""How many stages `loading_zone` reports."""

_CELLS_PER_MARGIN = 16.0
_CELLS_PER_DISTANCE = 24.0
_NEAR = 0.02
"""Distance from the COM, in units of R₀, beyond which cells grow faster than the distance."""

_GROWTH = 0.3
_LARGEST_CELL = 0.06
_FINENESS = (0.5, 2.0)
_SAMPLES_PER_CELL = 3.0
_CLEARANCE = 0.55
"""More than half a cell: no point of a tetrahedron is farther from all its corners."""

_REACH = 1.0
"""Half the diagonal of a cell, and something for the change of clearance across it, in cells."""

_INSET = 1.0 / 16.0
_SMALLEST_MARGIN = 1e-6
_START_LEVEL = 3
_ROOMY, _STARTS = 2000, 4


@dataclass(frozen=True, eq=False)
class LoadingZone:
    """Where the COM may be so that the body keeps one stable rest.

    Attributes:
        body: The body.
        com_mm: The given centre of mass.
        s_margin_mm: Distance from it to the nearest COM with another number of rests.
        best_com_mm: Centre of the largest ball inside the zone; the ball is inside the body too.
        best_s_margin_mm: Its radius.
        nearest_best_com_mm: The best place that is reached from the given COM by always gaining margin.
        nearest_best_s_margin_mm: The margin there.
        volume_mm3: Volume of the zone.
        vertices_mm: Corners of its boundary, shape (n, 3).
        faces: Triangles, counter-clockwise seen from outside the zone, shape (m, 3); closed.
        fineness: How fine it is drawn, 1 being the default.
    """

    body: Body
    com_mm: Vector
    s_margin_mm: float
    best_com_mm: Vector
    best_s_margin_mm: float
    nearest_best_com_mm: Vector
    nearest_best_s_margin_mm: float
    volume_mm3: float
    vertices_mm: Array
    faces: IntArray
    fineness: float = 1.0

    def resolution_mm(self, points_mm: Array) -> Array:
        """Size of the cells at points (n, 3): how true the drawn zone is; narrower passages count as shut."""
        grading = _Grading(np.array(self.com_mm), self.s_margin_mm, self.body.radius_mm, self.fineness)
        return grading.cell_mm(points_mm)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the section of the zone through the given COM and the nearest place with other rests.

        Args:
            ax: Axes to draw on; new ones if not given.

        Returns:
            The axes.
        """
        from gomboc_cad.report.zone_figures import plot_zone

        return plot_zone(self, ax)


class _Grading(NamedTuple):
    """How large cells are."""

    center_mm: Array
    s_margin_mm: float
    radius_mm: float
    fineness: float

    def cell_mm(self, points_mm: Array) -> Array:
        """Largest cell allowed at points (n, 3) near a wall, shape (n,)."""
        distance = np.linalg.norm(points_mm - self.center_mm, axis=1)
        growth = np.maximum(1.0, distance / (_NEAR * self.radius_mm)) ** _GROWTH
        size = np.maximum(self.s_margin_mm / _CELLS_PER_MARGIN, growth * distance / _CELLS_PER_DISTANCE)
        result: Array = np.minimum(size, _LARGEST_CELL * self.radius_mm) / self.fineness
        return result

    def spacing_mm(self, points_mm: Array) -> Array:
        """Spacing of the samples of a wall at points (n, 3), shape (n,)."""
        return self.cell_mm(points_mm) / _SAMPLES_PER_CELL


class _Walls(Walls):
    """The walls of a zone, as fine as its cells."""

    def __init__(self, body: Body, grading: _Grading) -> None:
        super().__init__(body, grading.spacing_mm)
        self.grading = grading

    def approached(self, points_mm: Array) -> Array:
        """Move points to the walls: onto the surface, and short of the sheet by a fraction of a cell."""
        gap, nearest = self.tree.query(points_mm, workers=-1)
        foot = self.samples_mm[nearest]
        inset = np.minimum(1.0, _INSET * self.grading.cell_mm(points_mm) / gap)
        moved: Array = foot + inset[:, None] * (points_mm - foot)
        surface = ~self.on_sheet[nearest]
        moved[surface] = self.body.position_mm(unit(points_mm[surface]))
        return moved


def loading_zone(
    body: Body,
    com: Sequence[float] | Array | None = None,
    *,
    fineness: float = 1.0,
    progress: Progress = silent,
) -> LoadingZone:
    """Find the zone around a COM in which the body keeps one stable rest, and the best places in it.

    Args:
        body: A strictly convex body.
        com: Centre of mass in mm, shape (3,); the homogeneous centroid if not given.
        fineness: How many times as fine as usual the cells are, 0.5 to 2. At a half the zone has a quarter
            of the triangles and takes a third of the time, but passages of twice the width count as shut,
            so what lies beyond one may be missing, the best place too; margins stay exact.
        progress: Called with the name of each stage as it begins.

    Raises:
        NotConvexError: If the body is not strictly convex.
        DegenerateEquilibriaError: If the equilibria about the COM are not isolated.
        CensusError: If the fineness is out of range, or the COM is not inside the body, has not one stable
            rest, or is so near to the edge of its zone that the zone cannot be drawn.
    """
    center = np.array(mass_properties(body).com_mm) if com is None else as_point(com)
    if not _FINENESS[0] <= fineness <= _FINENESS[1]:
        low, high = _FINENESS
        raise CensusError(
            f"The fineness of a loading zone must be from {low:g} to {high:g}, not {fineness:g}."
        )
    margin = _margin_in_zone(body, center)
    grading = _Grading(center, margin, body.radius_mm, fineness)

    progress("sampling the focal surface")
    walls = _Walls(body, grading)
    progress("filling the body with cells")
    cells = _cells(walls)
    progress("following the zone")
    zone = _reached(cells, walls)
    vertices, faces = _drawn_boundary(zone, walls)
    progress("finding the best centre of mass")
    best = max((grown(walls, start) for start in _roomiest(zone)), key=walls.gap_mm)
    nearest = best_place(body, center, walls.gap_mm(center))
    return LoadingZone(
        body=body,
        com_mm=as_vector(center),
        s_margin_mm=margin,
        best_com_mm=as_vector(best),
        best_s_margin_mm=room_mm(body, best),
        nearest_best_com_mm=as_vector(nearest),
        nearest_best_s_margin_mm=room_mm(body, nearest),
        volume_mm3=mesh_mass(vertices, faces).volume_mm3,
        vertices_mm=vertices,
        faces=faces,
        fineness=fineness,
    )


def best_com_nearby(body: Body, com: Sequence[float] | Array | None = None) -> tuple[Vector, float]:
    """Find the best place for the COM that is reached from a given one by always gaining margin.

    It is what `loading_zone` gives as the nearest best place, without the zone.

    Args:
        body: A strictly convex body.
        com: Centre of mass in mm, shape (3,); the homogeneous centroid if not given.

    Returns:
        The place in mm and the radius in mm of the ball about it that is inside the zone and the body.

    Raises:
        NotConvexError: If the body is not strictly convex.
        DegenerateEquilibriaError: If the equilibria about the COM are not isolated.
        CensusError: If the COM is not inside the body, has not one stable rest, or is at the edge of its
            zone.
    """
    center = np.array(mass_properties(body).com_mm) if com is None else as_point(com)
    radius = min(_margin_in_zone(body, center), float(depth_mm(body, center)[0]))
    best = best_place(body, center, radius)
    return as_vector(best), room_mm(body, best)


def margins_towards_rest(zone: LoadingZone, lowered_mm: Array) -> Array:
    """Radius of the largest ball inside the zone and the body about the COM, lowered towards the rest.

    Args:
        zone: The zone.
        lowered_mm: How far the COM is moved along the direction that points down at rest, shape (n,).
    """
    down = find_equilibria(zone.body, zone.com_mm)[0].direction
    places = np.array(zone.com_mm) + np.outer(lowered_mm, down)
    return np.array([room_mm(zone.body, place) for place in places])


def _margin_in_zone(body: Body, center: Array) -> float:
    """Check that a COM has one rest, and give the radius of its ball: within the zone and the body."""
    rests = sum(e.kind == "stable" for e in find_equilibria(body, center))
    place = ", ".join(f"{c:g}" for c in center)
    if rests != 1:
        raise CensusError(
            f"The body has {rests} stable rests about the centre of mass ({place}) mm, so it is in no "
            "loading zone; give one nearer to the homogeneous centroid or to the rest point."
        )
    margin = s_margin_mm(body, center)
    if margin < _SMALLEST_MARGIN * body.radius_mm:
        raise CensusError(
            f"The centre of mass ({place}) mm is at the edge of its loading zone (S-margin {margin:.3g} mm), "
            "which cannot be drawn around it; move it farther inside."
        )
    return margin


def _cells(walls: _Walls) -> Octree:
    """Cells around the body, near the walls as small as the grading asks."""
    grading = walls.grading

    def wanted(centers: Array, edge: float) -> BoolArray:
        cell = grading.cell_mm(centers)
        reach = _REACH * edge + _clear_distance_mm(grading, centers)
        near = walls.distance_mm(centers, float(reach.max(initial=0.0))) < reach
        result: BoolArray = near & (edge > cell)
        return result

    side = 2.2 * float(np.linalg.norm(walls.samples_mm - grading.center_mm, axis=1).max())
    # No node of the lattice shall lie exactly on a plane of symmetry through the COM.
    middle = grading.center_mm + 0.01 * grading.s_margin_mm * np.array([0.3, 0.5, 0.7])
    return Octree.refined(middle, side, _START_LEVEL, wanted)


def _clear_distance_mm(grading: _Grading, points_mm: Array) -> Array:
    """Distance to the nearest sample from which on a node is clear."""
    result: Array = _CLEARANCE * grading.cell_mm(points_mm) + grading.spacing_mm(points_mm)
    return result


class _Reached(NamedTuple):
    """The part of the cells that hangs together with the COM, and the tetrahedra at its boundary."""

    positions_mm: Array
    gaps_mm: Array
    inside: BoolArray
    tetrahedra: IntArray


def _reached(cells: Octree, walls: _Walls) -> _Reached:
    """Follow the clear nodes from the COM."""
    leaves = list(cells.leaves())
    centers = [cells.center_nodes(level, places) for level, places in leaves]
    corners = [cells.corner_nodes(level, places) for level, places in leaves]
    lattice = distinct(np.concatenate([*centers, *(c.ravel() for c in corners)]))
    at_lattice = walls.distance_mm(cells.node_positions_mm(lattice))

    gaps_at_centers = (at_lattice[np.searchsorted(lattice, nodes)] for nodes in centers)
    keys = np.concatenate(
        [
            cells.tetrahedra(level, _at_edge_of_clearance(cells, level, places, gaps, walls.grading))
            for (level, places), gaps in zip(leaves, gaps_at_centers, strict=True)
        ]
    )
    beside = np.setdiff1d(distinct(keys.ravel()), lattice, assume_unique=True)
    nodes = np.concatenate([lattice, beside])
    order = nodes.argsort()
    nodes, positions = nodes[order], cells.node_positions_mm(nodes[order])
    gaps = np.concatenate([at_lattice, walls.distance_mm(cells.node_positions_mm(beside))])[order]

    clear = gaps > _clear_distance_mm(walls.grading, positions)
    tetrahedra = np.searchsorted(nodes, keys)
    spokes = np.searchsorted(nodes, np.concatenate(centers)), np.searchsorted(nodes, np.concatenate(corners))
    links = [
        _clear_links(clear, np.repeat(spokes[0], 8), spokes[1].ravel()),
        *(_clear_links(clear, *tetrahedra[:, pair].T) for pair in combinations(range(4), 2)),
    ]
    start, end = np.concatenate(links, axis=1)
    graph = coo_array((np.ones(len(start), dtype=bool), (start, end)), shape=2 * (len(nodes),))
    labels = connected_components(graph, directed=False)[1]
    home = np.linalg.norm(positions - walls.grading.center_mm, axis=1).argmin()
    return _Reached(positions, gaps, clear & (labels == labels[home]), tetrahedra)


def _clear_links(clear: BoolArray, start: IntArray, end: IntArray) -> IntArray:
    """Those of the links between nodes whose ends are both clear, shape (2, m)."""
    rows = clear[start] & clear[end]
    return np.stack([start[rows], end[rows]])


def _at_edge_of_clearance(
    cells: Octree, level: int, places: IntArray, gaps_mm: Array, grading: _Grading
) -> IntArray:
    """Cells with clear and other nodes: those that the level set of clearance may pass through."""
    clear = _clear_distance_mm(grading, cells.centers_mm(level, places))
    return places[np.abs(gaps_mm - clear) < _REACH * cells.edge_mm(level)]


def _drawn_boundary(zone: _Reached, walls: _Walls) -> tuple[Array, IntArray]:
    """Closed boundary of the zone, moved to the walls."""
    crossing = boundary(zone.tetrahedra, zone.inside)
    inner, outer = crossing.edges.T
    start = zone.positions_mm[inner]
    arm = zone.positions_mm[outer] - start
    # Within the ball about the inner node that is free of walls.
    free = 0.9 * (zone.gaps_mm[inner] - walls.grading.spacing_mm(start)) / np.linalg.norm(arm, axis=1)
    return walls.approached(start + np.minimum(0.9, free)[:, None] * arm), crossing.faces


def _roomiest(zone: _Reached) -> list[Array]:
    """A few places of the zone that are far from all walls, and apart from each other."""
    order = np.flatnonzero(zone.inside)[np.argsort(-zone.gaps_mm[zone.inside], kind="stable")]
    starts: list[Array] = []
    for index in order[:_ROOMY]:
        place = zone.positions_mm[index]
        if all(np.linalg.norm(place - other) > 0.5 * zone.gaps_mm[index] for other in starts):
            starts.append(place)
        if len(starts) == _STARTS:
            break
    return starts
