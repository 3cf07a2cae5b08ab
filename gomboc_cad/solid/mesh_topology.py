"""Corners joined, facets oriented and shells told apart: what makes triangles the boundary of a solid."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from gomboc_cad.body.sphere import Array, BoolArray, IntArray
from gomboc_cad.solid.mesh import Mesh

_WELD = 2.0**-21
"""Corners nearer than this, over the largest coordinate, may be one corner rounded twice: four steps of a
32-bit number."""

_MAX_CROSSING_TESTS = 2 * 10**9
_GENERIC_TURN = np.linalg.qr(np.array([[0.83, 0.31, -0.47], [-0.42, 0.76, 0.53], [0.29, -0.61, 0.71]]))[0]
"""Turns facets so that no edge of a drawn part is upright or passes over a corner."""


class EdgeFaults(NamedTuple):
    """Edges that do not join exactly two facets.

    Attributes:
        open: Edges of one facet only, as pairs of vertices, shape (k, 2).
        branched: Number of edges of more than two facets.
    """

    open: IntArray
    branched: int


def join_equal_corners(mesh: Mesh) -> tuple[Mesh, int]:
    """Join vertices of equal coordinates and leave out those without a facet.

    Returns:
        The mesh, and how many facets lost an edge by that and were dropped with it.
    """
    points = mesh.vertices_mm + 0.0  # turns −0.0 into 0.0
    keys = np.zeros(len(points), dtype=np.uint64)
    for bits in points.T.copy().view(np.uint64):
        # Numbers that came from 32 bits have nothing in their lower halves.
        keys = (keys ^ bits ^ (bits >> np.uint64(32))) * np.uint64(0x9E3779B97F4A7C15)
        keys ^= keys >> np.uint64(29)
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    if not np.array_equal(points[first[inverse]], points):  # two different points had one key
        _, first, inverse = np.unique(points, axis=0, return_index=True, return_inverse=True)
    return _relabelled(Mesh(points[first], mesh.faces), inverse.ravel())


def join_rounded_corners(mesh: Mesh, faults: EdgeFaults) -> tuple[Mesh, int]:
    """Join corners of open edges that are apart by no more than the rounding of 32-bit coordinates.

    Args:
        mesh: The mesh.
        faults: Its edge faults.

    Returns:
        The mesh, and how many vertices it has less.
    """
    rim = np.unique(faults.open)
    reach = _WELD * float(np.abs(mesh.vertices_mm).max())
    pairs = rim[cKDTree(mesh.vertices_mm[rim]).query_pairs(reach, output_type="ndarray")]
    count = len(mesh.vertices_mm)
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    groups, labels = connected_components(graph, directed=False)
    first = np.zeros(groups, dtype=np.int64)
    first[labels[::-1]] = np.arange(count)[::-1]
    return _relabelled(Mesh(mesh.vertices_mm[first], mesh.faces), labels.astype(np.int64))[0], count - groups


def _relabelled(mesh: Mesh, labels: IntArray) -> tuple[Mesh, int]:
    """Renumber corners by labels; collapsed facets and unused vertices go."""
    faces = labels[mesh.faces]
    a, b, c = faces.T
    kept = faces[(a != b) & (b != c) & (c != a)]
    used = np.zeros(len(mesh.vertices_mm), dtype=bool)
    used[kept] = True
    numbers = np.cumsum(used) - 1
    return Mesh(mesh.vertices_mm[used], numbers[kept].astype(np.int64)), len(faces) - len(kept)


def without_repeated_facets(mesh: Mesh) -> Mesh:
    """Drop facets that are there already with the same corners in the same order of turning."""
    start = mesh.faces.argmin(axis=1)
    rows = np.arange(len(start))
    turned = np.stack([mesh.faces[rows, (start + k) % 3] for k in range(3)], axis=1)
    order = np.lexsort(turned.T)
    repeated = np.zeros(len(turned), dtype=bool)
    repeated[order[1:]] = np.all(turned[order[1:]] == turned[order[:-1]], axis=1)
    return Mesh(mesh.vertices_mm, mesh.faces[~repeated]) if repeated.any() else mesh


def edge_faults(mesh: Mesh) -> EdgeFaults:
    """Find the edges that do not join exactly two facets."""
    edges, edges_of_face = mesh.edges()
    uses = np.bincount(edges_of_face.ravel(), minlength=len(edges))
    return EdgeFaults(edges[uses == 1], int(np.sum(uses > 2)))


class Shells(NamedTuple):
    """A mesh without edge faults, taken apart into connected shells.

    Attributes:
        mesh: The same, the facets of each shell turned to face the same side of it.
        shell: Shell of each facet, counted from zero, shape (m,).
        turned: How many facets were turned over.
        orientable: False for a surface with one side, as a Klein bottle's.
    """

    mesh: Mesh
    shell: IntArray
    turned: int
    orientable: bool


def oriented_shells(mesh: Mesh) -> Shells:
    """Turn facets over until neighbours agree, as few as possible of each shell.

    Works on two copies of the facets, as they are and turned over, each joined to the copy of its neighbour
    that it agrees with: the copies of a shell fall apart exactly if it has two sides.

    Args:
        mesh: A mesh whose edges join exactly two facets each.
    """
    count = len(mesh.faces)
    heads, tails = mesh.faces, np.roll(mesh.faces, -1, axis=1)
    ahead = (heads < tails).ravel()
    pairs = np.argsort(mesh.edges()[1].ravel(), kind="stable").reshape(-1, 2)
    left, right = pairs.T // 3
    disagree = (ahead[pairs[:, 0]] == ahead[pairs[:, 1]]).astype(np.int64)
    rows = np.concatenate([left, left + count])
    columns = np.concatenate([right + count * disagree, right + count * (1 - disagree)])
    graph = coo_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(2 * count, 2 * count))
    as_is, turned = connected_components(graph, directed=False)[1].reshape(2, count)
    _, shell = np.unique(np.minimum(as_is, turned), return_inverse=True)
    turn = as_is > turned
    mostly = 2 * np.bincount(shell, weights=turn) > np.bincount(shell)
    turn ^= mostly[shell]
    faces = np.where(turn[:, None], mesh.faces[:, ::-1], mesh.faces)
    return Shells(Mesh(mesh.vertices_mm, faces), shell, int(turn.sum()), not bool(np.any(as_is == turned)))


def shell_volumes(shells: Shells) -> Array:
    """Signed volume of each shell, negative where its facets face inwards."""
    vertices = shells.mesh.vertices_mm - shells.mesh.vertices_mm.mean(axis=0)
    corners = vertices[shells.mesh.faces]
    six = np.einsum("nx,nx->n", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return np.bincount(shells.shell, weights=six) / 6.0


def shells_around(shells: Shells) -> Array | None:
    """How often the other shells wind around each shell, those that face inwards counted negative.

    Signed crossings of a ray from a vertex of the shell.

    Returns:
        One number per shell; None if there are too many shells and facets to tell.
    """
    _, first = np.unique(shells.shell, return_index=True)
    if len(first) * len(shells.mesh.faces) > _MAX_CROSSING_TESTS:
        return None
    points = shells.mesh.vertices_mm @ _GENERIC_TURN
    corners = points[shells.mesh.faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    result = np.zeros(len(first))
    for number, start in enumerate(points[shells.mesh.faces[first, 0]]):
        x, y, z = start
        over: BoolArray = (low[:, 0] <= x) & (high[:, 0] > x) & (low[:, 1] <= y) & (high[:, 1] > y)
        over &= (high[:, 2] > z) & (shells.shell != number)
        result[number] = _signed_crossings(corners[over] - start)
    return result


def _signed_crossings(corners: Array) -> float:
    """Crossings of the upward ray from the origin with facets, positive where they face up."""
    plane = corners[:, :, :2]
    ahead = np.roll(plane, -1, axis=1)
    areas = plane[:, :, 0] * ahead[:, :, 1] - plane[:, :, 1] * ahead[:, :, 0]
    hit = np.all(areas > 0.0, axis=1) | np.all(areas < 0.0, axis=1)
    areas, whole = areas[hit], areas[hit].sum(axis=1)
    heights = np.einsum("nk,nk->n", np.roll(areas, -1, axis=1), corners[hit, :, 2]) / whole
    return float(np.sign(whole[heights > 0.0]).sum())
