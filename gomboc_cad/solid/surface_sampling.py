"""Points on the true surface of B-rep solids, as dense as their convex hull needs them.

OCCT's mesher is slow at fine deflections, so it makes one coarse mesh only. Its triangles are then halved
in the parameters of their surface, which puts the new points on the surface exactly, and only where the
surface bulges by more than asked and could touch the convex hull.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from build123d import Shape
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
from OCP.GeomAbs import GeomAbs_CurveType
from OCP.gp import gp_Pnt2d
from OCP.TopAbs import TopAbs_State
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Face
from scipy.spatial import ConvexHull, cKDTree

from gomboc_cad.body.sphere import Array, BoolArray, IntArray
from gomboc_cad.errors import GeometryError

MAX_TRIANGLES = 200_000

_COARSE = 2e-3
"""Deflection of OCCT's mesh over the size of the part."""

_ANGLE_RAD = 3.0
"""Large enough not to limit the deflection: without it OCCT adds facets by its own taste."""

_LEAST_SHARE = 1.0 / 16.0
"""Least sag of a quarter of a triangle over the triangle's: it would be a quarter on a paraboloid. Guards
against a bulge that vanishes at the three places where it is measured."""

_ROUNDING = 1e-10
"""Points are rounded to this over the size, so that the same point of two faces is one."""

_THINNING = 0.03
"""Of points nearer than this over the sag one is enough; the sag promises far less than is met."""

