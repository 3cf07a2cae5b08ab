"""How far a mesh may be from the smooth surface that its facets stand for, told from the mesh alone.

Where two facets meet at a small angle, they are taken for chords of one smooth surface; where they meet at
a larger one, the edge is an edge of the part. A chord of length w on a curve, with folds α at its ends, has
a sag of α w / 8; on a surface of equal curvatures a regular triangle of width w has one of α w / 3 at
its middle; the larger of the two is used throughout, with a tenth for irregular facets.
"""

from __future__ import annotations

import numpy as np

from gomboc_cad.body.sphere import Array, cross, lengths
from gomboc_cad.equilibria.hull import Polyhedron

LARGEST_SMOOTH_FOLD_DEG = 30.0
"""Facets that meet at a larger angle form an edge of the part and not a tessellated surface."""

_SAG_PER_FOLD_AND_WIDTH = 0.37


def edge_sags_mm(polyhedron: Polyhedron) -> Array:
    """Estimate the sag at each half-edge, 0 at edges of the part, shape (e,).

    A wide flat face next to the narrow facets of a fillet does not sag; so the narrower of the two counts.
    """
    points, face = polyhedron.points_mm, polyhedron.face
    start, end = points[polyhedron.origin], points[polyhedron.target]
    corners = np.bincount(face, minlength=polyhedron.face_count)
    sums = [np.bincount(face, start[:, k], polyhedron.face_count) for k in range(3)]
    middle: Array = np.stack(sums, axis=1) / corners[:, None]
    along = (end - start) / lengths(end - start)[:, None]
    depth = lengths(cross(middle[face] - start, along))
    # The middle of a triangle lies at a third of its width, that of a strip at half of it.
    width = np.where(corners[face] == 3, 3.0, 2.0) * depth
    chord = lengths(polyhedron.normals[face] - polyhedron.normals[face[polyhedron.twin]])
    fold = 2.0 * np.arcsin(np.minimum(1.0, 0.5 * chord))
    sag = _SAG_PER_FOLD_AND_WIDTH * fold * np.minimum(width, width[polyhedron.twin])
    return np.where(np.degrees(fold) < LARGEST_SMOOTH_FOLD_DEG, sag, 0.0)


def com_shift_mm(polyhedron: Polyhedron, sags_mm: Array, com_mm: Array, volume_mm3: float) -> float:
    """Estimate how far the COM of the mesh is from that of the smooth solid.

    Between a facet of area A and the surface lies a volume of 2/3 of A times its sag; the moments of these
    volumes are what the COM of the mesh lacks.

    Args:
        polyhedron: The convex hull.
        sags_mm: From `edge_sags_mm`.
        com_mm: COM of the mesh, shape (3,).
        volume_mm3: Its volume.
    """
    points, face, count = polyhedron.points_mm, polyhedron.face, polyhedron.face_count
    anchor = points[polyhedron.corners[:, 0]][face]
    start, end = points[polyhedron.origin], points[polyhedron.target]
    triangle = 0.5 * np.einsum("nx,nx->n", cross(start - anchor, end - anchor), polyhedron.normals[face])
    moment = triangle[:, None] * ((anchor + start + end) / 3.0 - com_mm)
    sag = np.zeros(count)
    np.maximum.at(sag, face, sags_mm)
    lost = (2.0 / 3.0) * sag[face, None] * moment
    return float(np.linalg.norm(lost.sum(axis=0)) / volume_mm3)
