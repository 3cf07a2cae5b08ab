"""The outer surface with what its colours show: distance from the sphere, curvature, and where to drill."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from gomboc_cad.body.sphere import Array, IntArray, geodesic_triangulation
from gomboc_cad.body.support import support_about
from gomboc_cad.body.surface import Body
from gomboc_cad.equilibria.drill_map import safe_radius_mm
from gomboc_cad.equilibria.records import Rest, Vector, as_vector
from gomboc_cad.errors import NotConvexError
from gomboc_cad.report.packing import packed, packed_integers, unpacked, unpacked_integers

_LEVEL, _DRILL_LEVEL = 5, 3


@dataclass(frozen=True, eq=False)
class SurfaceFields:
    """A triangulated outer surface, in the body's frame, with a value of each field at each corner.

    Attributes:
        radius_mm: Nominal radius R₀, that of the sphere it is compared with.
        com_mm: Centre of mass.
        pose: The soft direction, the stiff one and up at rest, as orthonormal rows.
        positions_mm: Corners, shape (n, 3).
        normals: Outward unit normals there, shape (n, 3).
        faces: Triangles, counter-clockwise from outside, shape (m, 3).
        deviation_mm: Distance from the origin of the body's frame, less R₀, shape (n,).
        gaussian_curvature_per_mm2: Product of the principal curvatures, positive all over a strictly
            convex body, shape (n,).
        drill_radius_mm: Radius of the largest hole, recess or flat that adds no rest, shape (n,); None if the
            body is not strictly convex.
    """

    radius_mm: float
    com_mm: Vector
    pose: tuple[Vector, Vector, Vector]
    positions_mm: Array
    normals: Array
    faces: IntArray
    deviation_mm: Array
    gaussian_curvature_per_mm2: Array
    drill_radius_mm: Array | None

    def document(self) -> dict[str, Any]:
        """As it is stored."""
        return {
            "radius_mm": self.radius_mm,
            "com_mm": list(self.com_mm),
            "pose": [list(axis) for axis in self.pose],
            "positions_mm": packed(self.positions_mm),
            "normals": packed(self.normals),
            "faces": packed_integers(self.faces),
            "deviation_mm": packed(self.deviation_mm),
            "gaussian_curvature_per_mm2": packed(self.gaussian_curvature_per_mm2),
            "drill_radius_mm": None if self.drill_radius_mm is None else packed(self.drill_radius_mm),
        }

    @classmethod
    def of_document(cls, document: Mapping[str, Any]) -> Self:
        """Read what is stored.

        Raises:
            InspectionError: If an array is damaged.
        """
        drill = document["drill_radius_mm"]
        soft, stiff, up = (as_vector(np.array(axis)) for axis in document["pose"])
        return cls(
            radius_mm=float(document["radius_mm"]),
            com_mm=as_vector(np.array(document["com_mm"])),
            pose=(soft, stiff, up),
            positions_mm=unpacked(document["positions_mm"]),
            normals=unpacked(document["normals"]),
            faces=unpacked_integers(document["faces"]),
            deviation_mm=unpacked(document["deviation_mm"]),
            gaussian_curvature_per_mm2=unpacked(document["gaussian_curvature_per_mm2"]),
            drill_radius_mm=None if drill is None else unpacked(drill),
        )


def surface_fields(
    body: Body, com_mm: Sequence[float] | Array, rest: Rest, level: int = _LEVEL
) -> SurfaceFields:
    """Evaluate the fields on a subdivided icosahedron.

    Args:
        body: The body.
        com_mm: Centre of mass of the finished part, shape (3,).
        rest: The rest about it.
        level: How often the icosahedron is subdivided, at least 3; 5 gives 10,242 corners.
    """
    directions, faces = geodesic_triangulation(level)
    center = np.asarray(com_mm, dtype=float)
    points = body.surface(directions)
    return SurfaceFields(
        radius_mm=body.radius_mm,
        com_mm=as_vector(center),
        pose=pose_of(rest),
        positions_mm=points.position_mm,
        normals=points.normal,
        faces=faces,
        deviation_mm=body.radius_at(directions) - body.radius_mm,
        gaussian_curvature_per_mm2=points.principal_curvatures_per_mm().prod(axis=1),
        drill_radius_mm=_drill_radius_mm(body, center, level),
    )


def pose_of(rest: Rest) -> tuple[Vector, Vector, Vector]:
    """The soft direction, the stiff one and up at rest, as the rows of a rotation."""
    soft, up = np.array(rest.soft_direction), -np.array(rest.direction)
    return as_vector(soft), as_vector(np.cross(up, soft)), as_vector(up)


def _drill_radius_mm(body: Body, center: Array, level: int) -> Array | None:
    """The safe radius at the vertices of a level; None if it is unknown, as on a dented body.

    How much less than |∇h| the rim of a hole allows is found on a coarse level, which takes most of the time,
    and on the finer ones the smaller share of two neighbours holds between them: it is between 0.9 and 1.
    """
    try:
        share = _first_order_share(body, center)
    except NotConvexError:
        return None
    for coarse in range(_DRILL_LEVEL, level):
        share = np.concatenate([share, share[_halved_edges(coarse)].min(axis=1)])
    result: Array = share * _gradient_mm(body, center, geodesic_triangulation(level)[0])
    return result


def _first_order_share(body: Body, center: Array) -> Array:
    directions = geodesic_triangulation(_DRILL_LEVEL)[0]
    gradient = _gradient_mm(body, center, directions)
    safe = safe_radius_mm(body, directions, center)
    return np.divide(safe, gradient, where=gradient > 0.0, out=np.ones(len(directions)))


def _gradient_mm(body: Body, center: Array, directions: Array) -> Array:
    gradient = support_about(body.surface(directions), center)[1]
    result: Array = np.linalg.norm(gradient, axis=1)
    return result


def _halved_edges(level: int) -> IntArray:
    """The edge of a level in whose middle each new vertex of the next one lies, shape (k, 2)."""
    corners, triangles = geodesic_triangulation(level)
    finer, children = geodesic_triangulation(level + 1)
    ends = np.empty((len(finer) - len(corners), 2), dtype=np.int64)
    # The last of four children connects the middles of the three edges.
    middles = children[3::4] - len(corners)
    for k in range(3):
        ends[middles[:, k]] = triangles[:, [k, (k + 1) % 3]]
    return ends
