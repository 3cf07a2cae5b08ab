"""Definitions of our own for two scores of which the paper gives values only.

**CDS**, contact distribution score. Its source (arXiv 2604.12238) takes the variance over the facets,
weighted by area, of the share of contact time less the share of area, which falls as the facets get smaller.
Here the share of time is per share of area, so that the score belongs to the body and not to its mesh:

    `CDS = ∫ (A τ(x) − 1)² dA / A`, with `∫ τ dA = 1`,

τ(x) being the density of the time for which the surface point x is within `ε = 0.01 R` of the table, R the
radius of the ball of the same volume. It is zero where every part of the surface touches equally long. Which
way a body rolls has to be said too:

* `all`: it is in every orientation equally long;
* `straight`: it turns once about the principal axis of its least moment of inertia, that axis level.

**omni-TDS**, omnidirectional thermal distribution score: a parallel flux of heat comes from every direction
in turn, and the score is the coefficient of variation over the directions of what the body takes in, its
projected area. (In a flux from all directions at once every point of a convex body takes in the same.)

Both are quadratures over fixed directions, without random numbers; nothing is chosen to meet a value.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from gomboc_cad.body.mass import mesh_mass
from gomboc_cad.body.sphere import Array, fibonacci_directions, tangent_frame
from gomboc_cad.equilibria.drainage_shapes import TriangleMesh

Rolling = Literal["all", "straight"]

CONTACT_DEPTH = 0.01
"""How near to the table counts as contact, in radii of the ball of the same volume."""

_POINTS = 8000
_ORIENTATIONS = 4000
_BLOCK = 500


class SurfaceSample(NamedTuple):
    """Points that stand for the surface of a convex body.

    Attributes:
        points: Shape (n, 3), about the centroid.
        areas: Area that each stands for, shape (n,).
    """

    points: Array
    areas: Array


def contact_score(mesh: TriangleMesh, rolling: Rolling) -> float:
    """The contact distribution score of a convex mesh."""
    sample, directions = surface_sample(mesh), _orientations(mesh, rolling)
    mass = mesh_mass(*mesh)
    depth = CONTACT_DEPTH * (0.75 / np.pi * mass.volume_mm3) ** (1.0 / 3.0)
    vertices = mesh.vertices - np.array(mass.com_mm)
    time = np.zeros(len(sample.points))
    for start in range(0, len(directions), _BLOCK):
        block = directions[start : start + _BLOCK]
        table = np.max(block @ vertices.T, axis=1, keepdims=True)
        time += np.count_nonzero(table - block @ sample.points.T < depth, axis=0)
    share = sample.areas / sample.areas.sum()
    return float(share @ (time / (share @ time) - 1.0) ** 2)


def thermal_score(mesh: TriangleMesh) -> float:
    """The omnidirectional thermal distribution score of a convex mesh."""
    corners = mesh.vertices[mesh.faces]
    # Half the cross product of two edges is the vector area; half the sum of |n·d| dA is the projected area.
    vectors = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    directions = fibonacci_directions(_ORIENTATIONS)
    shadows = np.concatenate(
        [
            0.5 * np.abs(directions[start : start + _BLOCK] @ vectors.T).sum(axis=1)
            for start in range(0, len(directions), _BLOCK)
        ]
    )
    return float(shadows.std() / shadows.mean())


def surface_sample(mesh: TriangleMesh) -> SurfaceSample:
    """Points where rays from the centroid, even in direction, leave the convex hull.

    With ρ the length of a ray along u and n the normal there, the ray stands for the area `ρ² dω / (n·u)`.
    """
    directions = fibonacci_directions(_POINTS)
    normals, distances = _facets(mesh)
    reach, cosine = np.empty(_POINTS), np.empty(_POINTS)
    for start in range(0, _POINTS, _BLOCK):
        part = slice(start, start + _BLOCK)
        cosines = directions[part] @ normals.T
        with np.errstate(divide="ignore"):
            leaves = np.where(cosines > 0.0, distances / cosines, np.inf)
        facet = np.argmin(leaves, axis=1)[:, None]
        reach[part] = np.take_along_axis(leaves, facet, axis=1)[:, 0]
        cosine[part] = np.take_along_axis(cosines, facet, axis=1)[:, 0]
    areas = reach**2 / cosine * (4.0 * np.pi / _POINTS)
    return SurfaceSample(reach[:, None] * directions, areas)


def _facets(mesh: TriangleMesh) -> tuple[Array, Array]:
    """Normals of the facets of the hull and their distances from the centroid."""
    equations = ConvexHull(mesh.vertices - np.array(mesh_mass(*mesh).com_mm)).equations
    return equations[:, :3], -equations[:, 3]


def _orientations(mesh: TriangleMesh, rolling: Rolling) -> Array:
    """Directions that point down, one for each equal step of time."""
    if rolling == "all":
        return fibonacci_directions(_ORIENTATIONS)
    # Of equal moments, as of a ball, the first in the order of LAPACK.
    axis = np.linalg.eigh(np.array(mesh_mass(*mesh).inertia_mm5))[1][:, 0]
    first, second = tangent_frame(axis[None])
    angle = 2.0 * np.pi * (np.arange(_ORIENTATIONS) + 0.5) / _ORIENTATIONS
    return np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second
