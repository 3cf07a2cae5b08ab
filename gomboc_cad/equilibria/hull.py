"""The convex hull of a point set as a polyhedron whose faces are whole: coplanar triangles are merged.

Qhull finds the hull; what it hands over is a triangulation of faces in no particular orientation. Here
the triangles become half-edges, and triangles that lie in one plane, up to the precision of the
coordinates, become one face, so that a cube has six faces however it was meshed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order
from scipy.spatial import ConvexHull, QhullError

from gomboc_cad.body.sphere import Array, BoolArray, IntArray, cross, lengths
from gomboc_cad.errors import CensusError

_SINGLE = 2.0**-24
"""Relative rounding error of a 32-bit coordinate."""

_JITTER = 1e-12
"""Relative random move of the points for Qhull, which needs quadratic time for many points in one plane."""

_FLAT_WITHIN = 1e-11
"""Smallest relative distance from a plane that is told from zero; well above the jitter."""

_MERGE_ROUNDS = 64

_FLATTEST = 1e-6
"""A hull thinner than this, relative to its extent, bounds no body."""


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """A convex polyhedron; half-edge e runs from `origin[e]` to `target[e]`, its face on the left.

    Attributes:
        points_mm: The points that the hull was made of, shape (n, 3).
        origin: Index of a point per half-edge, shape (e,).
        target: Likewise, the end.
        face: Face on the left, seen from outside.
        twin: The half-edge that runs back, on the right.
        following: The next half-edge around the same face.
        corners: Three points of each face, of its largest triangle, counter-clockwise, shape (f, 3).
        normals: Outward unit normal of each face, shape (f, 3).
        precision_mm: Rounding error of the coordinates; triangles within it of one plane are one face.
    """

    points_mm: Array
    origin: IntArray
    target: IntArray
    face: IntArray
    twin: IntArray
    following: IntArray
    corners: IntArray
    normals: Array
    precision_mm: float

    @property
    def face_count(self) -> int:
        """Number of faces."""
        return len(self.corners)

    def vertices(self) -> IntArray:
        """Indices of the points that are corners of faces, rising."""
        return np.flatnonzero(np.bincount(self.origin))

    def edges(self) -> IntArray:
        """One half-edge of each edge."""
        return np.flatnonzero(np.arange(len(self.twin)) < self.twin)


def coordinate_precision_mm(points_mm: Array) -> float:
    """Rounding error of coordinates: that of 32-bit numbers where all are such, as in STL files.

    Args:
        points_mm: Shape (n, 3).
    """
    largest = float(np.abs(points_mm).max(initial=0.0))
    with np.errstate(over="ignore"):
        single = bool(np.all(points_mm.astype(np.float32) == points_mm))
    return largest * (4.0 * _SINGLE if single else _FLAT_WITHIN)


def convex_polyhedron(points_mm: Array, precision_mm: float | None = None) -> Polyhedron:
    """Make the convex hull of points, with coplanar triangles merged into faces.

    Args:
        points_mm: Shape (n, 3).
        precision_mm: Rounding error of the coordinates; by default found from the coordinates.

    Raises:
        CensusError: If the points are too few, not finite, or all in one plane.
    """
    if points_mm.ndim != 2 or points_mm.shape[1] != 3 or len(points_mm) < 4:
        raise CensusError("A mesh census needs at least four vertices with three coordinates each.")
    if not np.all(np.isfinite(points_mm)):
        raise CensusError("The mesh holds coordinates that are not numbers; repair it first.")
    low, high = points_mm.min(axis=0), points_mm.max(axis=0)
    extent = float((high - low).max())
    if precision_mm is None:
        precision_mm = coordinate_precision_mm(points_mm)
    scaled = (points_mm - 0.5 * (low + high)) / (extent or 1.0)
    tolerance = max(precision_mm / (extent or 1.0), _FLAT_WITHIN)
    chosen = np.arange(len(points_mm))
    while True:
        polyhedron = _hull_of(points_mm, scaled, chosen, tolerance, precision_mm)
        # A vertex between two faces is a point that rounding lifted off the edge, not a corner.
        corners = np.flatnonzero(np.bincount(polyhedron.origin) >= 3)
        if len(corners) == len(polyhedron.vertices()):
            return polyhedron
        chosen = corners


def _hull_of(
    points_mm: Array, scaled: Array, chosen: IntArray, tolerance: float, precision_mm: float
) -> Polyhedron:
    try:
        jitter = np.random.default_rng(len(chosen)).uniform(-_JITTER, _JITTER, (len(chosen), 3))
        hull = ConvexHull(scaled[chosen] + jitter)
    except (QhullError, ValueError) as error:
        raise CensusError(_FLAT) from error
    if hull.volume < _FLATTEST * hull.area:
        raise CensusError(_FLAT)
    neighbors = hull.neighbors.astype(np.int64)
    triangles, twin = _oriented(chosen[hull.simplices], neighbors, hull.equations, scaled)
    faces = _merged(triangles, twin, hull.equations, scaled, tolerance)
    return _assemble(points_mm, scaled, triangles, twin, faces, precision_mm)


_FLAT = "The mesh is flat: its vertices lie in one plane, so it has no resting poses; check the file."


def _oriented(
    triangles: IntArray, neighbors: IntArray, equations: Array, points: Array
) -> tuple[IntArray, IntArray]:
    """Turn all triangles counter-clockwise; give them and the twin of each half-edge 3 t + k."""
    count = len(triangles)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    outward = np.einsum("nx,nx->n", cross(b - a, c - a), equations[:, :3])
    flipped = outward < 0.0
    triangles, neighbors = triangles.copy(), neighbors.copy()
    _swap(triangles, neighbors, flipped)
    if not _consistent(triangles, neighbors):
        # Slivers inside a face have no reliable side; the one next to a triangle that has one decides.
        _swap(triangles, neighbors, _disagreeing(triangles, neighbors, int(np.abs(outward).argmax())))
    # Half-edge k of a triangle runs from corner k to corner k + 1 and lies opposite to corner k + 2.
    across = neighbors[:, [2, 0, 1]]
    back = neighbors[across][:, :, [2, 0, 1]] == np.arange(count)[:, None, None]
    if not np.all(back.sum(axis=2) == 1) or not _consistent(triangles, neighbors):
        raise CensusError("The convex hull of the mesh is too nearly degenerate; repair or remesh the part.")
    twin: IntArray = (3 * across + back.argmax(axis=2)).ravel()
    return triangles, twin


def _swap(triangles: IntArray, neighbors: IntArray, chosen: BoolArray) -> None:
    triangles[chosen] = triangles[chosen][:, [0, 2, 1]]
    neighbors[chosen] = neighbors[chosen][:, [0, 2, 1]]


def _sides(triangles: IntArray, neighbors: IntArray) -> BoolArray:
    """Whether each triangle and its neighbour opposite to each corner agree on what is outside."""
    start, end = triangles[:, [1, 2, 0]], triangles[:, [2, 0, 1]]
    theirs = triangles[neighbors]
    position = np.argmax(theirs == start[:, :, None], axis=2)
    ahead = np.take_along_axis(theirs, ((position + 1) % 3)[:, :, None], axis=2)[:, :, 0]
    result: BoolArray = ahead != end
    return result


def _consistent(triangles: IntArray, neighbors: IntArray) -> bool:
    return bool(np.all(_sides(triangles, neighbors)))


def _disagreeing(triangles: IntArray, neighbors: IntArray, seed: int) -> BoolArray:
    """Which triangles must be turned for all to agree with the seed, found along a breadth-first tree."""
    count = len(triangles)
    opposite = _sides(triangles, neighbors)
    rows = np.repeat(np.arange(count), 3)
    graph = coo_array((np.ones(3 * count), (rows, neighbors.ravel())), shape=(count, count)).tocsr()
    parent = breadth_first_order(graph, seed, directed=False)[1]
    parent[seed] = seed
    above = np.argmax(neighbors == parent[:, None], axis=1)
    turned: BoolArray = ~opposite[np.arange(count), above]
    turned[seed] = False
    # Parity along the way to the seed, by doubling the step.
    while np.any(parent != seed):
        turned ^= turned[parent]
        parent = parent[parent]
    return turned


def _merged(
    triangles: IntArray, twin: IntArray, equations: Array, points: Array, tolerance: float
) -> IntArray:
    """Label triangles by the face that they are part of.

    The plane of a sliver is noise, so planes are only ever judged by the larger of two: again and again
    each face whose largest triangle lies in the plane of a larger neighbour joins the largest such one.
    """
    count = len(triangles)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = lengths(cross(b - a, c - a))
    rank = np.empty(count, dtype=np.int64)
    rank[np.argsort(area, kind="stable")] = np.arange(count)

    def flat(large: IntArray, small: IntArray, allowed: float) -> BoolArray:
        heights = np.einsum("nkx,nx->nk", points[triangles[small]], equations[large, :3])
        result: BoolArray = np.abs(heights + equations[large, 3:]).max(axis=1) <= allowed
        return result

    one = np.repeat(np.arange(count), 3)
    other = one[twin]
    face = np.arange(count)
    for _ in range(_MERGE_ROUNDS):
        small, large = face[one], face[other]
        grows = np.flatnonzero(rank[small] < rank[large])
        grows = grows[flat(large[grows], small[grows], 2.0 * tolerance)]
        if len(grows) == 0:
            break
        grows = grows[np.argsort(rank[large[grows]], kind="stable")]
        joins = np.arange(count)
        joins[small[grows]] = large[grows]  # the last one written, the largest neighbour, stays
        while np.any(joins != joins[joins]):
            joins = joins[joins]
        face = joins[face]
    # A chain of almost flat folds that adds up to a curve is no face.
    joined = np.flatnonzero(face != np.arange(count))
    bent = face[joined[~flat(face[joined], joined, 4.0 * tolerance)]]
    loose = np.isin(face, bent)
    face[loose] = np.flatnonzero(loose)
    number = np.cumsum(np.bincount(face, minlength=count) > 0) - 1
    return number[face]


def _largest(labels: IntArray, area: Array) -> IntArray:
    """The largest triangle of each face; of no meaning for labels that do not occur."""
    order = np.argsort(area, kind="stable")
    result = np.zeros(labels.max() + 1, dtype=np.int64)
    result[labels[order]] = order
    return result


def _assemble(
    points_mm: Array, scaled: Array, triangles: IntArray, twin: IntArray, faces: IntArray, precision_mm: float
) -> Polyhedron:
    """Drop the half-edges inside faces and link the others."""
    face = np.repeat(faces, 3)
    rim = face != face[twin]
    index = np.arange(3 * len(triangles))
    following = 3 * (index // 3) + (index + 1) % 3
    # Walk around the end of each half-edge, through the inside of its face, to the next one on the rim.
    ahead = following[rim]
    inside = np.flatnonzero(~rim[ahead])
    while len(inside):
        ahead[inside] = following[twin[ahead[inside]]]
        inside = inside[~rim[ahead[inside]]]
    compact = np.cumsum(rim) - 1
    a, b, c = (scaled[triangles[:, k]] for k in range(3))
    corners = triangles[_largest(faces, lengths(cross(b - a, c - a)))]
    a, b, c = (scaled[corners[:, k]] for k in range(3))
    normals = cross(b - a, c - a)
    normals /= lengths(normals)[:, None]
    origin = triangles.ravel()[rim]
    polyhedron = Polyhedron(
        points_mm=points_mm,
        origin=origin,
        target=triangles.ravel()[following[rim]],
        face=face[rim],
        twin=compact[twin[rim]],
        following=compact[ahead],
        corners=corners,
        normals=normals,
        precision_mm=precision_mm,
    )
    if len(polyhedron.vertices()) - len(origin) // 2 + len(corners) != 2:
        raise CensusError("The convex hull of the mesh is too nearly degenerate; repair or remesh the part.")
    return polyhedron
