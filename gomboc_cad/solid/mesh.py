"""Triangle meshes of analytic surfaces with a sag that is really met.

The vertices lie on the surface, at the directions of a subdivided icosahedron; the sag is the largest
distance between a facet and the surface under it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gomboc_cad.body import Body
from gomboc_cad.body.mass import MassProperties, mesh_mass
from gomboc_cad.body.sphere import Array, IntArray, geodesic_triangulation
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.offset import InsetSurface

MAX_LEVEL = 7
"""Finest subdivision: 327,680 facets, a sag of 1.3 µm on 100 mm; each level costs four times the last."""

_TRIAL_LEVEL = 4
# The sag falls by 4 with each level, to about a percent from the trial level on.
_SAFETY = 1.03


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed triangle mesh, its facets counter-clockwise seen from outside.

    Attributes:
        vertices_mm: Shape (n, 3), float64.
        faces: Indices of corners, shape (m, 3).
    """

    vertices_mm: Array
    faces: IntArray

    def edges(self) -> tuple[IntArray, IntArray]:
        """Edges as pairs of vertices, shape (k, 2), and edges 12, 23 and 31 of each face, shape (m, 3)."""
        a, b, c = self.faces.T
        pairs = np.sort(np.stack([a, b, b, c, c, a], axis=1).reshape(-1, 2), axis=1)
        keys, inverse = np.unique(pairs[:, 0] * len(self.vertices_mm) + pairs[:, 1], return_inverse=True)
        return np.stack(np.divmod(keys, len(self.vertices_mm)), axis=1), inverse.reshape(-1, 3)

    def mass(self) -> MassProperties:
        """Exact mass properties of the polyhedron."""
        return mesh_mass(self.vertices_mm, self.faces)


def body_mesh(body: Body, sag_um: float) -> Mesh:
    """Mesh a body's surface.

    Args:
        body: The body.
        sag_um: Largest distance allowed between the facets and the analytic surface.

    Raises:
        GeometryError: If the sag is not positive or needs more than `MAX_LEVEL`.
    """
    return surface_mesh(InsetSurface(body), sag_um)


def surface_mesh(surface: InsetSurface, sag_um: float, reserve_um: float = 0.0) -> Mesh:
    """Mesh an inset surface; see `body_mesh` and, for the reserve, `subdivision_level`."""
    directions, faces = geodesic_triangulation(subdivision_level(surface, sag_um, reserve_um))
    return Mesh(surface.position_mm(directions), faces)


def subdivision_level(surface: InsetSurface, sag_um: float, reserve_um: float = 0.0) -> int:
    """Lowest level of subdivision of the icosahedron that meets a sag.

    Args:
        surface: The surface.
        sag_um: Largest distance allowed between the facets and the surface.
        reserve_um: What later steps will use up of that.

    Raises:
        GeometryError: If the sag is not positive or needs more than `MAX_LEVEL`.
    """
    if not (math.isfinite(sag_um) and sag_um > 0.0):
        raise GeometryError(f"The sag must be a positive length in µm, not {sag_um!r}.")
    directions, faces = geodesic_triangulation(_TRIAL_LEVEL)
    trial = _SAFETY * facet_sag_um(Mesh(surface.position_mm(directions), faces), surface).max()
    finest = trial / 4.0 ** (MAX_LEVEL - _TRIAL_LEVEL) + reserve_um
    if sag_um < finest:
        # Rounded up, so that the figure in the sentence is enough.
        enough = math.ceil(finest * 10.0) / 10.0
        raise GeometryError(
            f"A sag of {sag_um:g} µm needs more than {20 * 4**MAX_LEVEL:,} facets at this size; ask for "
            f"{enough:g} µm or more."
        )
    return _TRIAL_LEVEL + max(0, math.ceil(math.log(trial / (sag_um - reserve_um), 4.0)))


def facet_sag_um(mesh: Mesh, surface: InsetSurface) -> Array:
    """Largest distance of each facet from the surface that its corners lie on, shape (m,)."""
    edges, edges_of_face = mesh.edges()
    sags = 1e3 * surface.signed_distance_mm(mesh.vertices_mm[edges].mean(axis=1))[edges_of_face]
    return largest_in_facets(np.zeros_like(sags), sags)


def largest_in_facets(at_corners: Array, edge_sags: Array) -> Array:
    """Largest absolute value in each facet of a function that is quadratic there.

    The distance of a small facet from a smooth surface is such a function.

    Args:
        at_corners: Values at the three corners, shape (m, 3).
        edge_sags: What the middles of the edges 12, 23 and 31 have over the mean of their ends, shape (m, 3).

    Returns:
        Shape (m,).
    """
    ahead = np.roll(at_corners, -1, axis=1)
    # Along an edge the value is c + (c' − c) t + 4 s t (1 − t).
    sags = np.where(edge_sags == 0.0, np.inf, edge_sags)
    tilt = (ahead - at_corners) / (8.0 * sags)
    crests = 0.5 * (at_corners + ahead) + edge_sags * (1.0 + 4.0 * tilt * tilt)
    largest = np.abs(np.where(np.abs(tilt) < 0.5, crests, at_corners)).max(axis=1)
    c1, c2, c3 = at_corners.T
    s12, s23, s31 = edge_sags.T
    # Inside, the gradient in the first two barycentric coordinates vanishes at one point.
    mixed = s12 - s23 - s31
    f1, f2 = 0.25 * (c1 - c3) + s31, 0.25 * (c2 - c3) + s23
    det = 4.0 * s31 * s23 - mixed * mixed
    det = np.where(det == 0.0, np.inf, det)
    x, y = (2.0 * s23 * f1 + mixed * f2) / det, (2.0 * s31 * f2 + mixed * f1) / det
    inside = (x > 0.0) & (y > 0.0) & (x + y < 1.0)
    crest = c3 + 2.0 * (f1 * x + f2 * y)
    result: Array = np.maximum(
        np.maximum(largest, np.abs(at_corners).max(axis=1)), np.where(inside, np.abs(crest), 0.0)
    )
    return result
