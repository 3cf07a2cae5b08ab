"""Hollow bodies as triangle meshes: manifold3d's side of the twin."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from manifold3d import Error, Manifold, Mesh64, OpType

from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.hollow.description import HollowBody
from gomboc_cad.solid.hollow.seam import Seam
from gomboc_cad.solid.hollow.tools import Box, Cylinder, Ellipsoid, Tool, segments
from gomboc_cad.solid.mesh import MAX_LEVEL, Mesh, surface_mesh

_SLIVER_SHARE = 1e-6
"""Edges shorter than this share of the size are collapsed; a float32 in STL resolves a tenth of it."""


def mesh(hollow: HollowBody, sag_um: float) -> Mesh:
    """Mesh a hollow body.

    Args:
        hollow: The hollow body.
        sag_um: Largest distance allowed between the facets and the surfaces they stand for: the outer one,
            the cavity's, and those of bosses, holes and openings.

    Raises:
        GeometryError: If the sag is out of range or the parts do not combine to one piece.
    """
    sliver_mm = _SLIVER_SHARE * hollow.body.diameter_mm
    # Once here and once in `split_mesh` may the surface move by a sliver.
    reserve_um = 2e3 * sliver_mm
    taken = _tools(hollow.placed_cuts, sag_um - reserve_um)
    outer = _manifold(surface_mesh(hollow.outer, sag_um, reserve_um))
    if hollow.inner is not None:
        cavity = _manifold(surface_mesh(hollow.inner, sag_um, reserve_um))
        bosses = _tools(hollow.placed_bosses, sag_um - reserve_um)
        taken.append(Manifold.batch_boolean([cavity, *bosses], OpType.Subtract))
    return _one_piece(Manifold.batch_boolean([outer, *taken], OpType.Subtract), sliver_mm, "The hollow body")


def split_mesh(whole: Mesh, seam: Seam, sag_um: float) -> tuple[Mesh, Mesh]:
    """Cut a closed mesh along a seam.

    Args:
        whole: The mesh.
        seam: The seam.
        sag_um: Largest distance allowed between the facets and the steps of the seam.

    Returns:
        The part below the plane, against its normal, and the part above it.

    Raises:
        GeometryError: If the plane misses the mesh or a side falls into several pieces.
    """
    manifold = _manifold(whole)
    size_mm = float(np.ptp(whole.vertices_mm, axis=0).max())
    sliver_mm = _SLIVER_SHARE * size_mm
    if seam.is_flat:
        upper, lower = manifold.split_by_plane(seam.up.tolist(), float(seam.up @ np.array(seam.origin_mm)))
    else:
        fine_um = sag_um - 1e3 * sliver_mm
        below, above = (_tool(space, fine_um) for space in seam.half_spaces(size_mm))
        tongue, groove = _tools(seam.tongue, fine_um), _tools(seam.taken_below, fine_um)
        upper = manifold - Manifold.batch_boolean([below, *tongue], OpType.Subtract)
        lower = Manifold.batch_boolean([manifold, above, *groove], OpType.Subtract)
    return _one_piece(lower, sliver_mm, "The lower part"), _one_piece(upper, sliver_mm, "The upper part")


def _manifold(mesh: Mesh) -> Manifold:
    faces = np.ascontiguousarray(mesh.faces, dtype=np.uint64)
    result = Manifold(Mesh64(np.ascontiguousarray(mesh.vertices_mm), faces))
    _check(result, "The mesh")
    return result


def _tools(tools: Iterable[Tool], sag_um: float) -> list[Manifold]:
    return [_tool(tool, sag_um) for tool in tools]


def _tool(tool: Tool, sag_um: float) -> Manifold:
    """Polyhedron inscribed in a tool, with facets as small as the sag asks for."""
    match tool:
        case Cylinder():
            full = _prism(tool, sag_um)
            return full if tool.bore is None else full - _prism(tool.bore.extended(1.0, 1.0), sag_um)
        case Ellipsoid():
            return _ellipsoid(tool, sag_um)
        case Box():
            return Manifold.hull_points(tool.hull_mm())


def _prism(cylinder: Cylinder, sag_um: float) -> Manifold:
    return Manifold.hull_points(cylinder.rims_mm(segments(cylinder.radius_mm, sag_um)))


def _ellipsoid(ellipsoid: Ellipsoid, sag_um: float) -> Manifold:
    """Affine image of a geodesic sphere; its sag is at most that of the sphere around it."""
    for level in range(MAX_LEVEL + 1):
        directions, faces = geodesic_triangulation(level)
        depths = 1.0 - np.linalg.norm(directions[faces].mean(axis=1), axis=1)
        if 1e3 * max(ellipsoid.semi_axes_mm) * depths.max() <= sag_um:
            return _manifold(Mesh(ellipsoid.position_mm(directions), faces))
    raise GeometryError(f"A sag of {sag_um:g} µm is too fine for an ellipsoid of this size; allow more.")


def _one_piece(manifold: Manifold, sliver_mm: float, what: str) -> Mesh:
    """Collapse slivers and take the mesh out of a manifold that bounds a single piece of material."""
    _check(manifold, what)
    clean = manifold.simplify(sliver_mm)
    # A cavity is a piece of boundary of its own, with negative volume.
    pieces = sum(piece.volume() > 0.0 for piece in clean.decompose())
    if pieces != 1:
        raise GeometryError(
            f"{what} is in {pieces} pieces where it should be one: look for a plane that misses it, a boss "
            "that stands free in the cavity, or a hole that cuts it apart."
        )
    arrays = clean.to_mesh64()
    return Mesh(np.array(arrays.vert_properties[:, :3]), np.array(arrays.tri_verts, dtype=np.int64))


def _check(manifold: Manifold, what: str) -> None:
    status = manifold.status()
    if status != Error.NoError:
        raise GeometryError(f"{what} is not a closed mesh for manifold3d ({status.name}).")
