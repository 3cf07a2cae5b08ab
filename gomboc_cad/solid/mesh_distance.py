"""How far a mesh is from the analytic boundary it stands for, in both directions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from manifold3d import Manifold
from scipy.spatial import cKDTree

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.mesh import Mesh, largest_in_facets

_SAMPLES = 4000
_SEARCH = 20.0
"""How far the mesh is looked for from an analytic point, in promised distances."""


@dataclass(frozen=True)
class MeshDistance:
    """Distances between a mesh and its boundary, and what the mesh lacks in volume because of them.

    Attributes:
        from_mesh_um: Largest distance of a facet from the boundary.
        to_mesh_um: Largest distance of the boundary's doubly curved surfaces from the mesh; infinite where
            no facet is near.
        corners_um: Median over the facets of their corners' mean distance; next to nothing where the
            vertices lie on the surfaces, however large the sag.
        missing_mm3: Volume between the facets and the boundary, positive where the mesh is too small.
        missing_moment_mm4: First moment of that volume, shape (3,).
        moved_mm3: The same volume without regard to its sign.
        moved_moment_mm4: Its first moment about the middle of the mesh, likewise.
    """

    from_mesh_um: float
    to_mesh_um: float
    corners_um: float
    missing_mm3: float
    missing_moment_mm4: Array
    moved_mm3: float
    moved_moment_mm4: float


def mesh_distance(mesh: Mesh, manifold: Manifold, boundary: Boundary, promised_um: float) -> MeshDistance:
    """Measure a mesh against its analytic boundary.

    Each facet counts against a surface that its three corners lie on. The distance within a facet is the
    quadratic that the middles of its edges tell; its mean gives the volume between the two.

    Args:
        mesh: The mesh.
        manifold: The same, for ray casting.
        boundary: What it stands for.
        promised_um: The distance it promises to keep.
    """
    largest, mean, at_corners = _facet_distances(mesh, boundary, 1e-3 * promised_um)
    corners = mesh.vertices_mm[mesh.faces]
    area = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    centers = corners.mean(axis=1)
    missing = -area * mean
    middle = 0.5 * (mesh.vertices_mm.min(axis=0) + mesh.vertices_mm.max(axis=0))
    return MeshDistance(
        from_mesh_um=1e3 * float(largest.max()),
        to_mesh_um=_to_mesh_um(manifold, boundary, promised_um),
        corners_um=1e3 * float(np.median(at_corners)),
        missing_mm3=float(missing.sum()),
        missing_moment_mm4=missing @ centers,
        moved_mm3=float(np.abs(missing).sum()),
        moved_moment_mm4=float(np.abs(missing) @ np.linalg.norm(centers - middle, axis=1)),
    )


def _facet_distances(mesh: Mesh, boundary: Boundary, near_mm: float) -> tuple[Array, Array, Array]:
    """Largest distance, mean signed distance (positive outside) and corners' mean distance of each facet.

    The surfaces are tried in turn, the cheap ones first, on the facets that none before has explained.
    """
    edges, edges_of_face = mesh.edges()
    middles = 0.5 * (mesh.vertices_mm[edges[:, 0]] + mesh.vertices_mm[edges[:, 1]])
    largest, mean, mean_at_corners = np.full(len(mesh.faces), np.inf), *np.zeros((2, len(mesh.faces)))
    tree = cKDTree(mesh.vertices_mm[mesh.faces[:, 0]])
    for surface in boundary.surfaces():
        if surface.center_mm is None:
            left = np.flatnonzero(largest > near_mm)
        else:
            near = tree.query_ball_point(surface.center_mm, surface.reach_mm + near_mm)
            left = np.sort(np.array(near, dtype=np.int64))
            left = left[largest[left] > near_mm]
        at_corners = _at_used(surface.distance_mm, mesh.vertices_mm, mesh.faces[left])
        touching = (np.abs(at_corners) <= near_mm).all(axis=1)
        on, corners = left[touching], at_corners[touching]
        sags = _at_used(surface.distance_mm, middles, edges_of_face[on])
        sags -= 0.5 * (corners + np.roll(corners, -1, axis=1))
        largest[on] = largest_in_facets(corners, sags)
        # The mean of a quadratic over a facet.
        mean[on] = surface.outward * (corners.mean(axis=1) + sags.sum(axis=1) / 3.0)
        mean_at_corners[on] = np.abs(corners).mean(axis=1)
    stray = np.flatnonzero(np.isinf(largest))
    largest[stray] = _worst_corner_mm(mesh.vertices_mm[mesh.faces[stray]], boundary)
    return largest, mean, mean_at_corners


def _worst_corner_mm(corners_mm: Array, boundary: Boundary) -> Array:
    """Distance of facets (m, 3, 3) from the surface that suits their corners best."""
    points = corners_mm.reshape(-1, 3)
    distances = [
        np.abs(surface.distance_mm(points)).reshape(-1, 3).max(axis=1) for surface in boundary.surfaces()
    ]
    return np.min(distances, axis=0)


def _at_used(function: Callable[[Array], Array], points: Array, indices: IntArray) -> Array:
    """Values of a function at the indexed points, each computed once, in the shape of the indices."""
    used = np.zeros(len(points), dtype=bool)
    used[indices] = True
    values = np.empty(len(points))
    values[used] = function(points[used])
    return values[indices]


def _to_mesh_um(manifold: Manifold, boundary: Boundary, promised_um: float) -> float:
    """Largest distance, along the normal, of points of the curved surfaces from the mesh."""
    reach_mm = 1e-3 * _SEARCH * promised_um
    farthest = 0.0
    for points, normals in boundary.samples(_SAMPLES, margin_mm=2.0 * reach_mm):
        starts, ends = (points + reach_mm * normals).tolist(), (points - reach_mm * normals).tolist()
        for point, start, end in zip(points.tolist(), starts, ends, strict=True):
            hits = manifold.ray_cast(start, end)
            if not hits:
                return np.inf
            farthest = max(
                farthest, min(float(np.linalg.norm(np.subtract(hit.position, point))) for hit in hits)
            )
    return 1e3 * farthest
