"""Directions on the unit sphere: tangent frames, samplings and triangulations."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def unit(vectors: Array) -> Array:
    """Normalise vectors along the last axis."""
    result: Array = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return result


def tangent_frame(directions: Array) -> tuple[Array, Array]:
    """Give an orthonormal frame of the tangent plane at each direction, without singular places.

    Args:
        directions: Unit vectors, shape (n, 3).

    Returns:
        Two arrays of shape (n, 3), unit, orthogonal to each other and to the directions.

    Source: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6 (2017).
    """
    x, y, z = directions.T
    sign = np.where(z >= 0.0, 1.0, -1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    first = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=-1)
    second = np.stack([b, sign + y * y * a, -y], axis=-1)
    return first, second


def lengths(vectors: Array) -> Array:
    """Euclidean lengths of vectors (n, 3), several times as fast as the general norm."""
    result: Array = np.sqrt(np.einsum("nx,nx->n", vectors, vectors))
    return result


def cross(a: Array, b: Array) -> Array:
    """Cross products of vectors (n, 3), twice as fast as the general one."""
    result = np.empty_like(a)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        np.subtract(a[:, i] * b[:, j], a[:, j] * b[:, i], out=result[:, k])
    return result


def fibonacci_directions(count: int) -> Array:
    """Spread directions almost evenly over the sphere along a golden spiral, shape (count, 3)."""
    index = np.arange(count) + 0.5
    z = 1.0 - 2.0 * index / count
    azimuth = np.pi * (1.0 + np.sqrt(5.0)) * index
    radius = np.sqrt(1.0 - z * z)
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), z], axis=-1)


@lru_cache(maxsize=8)
def geodesic_triangulation(level: int) -> tuple[Array, IntArray]:
    """Subdivide an icosahedron `level` times.

    Returns:
        Vertices on the unit sphere, shape (10·4^level + 2, 3), and counter-clockwise triangles,
        shape (20·4^level, 3); both read-only.
    """
    golden = (1.0 + np.sqrt(5.0)) / 2.0
    corners = [(0.0, s, t * golden) for s in (-1.0, 1.0) for t in (-1.0, 1.0)]
    vertices = unit(np.array([np.roll(c, shift) for shift in range(3) for c in corners]))
    triangles = _icosahedron_faces(vertices)
    for _ in range(level):
        vertices, triangles = subdivide(vertices, triangles)
    vertices.flags.writeable = False
    triangles.flags.writeable = False
    return vertices, triangles


def _icosahedron_faces(vertices: Array) -> IntArray:
    """Find the 20 outward triangles among 12 icosahedron vertices."""
    edge = np.min([np.linalg.norm(vertices[0] - v) for v in vertices[1:]])
    near = np.linalg.norm(vertices[:, None] - vertices[None], axis=-1) < 1.01 * edge
    faces = []
    for i in range(12):
        for j in range(i + 1, 12):
            for k in range(j + 1, 12):
                if near[i, j] and near[j, k] and near[i, k]:
                    outward = np.linalg.det(vertices[[i, j, k]]) > 0.0
                    faces.append((i, j, k) if outward else (i, k, j))
    return np.array(faces, dtype=np.int64)


def subdivide(vertices: Array, triangles: IntArray) -> tuple[Array, IntArray]:
    """Split every triangle into four, with the new vertices on the sphere."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    edges.sort(axis=1)
    keys = edges[:, 0] * len(vertices) + edges[:, 1]
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    middles = unit(vertices[edges[first, 0]] + vertices[edges[first, 1]])
    ab, bc, ca = (inverse + len(vertices)).reshape(3, -1)
    a, b, c = triangles.T
    children = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    finer = np.stack([np.stack(child, axis=-1) for child in children], axis=1)
    return np.concatenate([vertices, middles]), finer.reshape(-1, 3)
