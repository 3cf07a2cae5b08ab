"""Height of the COM over the table for every orientation of a polyhedron, and its exact equilibria.

With the direction u down, the height `H(u) = max (x − c)·u` is made of pieces: a face is one direction
(its normal), an edge an arc between the normals of its two faces, a vertex the spherical polygon of
all directions in which it is the lowest point. On the polygon of the vertex v the height is
`|v − c| cos∠(u, v − c)`, so all that can happen is decided by two signs per half-edge: whether the foot
of the perpendicular from c on the plane of a face lies inside of an edge, and whether the foot on the
line of an edge lies ahead of an end. A face is stable when its foot is inside of all its edges, a vertex
unstable when the feet on its edges are all ahead of it, an edge a saddle when all four signs are positive.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray, IntArray, cross, lengths
from gomboc_cad.equilibria.hull import Polyhedron
from gomboc_cad.equilibria.predicates import foot_ahead_of_end, foot_inside_of_edge
from gomboc_cad.errors import CensusError, DegenerateEquilibriaError

_NUDGE = np.array([0.62, -0.55, 0.56])
_NUDGES = 5


@dataclass(frozen=True, eq=False)
class Landscape:
    """The height function of a polyhedron about a COM.

    Attributes:
        polyhedron: The polyhedron.
        com_mm: The COM, shape (3,).
        inside: Per half-edge: the foot on its face lies inside of it.
        ahead: Per half-edge: the foot on its line lies ahead of its origin.
        ties: Number of exact zeros among those signs, each edge counted once.
        vertex_ids: Indices of the points that are vertices, rising.
        vertex: Per half-edge: position of its origin among those.
        edges: One half-edge of each edge.
        face_height_mm: Height on each face.
        edge_height_mm: Largest height on the arc of each edge.
        vertex_height_mm: Largest height on the polygon of each vertex.
    """

    polyhedron: Polyhedron
    com_mm: Array
    inside: BoolArray
    ahead: BoolArray
    ties: int
    vertex_ids: IntArray
    vertex: IntArray
    edges: IntArray
    face_height_mm: Array
    edge_height_mm: Array
    vertex_height_mm: Array

    @property
    def height_range_mm(self) -> float:
        """Highest less lowest height."""
        return float(self.vertex_height_mm.max() - self.face_height_mm.min())

    @property
    def stable(self) -> BoolArray:
        """Which faces are stable."""
        return _all(self.inside, self.polyhedron.face, self.polyhedron.face_count)

    @property
    def unstable(self) -> BoolArray:
        """Which vertices are unstable."""
        return _all(self.ahead, self.vertex, len(self.vertex_ids))

    @property
    def saddles(self) -> BoolArray:
        """Which edges are saddles."""
        both = self.inside & self.ahead
        result: BoolArray = (both & both[self.polyhedron.twin])[self.edges]
        return result

    def edge_direction(self, edge: int) -> Array:
        """Direction of the foot of the perpendicular from the COM on the line of a half-edge."""
        points, e = self.polyhedron.points_mm, edge
        return _foot(points[self.polyhedron.origin[e]], points[self.polyhedron.target[e]], self.com_mm)


def landscape(polyhedron: Polyhedron, com_mm: Array) -> Landscape:
    """Measure the heights of a polyhedron and find its equilibria, with S − H + U = 2 asserted.

    Args:
        polyhedron: The polyhedron.
        com_mm: The COM, shape (3,).

    Raises:
        CensusError: If the COM lies outside.
        DegenerateEquilibriaError: If the counts contradict Poincaré–Hopf.
    """
    points = polyhedron.points_mm
    face_height = np.einsum("nx,nx->n", points[polyhedron.corners[:, 0]] - com_mm, polyhedron.normals)
    if face_height.min() <= polyhedron.precision_mm:
        place = ", ".join(f"{c:g}" for c in com_mm)
        raise CensusError(
            f"The centre of mass ({place}) mm lies outside the convex hull; give one inside it."
        )
    center = com_mm
    for k in range(_NUDGES + 1):
        # The planes of merged faces are known to the precision of the coordinates only, and the COM to no
        # better; where that much makes the counts contradictory, a COM next to it is as true.
        found = _landscape(polyhedron, center, face_height)
        if found.stable.sum() - found.saddles.sum() + found.unstable.sum() == 2:
            return found
        center = com_mm + (k + 1) * polyhedron.precision_mm * np.roll(_NUDGE, k)
    raise DegenerateEquilibriaError(
        "The equilibria of the mesh contradict S − H + U = 2, because faces are flat within rounding only; "
        "remesh the part, or give its coordinates with more digits."
    )


def _landscape(polyhedron: Polyhedron, com_mm: Array, face_height: Array) -> Landscape:
    points, start, end, twin = polyhedron.points_mm, polyhedron.origin, polyhedron.target, polyhedron.twin
    inside = foot_inside_of_edge(points, com_mm, polyhedron.corners, polyhedron.face, start, end)
    ahead = foot_ahead_of_end(points, com_mm, start, end)
    edges = polyhedron.edges()
    left, right = polyhedron.face[edges], polyhedron.face[twin[edges]]
    crest = inside.positive[edges] & inside.positive[twin[edges]]
    foot_height = _distance_to_line(points[start[edges]], points[end[edges]], com_mm)
    sides = np.maximum(face_height[left], face_height[right])
    edge_height = np.where(crest, np.maximum(foot_height, sides), sides)
    vertex_ids = polyhedron.vertices()
    position = np.zeros(len(points), dtype=np.int64)
    position[vertex_ids] = np.arange(len(vertex_ids))
    vertex = position[start]
    peak = _all(ahead.positive, vertex, len(vertex_ids))
    vertex_height = np.where(peak, lengths(points[vertex_ids] - com_mm), 0.0)
    for ends in (vertex[edges], vertex[twin[edges]]):
        np.maximum.at(vertex_height, ends, edge_height)
    ties = int((inside.tied | inside.tied[twin] | ahead.tied | ahead.tied[twin])[edges].sum())
    return Landscape(
        polyhedron=polyhedron,
        com_mm=com_mm,
        inside=inside.positive,
        ahead=ahead.positive,
        ties=ties,
        vertex_ids=vertex_ids,
        vertex=vertex,
        edges=edges,
        face_height_mm=face_height,
        edge_height_mm=edge_height,
        vertex_height_mm=vertex_height,
    )


def _all(flags: BoolArray, owner: IntArray, count: int) -> BoolArray:
    """Whether all half-edges of each owner carry a flag."""
    result: BoolArray = np.bincount(owner[~flags], minlength=count) == 0
    return result


def _distance_to_line(start: Array, end: Array, com: Array) -> Array:
    along = (end - start) / lengths(end - start)[:, None]
    result: Array = lengths(cross(com - start, along))
    return result


def _foot(start: Array, end: Array, com: Array) -> Array:
    along = (end - start) / np.linalg.norm(end - start)
    arm = start - com
    foot: Array = arm - (arm @ along) * along
    return foot / np.linalg.norm(foot)
