"""The parts of an assembly as coarse shapes for the report's view in space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepTools import BRepTools
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Face

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.products.assembly import Part
from gomboc_cad.report.packing import packed, packed_integers

_SAG = 0.002
"""Distance of the facets from the true surface, in diameters of the product."""

_ANGLE_RAD = 0.5
_MOST_CORNERS = 1 << 16
"""Of a part, so that two bytes number them."""


def part_shapes(parts: Sequence[Part], diameter_mm: float) -> list[dict[str, Any]]:
    """Name, colour and coarse facets of each part, in place; those of a face of the solid share no corners.

    A part with too many corners for a picture is left out. Call it when the solids are not needed any more:
    it replaces the facets that OCCT keeps with them.
    """
    shapes = [(part, *_coarse(part, _SAG * diameter_mm)) for part in parts]
    return [
        {
            "name": part.name,
            "color": list(part.color),
            "made": part.made,
            "positions_mm": packed(points),
            "faces": packed_integers(facets),
        }
        for part, points, facets in shapes
        if 0 < len(points) <= _MOST_CORNERS
    ]


def _coarse(part: Part, sag_mm: float) -> tuple[Array, IntArray]:
    """Corners (n, 3) and facets (m, 3), outward, of a part."""
    BRepTools.Clean_s(part.solid.wrapped)
    BRepMesh_IncrementalMesh(part.solid.wrapped, sag_mm, False, _ANGLE_RAD, False)
    faces = [found for face in part.solid.faces() if (found := _face_mesh(face.wrapped)) is not None]
    starts = np.cumsum([0, *(len(points) for points, _ in faces)])
    points = np.concatenate([np.zeros((0, 3)), *(points for points, _ in faces)])
    facets = [corners + start for (_, corners), start in zip(faces, starts[:-1], strict=True)]
    return points, np.concatenate([np.zeros((0, 3), dtype=np.int64), *facets])


def _face_mesh(face: TopoDS_Face) -> tuple[Array, IntArray] | None:
    """Corners and facets that OCCT made of a face; None if it made none, which a picture can do without."""
    place = TopLoc_Location()
    made = BRep_Tool.Triangulation_s(face, place)
    if made is None:
        return None
    transform = place.Transformation()
    nodes = [made.Node(k + 1).Transformed(transform) for k in range(made.NbNodes())]
    points = np.array([(node.X(), node.Y(), node.Z()) for node in nodes])
    facets = np.array([made.Triangle(k + 1).Get() for k in range(made.NbTriangles())], dtype=np.int64) - 1
    if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
        facets = facets[:, ::-1]
    return points, facets
