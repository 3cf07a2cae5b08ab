"""Polyhedra of known shape, and the equilibria of a convex polytope by definition."""

from __future__ import annotations

from itertools import combinations, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

GOLDEN = (1.0 + np.sqrt(5.0)) / 2.0


class Mesh(NamedTuple):
    """A closed triangle mesh, counter-clockwise from outside."""

    vertices: Array
    faces: IntArray


def hull_mesh(points: Array) -> Mesh:
    """Triangles of the convex hull, turned outwards."""
    hull = ConvexHull(points)
    faces = hull.simplices.astype(np.int64)
    a, b, c = (points[faces[:, k]] for k in range(3))
    inward = np.einsum("nx,nx->n", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward][:, [0, 2, 1]]
    return Mesh(points, faces)


def platonic(faces: int) -> Array:
    """Vertices of a Platonic solid about the origin."""
    cube = np.array(list(product((-1.0, 1.0), repeat=3)))
    cyclic = [np.roll(np.eye(3), k, axis=1) for k in range(3)]
    golden = np.array([(0.0, s, t * GOLDEN) for s in (-1.0, 1.0) for t in (-1.0, 1.0)])
    if faces == 4:
        return cube[np.prod(cube, axis=1) > 0.0]
    if faces == 6:
        return cube
    if faces == 8:
        return np.concatenate([np.eye(3), -np.eye(3)])
    icosahedron = np.concatenate([golden @ turn for turn in cyclic])
    if faces == 20:
        return icosahedron
    # The dodecahedron is dual to it.
    hull = hull_mesh(icosahedron)
    return hull.vertices[hull.faces].mean(axis=1)


def prism(sides: int, height: float, *, radius: float = 1.0) -> Array:
    """Vertices of a regular prism about the origin, its axis along z."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    ring = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.concatenate([np.column_stack([ring, np.full(sides, z)]) for z in (-height / 2, height / 2)])


def cone(sides: int, radius: float, height: float) -> Array:
    """Vertices of a cone, base at z = 0."""
    return np.concatenate([prism(sides, 0.0, radius=radius)[:sides], [[0.0, 0.0, height]]])


class Counts(NamedTuple):
    """Numbers of equilibria."""

    stable: int
    saddles: int
    unstable: int


def equilibria_by_definition(points: Array, com: Array) -> Counts:
    """Count by the definition: a foot of a perpendicular from c, on a plane, line or point of the hull, from
    which the plane across it leaves all points on one side."""
    hull = ConvexHull(points)
    scale = np.ptp(points)

    def rests(foot: Array) -> bool:
        return bool(np.all((points - foot) @ (foot - com) <= 1e-9 * scale * scale))

    def carried(foot: Array, corners: Array) -> bool:
        weights = np.linalg.lstsq((corners[1:] - corners[0]).T, foot - corners[0], rcond=None)[0]
        return bool(np.all(weights > 0.0) and weights.sum() < 1.0)

    stable = saddles = 0
    for simplex, plane in zip(hull.simplices, hull.equations, strict=True):
        foot = com - (plane[:3] @ com + plane[3]) * plane[:3]
        stable += rests(foot) and carried(foot, points[simplex])
    edges = {tuple(sorted(pair)) for simplex in hull.simplices for pair in combinations(simplex.tolist(), 2)}
    for a, b in edges:
        along = points[b] - points[a]
        foot = points[a] + ((com - points[a]) @ along) / (along @ along) * along
        saddles += rests(foot) and carried(foot, points[[a, b]])
    unstable = sum(rests(points[v]) for v in hull.vertices)
    return Counts(stable, saddles, unstable)
