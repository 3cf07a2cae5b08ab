"""Meshes of the bodies on which the source paper tries its oracle (arXiv 2604.17095 v1).

The paper gives the resolution of its meshes (100 × 200) and says that the bodies are matched in volume. It
does not give that volume, the axes of the ellipsoid, the length of the capsule or the facets of the cylinder.
What is chosen here, with the volume of the unit ball:

* ellipsoid: semi-axes in the ratio 1.5 : 1 : 0.7;
* cylinder: length twice its diameter, as the paper has it, with 64 facets around its axis;
* capsule: straight part five times the radius of its caps;
* bodies of revolution about the z-axis.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Literal, NamedTuple, get_args

import numpy as np
from scipy.spatial import ConvexHull

from gomboc_cad.body.sphere import Array, IntArray, cross
from gomboc_cad.errors import GeometryError

PaperShape = Literal["sphere", "cylinder", "hemisphere", "ellipsoid", "capsule", "cube"]

_BALL = 4.0 * np.pi / 3.0
_CAPSULE_LENGTH = 5.0


class TriangleMesh(NamedTuple):
    """A closed triangle mesh.

    Attributes:
        vertices: Corners, shape (n, 3).
        faces: Indices of the corners, counter-clockwise from outside, shape (m, 3).
    """

    vertices: Array
    faces: IntArray


def ring_mesh(position: Callable[[Array], Array], rings: int = 101, segments: int = 200) -> TriangleMesh:
    """Mesh a star-shaped surface over parallels and meridians, as the paper does.

    What the paper calls a 100 × 200 mesh, of 40,000 facets, is 100 bands between 101 parallels; it counts the
    facets of no area at the poles, which are left out here.

    Args:
        position: Takes unit vectors (n, 3) to points of the surface (n, 3), such as `Body.position_mm`.
        rings: Number of parallels at equal steps of the polar angle, each pole being one.
        segments: Number of meridians.

    Raises:
        GeometryError: If there are fewer than three parallels or meridians.
    """
    if rings < 3 or segments < 3:
        raise GeometryError(f"A ring mesh needs at least 3 rings and 3 segments, not {rings} and {segments}.")
    polar = np.linspace(0.0, np.pi, rings)[1:-1]
    azimuth = 2.0 * np.pi * np.arange(segments) / segments
    around = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    parallels = np.empty((rings - 2, segments, 3))
    parallels[:, :, :2] = np.sin(polar)[:, None, None] * around
    parallels[:, :, 2] = np.cos(polar)[:, None]
    poles = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    directions = np.concatenate([poles[:1], parallels.reshape(-1, 3), poles[1:]])
    return TriangleMesh(position(directions), _ring_faces(rings, segments))


def _ring_faces(rings: int, segments: int) -> IntArray:
    """Two triangles for each quadrilateral of the bands, one at the poles; vertex 0 is the north pole."""
    grid = 1 + np.arange((rings - 2) * segments).reshape(rings - 2, segments)
    east = np.roll(grid, -1, axis=1)
    south = grid[-1, -1] + 1
    triangles = [
        (np.zeros_like(grid[0]), grid[0], east[0]),
        (grid[:-1], grid[1:], east[:-1]),
        (east[:-1], grid[1:], east[1:]),
        (grid[-1], np.full_like(grid[0], south), east[-1]),
    ]
    return np.concatenate([np.stack(corners, axis=-1).reshape(-1, 3) for corners in triangles])


def paper_shape(name: PaperShape, rings: int = 101, segments: int = 200) -> TriangleMesh:
    """Mesh one of the bodies of the paper's tables, with the volume of the unit ball.

    Args:
        name: Which body.
        rings: Parallels of the mesh of a rounded body.
        segments: Meridians of the mesh of a rounded body.

    Raises:
        GeometryError: If the paper has no body of that name.
    """
    if name == "sphere":
        return ring_mesh(lambda u: u, rings, segments)
    if name == "ellipsoid":
        axes = np.array((1.5, 1.0, 0.7))
        return ring_mesh(lambda u: u * axes / np.prod(axes) ** (1.0 / 3.0), rings, segments)
    if name == "capsule":
        return _capsule(rings, segments)
    if name == "hemisphere":
        return _hull(2.0 ** (1.0 / 3.0) * _dome(rings, segments))
    if name == "cylinder":
        radius = (1.0 / 3.0) ** (1.0 / 3.0)
        ends = [np.insert(_circle(64, radius), 2, z, axis=1) for z in (-2.0 * radius, 2.0 * radius)]
        return _hull(np.concatenate(ends))
    if name == "cube":
        return _hull(0.5 * _BALL ** (1.0 / 3.0) * np.array(list(product((-1.0, 1.0), repeat=3))))
    raise GeometryError(f"The paper tries no body {name!r}; choose one of {', '.join(get_args(PaperShape))}.")


def _capsule(rings: int, segments: int) -> TriangleMesh:
    """Two half spheres and the cylinder between them; its volume is π r² L + 4 π r³/3 with L = 5 r."""
    radius = (_BALL / (np.pi * _CAPSULE_LENGTH + _BALL)) ** (1.0 / 3.0)
    cap = _dome(rings, segments) * radius + (0.0, 0.0, 0.5 * _CAPSULE_LENGTH * radius)
    return _hull(np.concatenate([cap, cap * (1.0, 1.0, -1.0)]))


def _dome(rings: int, segments: int) -> Array:
    """Points of the upper half of the unit sphere, its rim at z = 0 included."""
    points = ring_mesh(lambda u: u, rings, segments).vertices
    rim = np.pad(_circle(segments, 1.0), ((0, 0), (0, 1)))
    return np.concatenate([points[points[:, 2] > 1e-9], rim])


def _circle(count: int, radius: float) -> Array:
    angle = 2.0 * np.pi * np.arange(count) / count
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _hull(points: Array) -> TriangleMesh:
    """Triangles of the convex hull, turned outwards."""
    hull = ConvexHull(points)
    faces = hull.simplices.astype(np.int64)
    a, b, c = (points[faces[:, k]] for k in range(3))
    inward = np.einsum("nx,nx->n", cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return TriangleMesh(points, faces)
