"""The mesh census: exact equilibria of the convex hull of a mesh, and which of them are real.

A mesh is a polyhedron, and a fine one of a smooth body has thousands of equilibria in flocks around those
of the body (Domokos, Lángi, Szabó, arXiv 1106.0626). They are all counted exactly, and told from the real
ones by their persistence: the mesh is closer to the body than its sag, so the height functions differ
by no more, and by the stability of persistence (Cohen-Steiner, Edelsbrunner, Harer, Discrete Comput.
Geom. 37 (2007) 103) a rest with a higher barrier is one of the body's. For vertices on the surface the
height is wrong to one side only, and every barrier by one sag at most.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from gomboc_cad.body.arrays import triangle_mesh
from gomboc_cad.body.mass import MassProperties, is_closed_mesh, mesh_mass
from gomboc_cad.body.sphere import Array, BoolArray, IntArray, tangent_frame
from gomboc_cad.equilibria.convexity import as_point
from gomboc_cad.equilibria.extent import Relief
from gomboc_cad.equilibria.heights import HullHeights
from gomboc_cad.equilibria.hull import convex_polyhedron, coordinate_precision_mm
from gomboc_cad.equilibria.persistence import MergeTree, merge_tree
from gomboc_cad.equilibria.polyhedron import Landscape, landscape
from gomboc_cad.equilibria.records import (
    Census,
    CensusVerdict,
    Equilibrium,
    Extent,
    MeshEvidence,
    Rest,
    Vector,
    as_vector,
)
from gomboc_cad.equilibria.release import Shares, release_shares
from gomboc_cad.equilibria.resolution import com_shift_mm, edge_sags_mm
from gomboc_cad.errors import CensusError, DegenerateEquilibriaError

_ROUGHEST = 0.36
"""Highest barrier that the facets of a mesh make on their own, in units of the sag that is estimated for it.

