"""Where a polyhedron comes to rest when it is let go at a random orientation without speed.

Quasi-statically it turns about the vertex that touches the table, then about an edge, until it lies on a
face, always down the steepest slope of the height: on the sphere of directions that point down, straight
away from the direction of the vertex to the next arc, along the arc to the next face, and on from there
if the face is not stable. This flow is followed exactly; only the area of the sphere that flows to each
rest is found by sampling, on triangles that are split where their corners flow to different rests.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray, IntArray, cross, geodesic_triangulation, subdivide, unit
from gomboc_cad.equilibria.polyhedron import Landscape

_START_LEVEL = 4
_SPLITS = 5
_PATIENCE = 20
# A generic orientation keeps the samples off the symmetry planes of the part.
_TURN = np.linalg.qr(np.array([[0.61, -0.35, 0.71], [0.23, 0.93, 0.29], [-0.76, 0.02, 0.64]]))[0]


class Shares(NamedTuple):
    """Shares of the sphere of orientations.

    Attributes:
        of_pose: That flow to each pose, good to about 1e-4; they sum to 1.
        doubtful: That flow to a face marked as doubtful.
    """

    of_pose: Array
    doubtful: float


def release_shares(landscape: Landscape, pose_of_face: IntArray, doubtful: BoolArray, poses: int) -> Shares:
    """Measure the share of the orientations that flow to each pose.

    Args:
        landscape: The height function of the polyhedron.
        pose_of_face: The pose that each face belongs to, shape (f,).
        doubtful: Whether a flow that ends at the face might as well belong to another pose, shape (f,).
        poses: Number of poses.
    """
    flow = _Flow(landscape)
    vertices, triangles = geodesic_triangulation(_START_LEVEL)
    vertices = vertices @ _TURN.T
    final = flow.final_face(vertices)
    shares, unsure = np.zeros(poses), 0.0
    for split in range(_SPLITS + 1):
        ends = final[triangles]
        at_corners = pose_of_face[ends]
        mixed = np.any(at_corners != at_corners[:, :1], axis=1)
        settled = ~mixed if split < _SPLITS else np.ones(len(triangles), dtype=bool)
        area = _spherical_area(vertices[triangles[settled]]) / 3.0
        np.add.at(shares, at_corners[settled], area[:, None])
        unsure += float(area @ doubtful[ends[settled]].sum(axis=1))
        if settled.all():
            break
        known = len(vertices)
        vertices, triangles = subdivide(vertices, triangles[mixed])
        final = np.concatenate([final, flow.final_face(vertices[known:])])
    return Shares(shares / shares.sum(), unsure / float(shares.sum()))


def _spherical_area(corners: Array) -> Array:
    """Area of spherical triangles, shape (n, 3, 3): van Oosterom and Strackee, IEEE BME-30 (1983) 125."""
    a, b, c = corners.transpose(1, 0, 2)
    triple = np.einsum("nx,nx->n", a, cross(b, c))
    ab, bc, ca = (np.einsum("nx,nx->n", p, q) for p, q in ((a, b), (b, c), (c, a)))
    result: Array = 2.0 * np.arctan2(triple, 1.0 + ab + bc + ca)
    return result


class _Flow:
    """The steepest descent on the sphere of directions that point down."""

    def __init__(self, landscape: Landscape) -> None:
        p = landscape.polyhedron
        self._landscape, self._polyhedron = landscape, p
        self._arms = p.points_mm[landscape.vertex_ids] - landscape.com_mm
        self._toward = unit(self._arms)
        self._first = np.zeros(len(self._arms), dtype=np.int64)
        self._first[landscape.vertex] = np.arange(len(p.origin))
        self._around = p.following[p.twin]
        ahead_at_end = landscape.ahead[p.twin]
        self._valley = landscape.ahead & ahead_at_end
        # The foot of an unstable face is nearest to one of its edges or to one of its corners.
        faces = np.arange(p.face_count)
        over_edge = np.flatnonzero(~landscape.inside & self._valley)
        below = p.face[p.twin[over_edge]]
        over_edge = over_edge[landscape.face_height_mm[below] < landscape.face_height_mm[p.face[over_edge]]]
        self._slide = faces.copy()
        self._slide[p.face[over_edge]] = p.face[p.twin[over_edge]]
        while np.any(self._slide != self._slide[self._slide]):
            self._slide = self._slide[self._slide]
        behind = np.flatnonzero(~ahead_at_end)
        corner = behind[~landscape.ahead[p.following[behind]]]
        self._pivot = np.full(p.face_count, -1)
        self._pivot[p.face[corner]] = landscape.vertex[p.following[corner]]
        self._pivot[landscape.stable] = -1

    def final_face(self, directions: Array) -> IntArray:
        """The stable face that each direction flows to, or an unstable one on the way to it, shape (n,)."""
        u = directions.copy()
        vertex = self._lowest_vertex(u)
        face = np.full(len(u), -1)
        height = np.full(len(u), np.inf)
        patience = np.full(len(u), _PATIENCE)
        active = np.arange(len(u))
        while len(active):
            edge = self._exit(vertex[active], u[active])
            there = self._crossing(vertex[active], u[active], edge)
            left, right = self._polyhedron.face[edge], self._polyhedron.face[self._polyhedron.twin[edge]]
            on = ~self._valley[edge]
            u[active], vertex[active] = there, self._landscape.vertex[self._polyhedron.twin[edge]]
            arrived = active[~on]
            landed = self._slide[np.where(self._falls_to_left(edge[~on], there[~on]), left[~on], right[~on])]
            face[arrived] = landed
            u[arrived], vertex[arrived] = self._polyhedron.normals[landed], self._pivot[landed]
            ended = vertex[active] < 0
            # At a corner of the landscape rounding can send the flow in circles; such a face will do.
            now = np.einsum("nx,nx->n", self._arms[vertex[active]], u[active])
            patience[active] = np.where(now < height[active], _PATIENCE, patience[active] - 1)
            height[active] = np.minimum(now, height[active])
            stuck = ~ended & (patience[active] <= 0)
            face[active[stuck]] = left[stuck]
            active = active[~(ended | stuck)]
        return face

    def _lowest_vertex(self, u: Array) -> IntArray:
        """The vertex that touches the table, by climbing from a stride of vertices to better neighbours."""
        points = self._arms
        stride = np.arange(0, len(points), max(1, len(points) // 500))
        vertex: IntArray = stride[np.argmax(u @ points[stride].T, axis=1)]
        depth = np.einsum("nx,nx->n", points[vertex], u)
        moving = np.arange(len(u))
        while len(moving):
            best = vertex[moving]
            start = self._first[best]
            edge, turning = start.copy(), np.arange(len(moving))
            better = depth[moving]
            while len(turning):
                there = self._landscape.vertex[self._polyhedron.twin[edge[turning]]]
                value = np.einsum("nx,nx->n", points[there], u[moving[turning]])
                gain = value > better[turning]
                best[turning[gain]], better[turning[gain]] = there[gain], value[gain]
                edge[turning] = self._around[edge[turning]]
                turning = turning[edge[turning] != start[turning]]
            moved = best != vertex[moving]
            vertex[moving], depth[moving] = best, better
            moving = moving[moved]
        return vertex

    def _exit(self, vertex: IntArray, u: Array) -> IntArray:
        """The half-edge over whose arc the great circle from a vertex's direction through u leaves."""
        p = self._polyhedron
        plane = cross(self._toward[vertex], u)
        edge = self._first[vertex]
        start, turning = edge.copy(), np.arange(len(vertex))
        while len(turning):
            e = edge[turning]
            left = np.einsum("nx,nx->n", plane[turning], p.normals[p.face[e]])
            right = np.einsum("nx,nx->n", plane[turning], p.normals[p.face[p.twin[e]]])
            turning = turning[~((right <= 0.0) & (left > 0.0))]
            edge[turning] = self._around[edge[turning]]
            turning = turning[edge[turning] != start[turning]]
        return edge

    def _crossing(self, vertex: IntArray, u: Array, edge: IntArray) -> Array:
        """Where that great circle meets the arc."""
        p = self._polyhedron
        left, right = p.normals[p.face[edge]], p.normals[p.face[p.twin[edge]]]
        point = cross(cross(right, left), cross(self._toward[vertex], u))
        length = np.linalg.norm(point, axis=1)
        middle = left + right
        # Without a crossing, as when u is the direction of the vertex itself, the middle of the arc will do.
        point = np.where((length > 0.0)[:, None], point, middle)
        point *= np.sign(np.einsum("nx,nx->n", point, middle))[:, None]
        return unit(point)

    def _falls_to_left(self, edge: IntArray, u: Array) -> BoolArray:
        """Whether a point on the arc of a valley edge slides down to the face on its left."""
        p = self._polyhedron
        start, end = p.points_mm[p.origin[edge]], p.points_mm[p.target[edge]]
        along = unit(end - start)
        arm = start - self._landscape.com_mm
        foot = arm - np.einsum("nx,nx->n", arm, along)[:, None] * along
        # The height along the arc is foot·u.
        left = p.normals[p.face[edge]]
        tangent = left - np.einsum("nx,nx->n", left, u)[:, None] * u
        result: BoolArray = np.einsum("nx,nx->n", tangent, foot) < 0.0
        return result
