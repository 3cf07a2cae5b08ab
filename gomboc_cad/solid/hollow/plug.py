"""Plugs that close an opening flush: their outer face is the body's own surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from build123d import Solid
from OCP.BRepAlgoAPI import BRepAlgoAPI_Common

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, IntArray, unit
from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.hollow.brep_tools import boolean, single_solid, tool_shape
from gomboc_cad.solid.hollow.tools import Cylinder, segments
from gomboc_cad.solid.mesh import Mesh, facet_sag_um
from gomboc_cad.solid.offset import InsetSurface
from gomboc_cad.solid.patches import body_solid

_FIRST_SHARE = 0.5
_SEGMENTS_PER_RING = 6
_HALVINGS = 60


def plug_brep(body: Body, cylinder: Cylinder) -> Solid:
    """Make the material of a solid body inside a cylinder as a B-rep.

    Args:
        body: The body.
        cylinder: Full cylinder with one end inside the body and the other outside.

    Raises:
        GeometryError: If the cylinder is a tube, its ends are elsewhere, or OCCT finds the plug faulty.
    """
    _from_inside(body, cylinder)
    shape = boolean(BRepAlgoAPI_Common(), [body_solid(body).wrapped], [tool_shape(cylinder)])
    return single_solid(shape, "The plug")


def plug_mesh(body: Body, cylinder: Cylinder, sag_um: float) -> Mesh:
    """Mesh the material of a solid body inside a cylinder, with all vertices on the analytic surfaces.

    Args:
        body: The body.
        cylinder: Full cylinder with one end inside the body and the other outside.
        sag_um: Largest distance allowed between the facets and the surfaces they stand for.

    Raises:
        GeometryError: If the cylinder is a tube, or its ends are elsewhere.
    """
    cylinder = _from_inside(body, cylinder)
    around = segments(cylinder.radius_mm, _FIRST_SHARE * sag_um)
    while True:
        flat_mm, disc = _disc(cylinder, around)
        cap_mm = _surface_over(body, flat_mm, cylinder)
        if facet_sag_um(Mesh(cap_mm, disc), InsetSurface(body)).max() <= sag_um:
            break
        around *= 2
    rim = len(flat_mm) - around + np.arange(around)
    ahead, over = np.roll(rim, -1), len(flat_mm)
    sides = [[rim, ahead, ahead + over], [rim, ahead + over, rim + over]]
    faces = np.concatenate([disc[:, ::-1], disc + over, *np.array(sides).transpose(0, 2, 1)])
    return Mesh(np.concatenate([flat_mm, cap_mm]), faces)


def _from_inside(body: Body, cylinder: Cylinder) -> Cylinder:
    """Turn a plug's cylinder so that its base is the end inside the body.

    Raises:
        GeometryError: If there is no such end, the other end is not outside, or the cylinder is a tube.
    """
    if cylinder.bore is not None:
        raise GeometryError("A plug is cut out with a full cylinder, not with a tube; leave its bore away.")
    base, top = _heights_mm(body, cylinder.rims_mm()).reshape(2, -1)
    if base.max() < 0.0 < top.min():
        return cylinder
    if top.max() < 0.0 < base.min():
        along = np.array(cylinder.direction)
        end = as_vector(cylinder.base_mm + cylinder.length_mm * along)
        return replace(cylinder, base_mm=end, axis=as_vector(-along))
    raise GeometryError(
        "A plug needs a cylinder with one end wholly inside the body and the other wholly outside; move or "
        f"lengthen the one of radius {cylinder.radius_mm:g} mm at {cylinder.base_mm!r}."
    )


def _disc(cylinder: Cylinder, around: int) -> tuple[Array, IntArray]:
    """Points in rings on the base of a cylinder, its centre first, and triangles that face along the axis."""
    rings = max(1, around // _SEGMENTS_PER_RING)
    center = np.array(cylinder.base_mm)
    rim = cylinder.rims_mm(around)[:around] - center
    if np.cross(rim[0], rim[1]) @ cylinder.direction < 0.0:
        rim = rim[::-1]
    shares = np.arange(1, rings + 1)[:, None, None] / rings
    points = center + np.concatenate([np.zeros((1, 3)), (shares * rim).reshape(-1, 3)])
    near = 1 + np.arange((rings - 1) * around).reshape(rings - 1, around)
    first = 1 + np.arange(around)
    far, ahead = near + around, np.roll(near, -1, axis=1)
    triangles = [
        np.stack([np.zeros_like(first), first, np.roll(first, -1)], axis=-1),
        np.stack([near, far, ahead + around], axis=-1).reshape(-1, 3),
        np.stack([near, ahead + around, ahead], axis=-1).reshape(-1, 3),
    ]
    return points, np.concatenate(triangles)


def _surface_over(body: Body, points_mm: Array, cylinder: Cylinder) -> Array:
    """Where the lines from points (n, 3) inside, along the cylinder, leave the body, found by bisection."""
    direction = np.array(cylinder.direction)
    low, high = np.zeros(len(points_mm)), np.full(len(points_mm), cylinder.length_mm)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        inside = _heights_mm(body, points_mm + middle[:, None] * direction) < 0.0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    result: Array = points_mm + low[:, None] * direction
    return result


def _heights_mm(body: Body, points_mm: Array) -> Array:
    """Height of points (n, 3) over the surface, along the radius; negative inside."""
    result: Array = np.linalg.norm(points_mm, axis=1)
    return result - np.linalg.norm(body.position_mm(unit(points_mm)), axis=1)