Found: 0.34 on cylinders, 0.1 to 0.34 on spheres, ellipsoids and Sloan bodies of 5,000 to 330,000 facets.
"""

_COARSEST = 0.06
"""A mesh whose barrier is a larger part of the height range can hide a second rest of any consequence."""

_MOST_DOUBT = 0.1
"""Where the roughness of the mesh decides about more of the orientations, probabilities are not given."""

_WELDS = (10.0, 30.0, 100.0, 300.0, 1000.0)
"""Sizes, in rounding errors, of the cells within which vertices may be taken for one."""

_MOST_EXTENTS = 64
_MOST_PLACES = 10


def mesh_census(
    vertices: Array,
    faces: IntArray,
    com: Sequence[float] | Array | None = None,
    *,
    barrier_mm: float | None = None,
    sag_mm: float | None = None,
    probabilities: bool = True,
) -> Census:
    """Count and describe the equilibria of the convex hull of a mesh on a flat table.

    Args:
        vertices: Corners in mm, shape (n, 3).
        faces: Indices of the corners of each triangle, shape (m, 3); any triangles will do where the COM is
            given, a closed and outward oriented mesh is needed for a homogeneous one.
        com: Centre of mass in mm, shape (3,); that of the homogeneous solid if not given.
        barrier_mm: Equilibria with a lower barrier do not count; by default what the resolution of the
            mesh may falsify a barrier by.
        sag_mm: Largest distance between the mesh and the surface that it stands for, on which its vertices
            are; by default estimated from the mesh. Zero for a part that really has these facets.
        probabilities: Whether to follow releases from all orientations where there are several poses.

    Raises:
        CensusError: If the mesh is flat or empty, no triangle bounds it, an index or coordinate is no
            number, the COM lies outside the hull, or an option is negative.
        DegenerateEquilibriaError: If rounding makes the counts contradict Poincaré–Hopf.
    """
    points, faces = _checked(vertices, faces, barrier_mm, sag_mm)
    mass = mesh_mass(points, faces) if is_closed_mesh(faces, len(points)) else None
    if com is None and (mass is None or not mass.volume_mm3 > 0.0):
        raise CensusError(
            "The mesh is not closed, or turned inside out, so it has no centre of mass of its own; repair it "
            "or give a centre of mass."
        )
    center = as_point(mass.com_mm if com is None and mass is not None else com if com is not None else ())
    used = np.flatnonzero(np.bincount(faces.ravel()))
    ground = _ground(points[used], center)
    polyhedron = ground.polyhedron
    uncertainty = polyhedron.precision_mm
    if sag_mm is not None:
        sag = sag_mm
    else:
        sags = edge_sags_mm(polyhedron)
        sag = float(sags.max())
        if com is None and mass is not None:
            # A shift of the COM changes the difference of two heights by twice itself at most.
            uncertainty += 2.0 * com_shift_mm(polyhedron, sags, center, mass.volume_mm3)
    uncertainty += sag
    barrier = uncertainty if barrier_mm is None else barrier_mm
    return _census(ground, mass, sag, uncertainty, barrier, probabilities)


def _checked(
    vertices: Array, faces: IntArray, barrier_mm: float | None, sag_mm: float | None
) -> tuple[Array, IntArray]:
    for name, value in (("barrier", barrier_mm), ("sag", sag_mm)):
        if value is not None and not 0.0 <= value < np.inf:
            raise CensusError(f"The {name} must be a length of zero or more, not {value!r}.")
    return triangle_mesh(vertices, faces, CensusError)


def _ground(points: Array, center: Array) -> Landscape:
    """The landscape of the hull; vertices that rounding does not keep apart are made one if need be."""
    try:
        return landscape(convex_polyhedron(points), center)
    except DegenerateEquilibriaError:
        rounding = coordinate_precision_mm(points)
    for factor in _WELDS:
        width = factor * rounding
        first = np.unique(np.round(points / width), axis=0, return_index=True)[1]
        with suppress(DegenerateEquilibriaError):
            return landscape(convex_polyhedron(points[np.sort(first)], width), center)
    return landscape(convex_polyhedron(points), center)


class _Side(NamedTuple):
    """Minima or maxima: the landscape as rising water sees it, upside down for maxima."""

    tree: MergeTree
    relief: Relief
    heights: Array


def _minima(ground: Landscape) -> _Side:
    p, edges = ground.polyhedron, ground.edges
    ends = np.stack([p.face[edges], p.face[p.twin[edges]]], axis=1)
    areas = np.stack([ground.vertex[edges], ground.vertex[p.twin[edges]]], axis=1)
    downhill = np.arange(p.face_count)
    heights = ground.face_height_mm
    over = np.flatnonzero(~ground.inside)
    below = p.face[p.twin[over]]
    falls = heights[below] < heights[p.face[over]]
    over, below = over[falls], below[falls]
    order = np.argsort(-heights[below], kind="stable")
    downhill[p.face[over[order]]] = below[order]  # the last one written, the lowest neighbour, stays
    tree = merge_tree(heights, ends, ground.edge_height_mm, downhill)
    return _Side(tree, Relief(heights, ground.vertex_height_mm, ground.edge_height_mm, ends, areas), heights)


def _maxima(ground: Landscape) -> _Side:
    p, edges = ground.polyhedron, ground.edges
    ends = np.stack([ground.vertex[edges], ground.vertex[p.twin[edges]]], axis=1)
    areas = np.stack([p.face[edges], p.face[p.twin[edges]]], axis=1)
    edge_of = np.empty(len(p.twin), dtype=np.int64)
    edge_of[edges] = edge_of[p.twin[edges]] = np.arange(len(edges))
    distance = np.linalg.norm(p.points_mm[ground.vertex_ids] - ground.com_mm, axis=1)
    over = np.flatnonzero(~ground.ahead)
    above = ground.vertex[p.twin[over]]
    rises = distance[above] > distance[ground.vertex[over]]
    over, above = over[rises], above[rises]
    order = np.argsort(ground.edge_height_mm[edge_of[over]], kind="stable")
    uphill = np.arange(len(ground.vertex_ids))
    uphill[ground.vertex[over[order]]] = above[order]  # over the highest pass
    heights, passes = -ground.vertex_height_mm, -ground.edge_height_mm
    return _Side(
        merge_tree(heights, ends, passes, uphill),
        Relief(heights, -ground.face_height_mm, passes, ends, areas),
        heights,
    )


def _census(
    ground: Landscape,
    mass: MassProperties | None,
    sag: float,
    uncertainty: float,
    barrier: float,
    probabilities: bool,
) -> Census:
    low, high = _minima(ground), _maxima(ground)
    stable, unstable = low.tree.counted(barrier), high.tree.counted(barrier)
    poses = _poses(ground, low, stable, barrier, uncertainty if probabilities else None)
    tops = _tops(ground, high, unstable, barrier)
    saddles = _saddles(ground, low, stable) + _saddles(ground, high, unstable)
    equilibria = tuple(sorted((*poses, *tops, *saddles), key=lambda pose: pose.height_mm))
    persistence = low.tree.persistence
    height_range = ground.height_range_mm
    verdict, reason = _judge(persistence, poses, sag, uncertainty, barrier, height_range)
    others = np.flatnonzero(~stable)
    others = others[np.argsort(-persistence[others], kind="stable")]
    counted = persistence[stable & np.isfinite(persistence)]
    normals = ground.polyhedron.normals
    evidence = MeshEvidence(
        facets=ground.polyhedron.face_count,
        raw_stable=int(ground.stable.sum()),
        raw_unstable=int(ground.unstable.sum()),
        raw_saddles=int(ground.saddles.sum()),
        neutral=ground.ties,
        sag_mm=sag,
        barrier_mm=barrier,
        lowest_counted_mm=float(counted.min()) if len(counted) else None,
        highest_uncounted_mm=float(persistence[others[0]]) if len(others) else None,
        uncounted_directions=tuple(
            as_vector(normals[face]) for face in low.tree.bottom[others[:_MOST_PLACES]].tolist()
        ),
    )
    return Census(
        com_mm=as_vector(ground.com_mm),
        equilibria=equilibria,
        height_range_mm=height_range,
        rest=_rest(poses[0]),
        verdict=verdict,
        reason=reason,
        mass_properties=mass,
        mesh=evidence,
        height_at=HullHeights(ground.polyhedron.points_mm[ground.vertex_ids], ground.com_mm),
    )


def _poses(
    ground: Landscape, low: _Side, counted: BoolArray, barrier: float, uncertainty: float | None
) -> list[Equilibrium]:
    """The stable poses, the lowest first; without the uncertainty, without probabilities of several."""
    chosen = np.flatnonzero(counted)
    climbs = low.tree.climb(low.heights, counted)
    shares = Shares(np.ones(1), 0.0) if len(chosen) == 1 else None
    if shares is None and uncertainty is not None:
        home = low.tree.homes(counted)
        floors = low.heights[low.tree.bottom]
        # Just below a pass, and above it, the roughness decides to which side a basin belongs.
        doubtful = ~counted & (floors > (floors + climbs)[home] - uncertainty)
        number = np.cumsum(counted) - 1
        shares = release_shares(ground, number[home][low.tree.basin], doubtful[low.tree.basin], len(chosen))
    known = shares is not None and shares.doubtful <= _MOST_DOUBT
    return [
        Equilibrium(
            kind="stable",
            direction=as_vector(ground.polyhedron.normals[low.tree.bottom[basin]]),
            height_mm=float(low.heights[low.tree.bottom[basin]]),
            barrier_mm=float(min(climbs[basin], ground.height_range_mm)),
            probability=float(shares.of_pose[k]) if shares is not None and known else None,
            probability_error=None if shares is None else shares.doubtful,
            extent=_extent(low, basin, barrier, len(chosen)),
        )
        for k, basin in enumerate(chosen.tolist())
    ]


def _tops(ground: Landscape, high: _Side, counted: BoolArray, barrier: float) -> list[Equilibrium]:
    """The unstable poses."""
    chosen = np.flatnonzero(counted)
    climbs = high.tree.climb(high.heights, counted)
    points = ground.polyhedron.points_mm[ground.vertex_ids] - ground.com_mm
    return [
        Equilibrium(
            kind="unstable",
            direction=_unit_vector(points[high.tree.bottom[basin]]),
            height_mm=float(-high.heights[high.tree.bottom[basin]]),
            barrier_mm=float(min(climbs[basin], ground.height_range_mm)),
            extent=_extent(high, basin, barrier, len(chosen)),
        )
        for basin in chosen.tolist()
    ]


def _saddles(ground: Landscape, side: _Side, counted: BoolArray) -> list[Equilibrium]:
    """The passes at which all counted basins but the deepest end."""
    passes = side.tree.pass_edge[counted]
    return [
        Equilibrium(
            kind="saddle",
            direction=as_vector(ground.edge_direction(int(ground.edges[edge]))),
            height_mm=float(ground.edge_height_mm[edge]),
        )
        for edge in passes[passes >= 0].tolist()
    ]


def _extent(side: _Side, basin: int, barrier: float, count: int) -> Extent:
    # Each costs a walk over the whole mesh; a part with very many poses is a polyhedron, not a ring.
    return side.relief.extent(int(side.tree.bottom[basin]), barrier) if count <= _MOST_EXTENTS else "point"


def _unit_vector(vector: Array) -> Vector:
    return as_vector(vector / np.linalg.norm(vector))


def _rest(pose: Equilibrium) -> Rest:
    one, other = tangent_frame(np.array([pose.direction]))
    return Rest(
        direction=pose.direction,
        height_mm=pose.height_mm,
        stiffness_mm=(np.inf, np.inf),
        soft_direction=as_vector(one[0]),
        stiff_direction=as_vector(other[0]),
    )


def _judge(
    persistence: Array,
    poses: list[Equilibrium],
    sag: float,
    uncertainty: float,
    barrier: float,
    height_range: float,
) -> tuple[CensusVerdict, str]:
    """Say what the barriers prove, given by how much the resolution may falsify each of them."""
    sure = max(barrier, uncertainty)
    certain = int((persistence >= sure).sum())
    near = persistence[(persistence > barrier - (1.0 - _ROUGHEST) * uncertainty) & (persistence < sure)]
    finer = "a finer mesh, or the STEP file," if sag > 0.0 else "a file with more digits"
    if certain >= 2:
        return "multistable", f"{certain} stable rests have barriers above {1e3 * sure:.4g} µm."
    if poses[0].extent != "point":
        where = "in a whole ring of poses" if poses[0].extent == "ring" else "in every pose"
        return "undecided", (
            f"The part rests neutrally {where}, up to a barrier of {1e3 * barrier:.4g} µm; {finer} would "
            "tell whether one of them is its rest."
        )
    if len(near):
        return "undecided", (
            f"A rest with a barrier of {1e3 * near.max():.4g} µm may be one of the part or of its facets, "
            f"which stand for the surface to {1e3 * uncertainty:.4g} µm; {finer} would decide it."
        )
    if barrier == uncertainty and barrier > _COARSEST * height_range:
        return "undecided", (
            f"The mesh is too coarse: it may hide barriers of up to {1e3 * barrier:.4g} µm where the height "
            f"of the centre of mass varies by {1e3 * height_range:.4g} µm in all; {finer} would decide it."
        )
    return "monostable", (
        f"There is one stable rest for every barrier above {1e3 * barrier:.4g} µm; the highest barrier of "
        f"any other basin is {1e3 * _highest(persistence):.4g} µm."
    )


def _highest(persistence: Array) -> float:
    return float(persistence[np.isfinite(persistence)].max(initial=0.0))
