"""Hollow bodies as triangle meshes: manifold3d's side of the twin."""

from __future__ import annotations

import math

import numpy as np
from manifold3d import Error, Manifold, Mesh64, OpType

from gomboc_cad.equilibria.records import Vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.hollow.description import Cylinder, HollowBody
from gomboc_cad.solid.mesh import Mesh, surface_mesh

_SLIVER_SHARE = 1e-6
"""Edges shorter than this share of the size are collapsed; a float32 in STL resolves a tenth of it."""

_FEWEST_SEGMENTS = 12


def mesh(hollow: HollowBody, sag_um: float) -> Mesh:
    """Mesh a hollow body.

    Args:
        hollow: The hollow body.
        sag_um: Largest distance allowed between the facets and the surfaces they stand for: the outer one,
            the cavity's, and those of bosses and holes.

    Raises:
        GeometryError: If the sag is out of range or the parts do not combine to one piece.
    """
    sliver_mm = _SLIVER_SHARE * hollow.body.diameter_mm
    # Once here and once in `split_mesh` may the surface move by a sliver.
    reserve_um = 2e3 * sliver_mm
    outer = _manifold(surface_mesh(hollow.outer, sag_um, reserve_um))
    void = _manifold(surface_mesh(hollow.inner, sag_um, reserve_um))
    bosses = [_cylinder(boss, sag_um - reserve_um) for boss in hollow.placed_bosses]
    holes = [_cylinder(hole, sag_um - reserve_um) for hole in hollow.placed_holes]
    void = Manifold.batch_boolean([void, *bosses], OpType.Subtract)
    return _one_piece(
        Manifold.batch_boolean([outer, void, *holes], OpType.Subtract), sliver_mm, "The hollow body"
    )


def split_mesh(whole: Mesh, origin_mm: Vector, normal: Vector) -> tuple[Mesh, Mesh]:
    """Cut a closed mesh by a plane.

    Args:
        whole: The mesh.
        origin_mm: A point of the plane.
        normal: Its normal, of any length but zero.

    Returns:
        The part below the plane, against the normal, and the part above it.

    Raises:
        GeometryError: If the plane misses the mesh or a side falls into several pieces.
    """
    direction = np.asarray(normal) / np.linalg.norm(normal)
    height = float(direction @ np.asarray(origin_mm))
    upper, lower = _manifold(whole).split_by_plane(direction.tolist(), height)
    sliver_mm = _SLIVER_SHARE * float(np.ptp(whole.vertices_mm, axis=0).max())
    return _one_piece(lower, sliver_mm, "The lower part"), _one_piece(upper, sliver_mm, "The upper part")


def _manifold(mesh: Mesh) -> Manifold:
    faces = np.ascontiguousarray(mesh.faces, dtype=np.uint64)
    result = Manifold(Mesh64(np.ascontiguousarray(mesh.vertices_mm), faces))
    _check(result, "The mesh")
    return result


def _cylinder(cylinder: Cylinder, sag_um: float) -> Manifold:
    """Prism inscribed in a cylinder with as many sides as the sag asks for."""
    half_angle = math.acos(max(-1.0, 1.0 - 1e-3 * sag_um / cylinder.radius_mm))
    return Manifold.hull_points(cylinder.rims_mm(max(_FEWEST_SEGMENTS, math.ceil(math.pi / half_angle))))


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