_MAX_DEPTH_PRODUCT = 2 * 10**8
_MAX_EDGE_POINTS = 2**14


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Points of a part's surface, and how far their convex hull may fall short of the part's.

    Attributes:
        points_mm: Shape (n, 3).
        faces: Triangles of their convex hull, shape (m, 3), counter-clockwise seen from outside.
        sag_mm: Bound on the distance of the part's surface from the hull, outside of it; about four times
            what it is, because the points in the middles of the triangles are not reckoned with. 0 for a
            part with flat faces and straight edges only.
    """

    points_mm: Array
    faces: IntArray
    sag_mm: float


@dataclass(frozen=True, eq=False)
class _Triangles:
    """Curved triangles: their corners and the middles of their sides, which are on the surface.

    Attributes:
        face: Index of the B-rep face, shape (m,).
        uv: Parameters of the corners, shape (m, 3, 2).
        corners: Shape (m, 3, 3).
        middles: Middles of the sides 12, 23, 31, in the surface's parameters, shape (m, 3, 3).
        sag: Largest distance of the surface from the plane of each triangle, shape (m,).
    """

    face: IntArray
    uv: Array
    corners: Array
    middles: Array
    sag: Array

    def chosen(self, which: BoolArray) -> _Triangles:
        return _Triangles(
            self.face[which], self.uv[which], self.corners[which], self.middles[which], self.sag[which]
        )

    def and_also(self, other: _Triangles) -> _Triangles:
        return _Triangles(
            np.concatenate([self.face, other.face]),
            np.concatenate([self.uv, other.uv]),
            np.concatenate([self.corners, other.corners]),
            np.concatenate([self.middles, other.middles]),
            np.concatenate([self.sag, other.sag]),
        )


class SurfaceSampler:
    """Samples the surfaces of solids more and more finely."""

    def __init__(self, solids: Sequence[Shape], size_mm: float):
        """Mesh the solids coarsely.

        Args:
            solids: The solids, in place.
            size_mm: Size of all of them together.

        Raises:
            GeometryError: If OCCT cannot mesh a face.
        """
        faces = [face.wrapped for solid in solids for face in solid.faces()]
        for solid in solids:
            BRepMesh_IncrementalMesh(solid.wrapped, _COARSE * size_mm, False, _ANGLE_RAD, False)
        self.size_mm = size_mm
        self._surfaces = [BRepAdaptor_Surface(face) for face in faces]
        self._regions = [BRepTopAdaptor_FClass2d(face, 1e-9) for face in faces]
        self._curves = [
            BRepAdaptor_Curve(edge.wrapped)
            for solid in solids
            for edge in solid.edges()
            if not BRep_Tool.Degenerated_s(edge.wrapped)
        ]
        parts = [_face_triangles(face) for face in faces]
        face = np.repeat(np.arange(len(parts)), [len(corners) for _, corners in parts])
        uv = np.concatenate([parameters for parameters, _ in parts])
        corners = np.concatenate([corners for _, corners in parts])
        self._kept = np.unique(corners.reshape(-1, 3), axis=0)
        self._triangles = self._measured(face, uv, corners, np.zeros(len(face)))

    def sample(self, sag_mm: float) -> SurfacePoints:
        """Refine until the hull of the points is within a sag of the part, or the budget is spent.

        Args:
            sag_mm: The sag; call with smaller and smaller ones.

        Returns:
            Points whose sag may be larger, if `MAX_TRIANGLES` do not suffice.
        """
        edges, edge_sag = self._edge_points(sag_mm)
        while True:
            coarse = self._sags() > sag_mm
            if not coarse.any() or len(self._triangles.face) + 3 * coarse.sum() > MAX_TRIANGLES:
                break
            self._drop_buried(edges)
            coarse = self._sags() > sag_mm
            split = self._split(self._triangles.chosen(coarse))
            self._triangles = self._triangles.chosen(~coarse).and_also(split)
        sag = max(edge_sag, float(self._sags().max(initial=0.0)))
        points = self._thinned(np.concatenate([self._kept, edges]), sag)
        hull = ConvexHull(points)
        outer, faces = np.unique(hull.simplices, return_inverse=True)
        faces = _outwards(points[outer], faces.reshape(-1, 3), hull.equations[:, :3])
        return SurfacePoints(points[outer], faces, sag)

    def _sags(self) -> Array:
        # What rounding leaves on a plane is no bulge.
        sag = self._triangles.sag
        return np.where(sag > 1e-13 * self.size_mm, sag, 0.0)

    def _thinned(self, points: Array, sag: float) -> Array:
        """Round points, and keep one where faces and edges made several next to each other."""
        rounding = _ROUNDING * self.size_mm
        points = np.round(points / rounding) * rounding
        cells = np.round(points / max(rounding, _THINNING * sag))
        kept: Array = points[np.unique(cells, axis=0, return_index=True)[1]]
        return kept

    def _drop_buried(self, edges: Array) -> None:
        """Forget triangles so deep inside the hull that no refinement brings them to it."""
        points = np.concatenate([self._kept, edges])
        hull = ConvexHull(points)
        planes, corners = hull.equations, self._triangles.corners
        if len(planes) * 3 * len(corners) > _MAX_DEPTH_PRODUCT:
            return
        # A triangle with a corner of the hull is not under it; on most parts few are left to be looked at.
        gaps = np.asarray(cKDTree(points[hull.vertices]).query(corners)[0])
        inner = np.flatnonzero(gaps.min(axis=1) > 0.0)
        over = np.concatenate(
            [
                (block @ planes[:, :3].T + planes[:, 3]).max(axis=1)
                for block in np.array_split(corners[inner].reshape(-1, 3), 64)
            ]
        )
        deep = over.reshape(-1, 3).max(axis=1) < -2.0 * self._triangles.sag[inner] - 1e-6 * self.size_mm
        kept = np.ones(len(corners), dtype=bool)
        kept[inner[deep]] = False
        self._triangles = self._triangles.chosen(kept)

    def _split(self, parents: _Triangles) -> _Triangles:
        """Cut each triangle into four at the middles of its sides."""
        middle_uv = 0.5 * (parents.uv + np.roll(parents.uv, -1, axis=1))
        uv = _quarters(parents.uv, middle_uv)
        corners = _quarters(parents.corners, parents.middles)
        return self._measured(np.tile(parents.face, 4), uv, corners, np.tile(parents.sag, 4))

    def _measured(self, face: IntArray, uv: Array, corners: Array, parent_sag: Array) -> _Triangles:
        """Evaluate the middles of the sides, keep those on the part, and tell the sag from them."""
        middle_uv = 0.5 * (uv + np.roll(uv, -1, axis=1))
        # Two triangles of a face have the middle of the side between them in common.
        sides = np.column_stack([np.repeat(face, 3).astype(np.float64), middle_uv.reshape(-1, 2)])
        places, row = np.unique(sides, axis=0, return_inverse=True)
        points, inside = self._evaluated(places[:, 0].astype(np.int64), places[:, 1:])
        self._kept = np.concatenate([self._kept, np.unique(points[inside], axis=0)])
        middles = points[row].reshape(-1, 3, 3)
        sag = np.maximum(_sag(corners, middles), _LEAST_SHARE * parent_sag)
        return _Triangles(face, uv, corners, middles, sag)

    def _evaluated(self, face: IntArray, uv: Array) -> tuple[Array, BoolArray]:
        """Points of the surfaces, and whether they are within the trimmed faces."""
        points, inside = np.empty((len(face), 3)), np.empty(len(face), dtype=bool)
        for row, (number, (u, v)) in enumerate(zip(face.tolist(), uv.tolist(), strict=True)):
            point = self._surfaces[number].Value(u, v)
            points[row] = point.X(), point.Y(), point.Z()
            inside[row] = self._regions[number].Perform(gp_Pnt2d(u, v)) != TopAbs_State.TopAbs_OUT
        return points, inside

    def _edge_points(self, sag_mm: float) -> tuple[Array, float]:
        """Points on all edges, and the largest sag of the chords between them."""
        found = [_curve_points(curve, sag_mm) for curve in self._curves]
        points = [np.zeros((0, 3)), *(points for points, _ in found)]
        return np.concatenate(points), max((sag for _, sag in found), default=0.0)


def _face_triangles(face: TopoDS_Face) -> tuple[Array, Array]:
    """Parameters (m, 3, 2) and corners (m, 3, 3) of the triangles that OCCT made of a face."""
    place = TopLoc_Location()
    mesh = BRep_Tool.Triangulation_s(face, place)
    if mesh is None or not mesh.HasUVNodes():
        raise GeometryError("OCCT cannot mesh a face of the solid; repair the solid in a CAD program.")
    transform = place.Transformation()
    nodes, parameters = np.empty((mesh.NbNodes(), 3)), np.empty((mesh.NbNodes(), 2))
    for k in range(mesh.NbNodes()):
        node, uv = mesh.Node(k + 1).Transformed(transform), mesh.UVNode(k + 1)
        nodes[k], parameters[k] = (node.X(), node.Y(), node.Z()), (uv.X(), uv.Y())
    triangles = np.array([mesh.Triangle(k + 1).Get() for k in range(mesh.NbTriangles())]).reshape(-1, 3) - 1
    return parameters[triangles], nodes[triangles]


def _quarters(corners: Array, middles: Array) -> Array:
    """Corners of the four triangles within each triangle (m, 3, d), shape (4 m, 3, d)."""
    at_corners = [np.stack([corners[:, k], middles[:, k], middles[:, k - 1]], axis=1) for k in range(3)]
    return np.concatenate([*at_corners, middles])


def _sag(corners: Array, middles: Array) -> Array:
    """Largest distance of a curved triangle from the flat one, by the middles of its sides, shape (m,).

    Not the distance from the plane: that of a narrow triangle may stand upright on the surface. Along the
    side a middle may be off as the parametrisation likes.
    """
    chords = np.roll(corners, -1, axis=1) - corners
    bulges = middles - (corners + 0.5 * chords)
    squares = np.vecdot(chords, chords)
    along = np.vecdot(bulges, chords) / np.where(squares > 0.0, squares, 1.0)
    heights = np.linalg.norm(bulges - along[..., None] * chords, axis=2)
    # Inside, the bulges of the three sides add up, to 4/9 of their sum in the middle.
    result: Array = np.maximum(heights.max(axis=1), 4.0 / 9.0 * heights.sum(axis=1))
    return result


def _curve_points(curve: BRepAdaptor_Curve, sag_mm: float) -> tuple[Array, float]:
    """Points of an edge at even parameters, so many that its chords keep a sag if possible."""
    first, last = curve.FirstParameter(), curve.LastParameter()
    straight = curve.GetType() == GeomAbs_CurveType.GeomAbs_Line
    count = 2 if straight else 9
    while True:
        found = (curve.Value(t) for t in np.linspace(first, last, count).tolist())
        points = np.array([(point.X(), point.Y(), point.Z()) for point in found])
        if straight:
            return points, 0.0
        bulges = points[1:-1:2] - 0.5 * (points[:-2:2] + points[2::2])
        sag = float(np.linalg.norm(bulges, axis=1).max())
        if sag <= sag_mm or count > _MAX_EDGE_POINTS:
            return points, sag
        count = 2 * count - 1


def _outwards(points: Array, faces: IntArray, normals: Array) -> IntArray:
    """Order the corners of hull triangles counter-clockwise seen from outside."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    inwards = np.vecdot(np.cross(b - a, c - a), normals) < 0.0
    return np.where(inwards[:, None], faces[:, ::-1], faces).astype(np.int64)
