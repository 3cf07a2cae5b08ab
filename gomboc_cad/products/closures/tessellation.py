"""Meshes of solids that have no formula of their own, by OCCT's mesher, with a sag that is measured."""

from __future__ import annotations

import numpy as np
from build123d import Solid
from manifold3d import Error, Manifold, Mesh64
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepTools import BRepTools
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Face
from scipy.spatial import cKDTree

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.mesh import Mesh

_WIDEST_ANGLE = 0.5
_SLIVER_SHARE = 1e-6
"""Length, in units of the size, below which points are one and edges are collapsed."""

_ROUNDS = 5
_SHRINK = 0.6
_WHERE = np.array([[1.0, 1.0, 1.0], [1.5, 1.5, 0.0], [0.0, 1.5, 1.5], [1.5, 0.0, 1.5]]) / 3.0
"""Middle of a facet and of its edges, as weights of its corners."""


def solid_mesh(solid: Solid, sag_um: float) -> Mesh:
    """Mesh a solid.

    OCCT aims at the sag it is given and may miss it. So the distance of the surface from the middle of each
    facet and of each of its edges is measured, and the solid is meshed again until it is kept.

    Args:
        solid: The solid.
        sag_um: Largest distance between the facets and the surface.

    Raises:
        GeometryError: If the sag is not a positive length, OCCT does not reach it, or the mesh is not closed.
    """
    if not (np.isfinite(sag_um) and sag_um > 0.0):
        raise GeometryError(f"The sag of a mesh must be a positive length in µm, not {sag_um!r}.")
    aim = 1e-3 * sag_um
    for _ in range(_ROUNDS):
        BRepTools.Clean_s(solid.wrapped)
        BRepMesh_IncrementalMesh(solid.wrapped, aim, False, _WIDEST_ANGLE, False)
        faces = [_face_mesh(face.wrapped) for face in solid.faces()]
        if max(sag for _, _, sag in faces) <= 1e-3 * sag_um:
            joined = _joined([points for points, _, _ in faces], [corners for _, corners, _ in faces])
            if joined.status() == Error.NoError:
                return _without_slivers(joined)
        aim *= _SHRINK
    raise GeometryError(
        f"OCCT cannot make a closed mesh of the solid with a sag of {sag_um:g} µm; take another sag or "
        "other sizes."
    )


def _face_mesh(face: TopoDS_Face) -> tuple[Array, IntArray, float]:
    """Points (n, 3) and facets (m, 3) that OCCT made of a face, and their sag."""
    place = TopLoc_Location()
    made = BRep_Tool.Triangulation_s(face, place)
    if made is None or not made.HasUVNodes():
        raise GeometryError("OCCT cannot mesh a face of the solid; choose other sizes.")
    transform = place.Transformation()
    nodes = [made.Node(k + 1).Transformed(transform) for k in range(made.NbNodes())]
    points = np.array([(node.X(), node.Y(), node.Z()) for node in nodes])
    parameters = np.array([(uv.X(), uv.Y()) for uv in (made.UVNode(k + 1) for k in range(made.NbNodes()))])
    facets = np.array([made.Triangle(k + 1).Get() for k in range(made.NbTriangles())], dtype=np.int64) - 1
    sag = _sag_mm(BRepAdaptor_Surface(face), parameters[facets], points[facets])
    if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
        facets = facets[:, ::-1]
    return points, facets, sag


def _sag_mm(surface: BRepAdaptor_Surface, parameters: Array, corners: Array) -> float:
    """Largest distance from the planes of facets, corners (m, 3, 3), of the surface over their middles."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    middles = np.einsum("wk,mkp->mwp", _WHERE, parameters)
    values = [surface.Value(u, v) for u, v in middles.reshape(-1, 2).tolist()]
    places = np.array([(value.X(), value.Y(), value.Z()) for value in values]).reshape(*middles.shape[:2], 3)
    return float(np.abs(np.einsum("mwx,mx->mw", places - corners[:, :1], normals)).max(initial=0.0))


def _joined(points: list[Array], facets: list[IntArray]) -> Manifold:
    """The meshes of all faces as one, whose points agree along common edges but for rounding."""
    starts = np.cumsum([0, *(len(part) for part in points[:-1])])
    every = np.concatenate(points)
    first = np.arange(len(every))
    weld_mm = _SLIVER_SHARE * float(np.ptp(every, axis=0).max())
    for low, high in sorted(cKDTree(every).query_pairs(weld_mm)):
        first[high] = first[low]
    kept, index = np.unique(first, return_inverse=True)
    corners = index[np.concatenate([part + start for part, start in zip(facets, starts, strict=True)])]
    distinct = (corners != np.roll(corners, -1, axis=1)).all(axis=1)
    return Manifold(Mesh64(every[kept], np.ascontiguousarray(corners[distinct], dtype=np.uint64)))


def _without_slivers(joined: Manifold) -> Mesh:
    """A mesh without edges too short for the single precision of STL."""
    low, high = np.array(joined.bounding_box()).reshape(2, 3)
    clean = joined.simplify(_SLIVER_SHARE * float((high - low).max())).to_mesh64()
    return Mesh(np.array(clean.vert_properties[:, :3]), np.array(clean.tri_verts, dtype=np.int64))
