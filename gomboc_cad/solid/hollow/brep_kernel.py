"""Hollow bodies as B-rep solids: the OCCT kernel's side of the twin."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from build123d import CenterOf, Compound, Shape, Solid
from numpy.typing import NDArray
from OCP.BRepAlgoAPI import (
    BRepAlgoAPI_Cut,
    BRepAlgoAPI_Fuse,
    BRepAlgoAPI_Splitter,
)
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeSolid, BRepBuilderAPI_Transform
from OCP.gp import gp_Dir, gp_Pln, gp_Pnt, gp_Trsf, gp_Vec
from OCP.TopoDS import TopoDS, TopoDS_Shape

from gomboc_cad.body.mass import MassProperties
from gomboc_cad.body.sphere import Array
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.hollow.brep_tools import (
    boolean,
    checked,
    is_inside,
    only_one,
    single_solid,
    smooth_edges,
    solids_of,
    tool_shape,
)
from gomboc_cad.solid.hollow.description import HollowBody
from gomboc_cad.solid.hollow.seam import Seam
from gomboc_cad.solid.hollow.tools import Tool
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.patches import body_solid, inset_solid

_TURN_RAD = 1.0
"""Turns the seam lines of cylinders out of the planes of the axes, in which patches meet."""

_TRIALS = 3


def brep(hollow: HollowBody) -> Solid:
    """Make the one solid that a hollow body is.

    The cavity with its bosses and enclosed holes is made first, away from the outer surface, and then put
    into it as reversed shells, which needs no boolean operation. Only openings, and holes that reach the
    outside, are cut.

    Raises:
        GeometryError: If a boss stands free in the cavity, a hole cuts the body into pieces, or OCCT leaves
            a boss or an opening out or finds the result faulty.
    """
    shift = gp_Trsf()
    shift.SetTranslation(gp_Vec(*hollow.core_shift_mm))
    maker = BRepBuilderAPI_MakeSolid(body_solid(hollow.body).shell().wrapped)
    for void in _core_voids(hollow.core):
        moved = BRepBuilderAPI_Transform(void.shell().wrapped, shift, True).Shape()
        maker.Add(TopoDS.Shell_s(moved.Reversed()))
    whole: TopoDS_Shape = maker.Solid()
    if not hollow.open_cuts:
        return single_solid(whole, "The hollow body")
    return _drilled(whole, hollow)


def void_properties(hollow: HollowBody) -> MassProperties:
    """Measure what the core takes away: the cavity less its bosses, and the enclosed holes.

    The core moves rigidly, so the COM is linear in `core_shift_mm` and everything else does not depend on
    it. The core is kept, so asking again, and `brep` with another shift, costs next to nothing. Holes that
    reach the outside are not counted.
    """
    mass = _core_mass(hollow.core)
    x, y, z = (a + b for a, b in zip(mass.com_mm, hollow.core_shift_mm, strict=True))
    return replace(mass, com_mm=(x, y, z))


def split_brep(solid: Solid, seam: Seam) -> tuple[Solid, Solid]:
    """Cut a solid along a seam.

    Args:
        solid: The solid.
        seam: The seam.

    Returns:
        The part below the plane, against its normal, and the part above it.

    Raises:
        GeometryError: If the plane misses the solid, a side falls into several pieces, or OCCT finds a part
            faulty.
    """
    size_mm = solid.bounding_box(optimal=False).diagonal
    lower, upper = _sides(solid, seam, size_mm) if seam.is_flat else _stepped_sides(solid, seam, size_mm)
    if len(lower) != 1 or len(upper) != 1:
        raise GeometryError(
            f"The seam must cut the solid into two parts, one on each side, but leaves {len(lower)} below "
            f"and {len(upper)} above; move the plane, or the bosses and holes that it meets."
        )
    return checked(lower[0], "The lower part"), checked(upper[0], "The upper part")


def _sides(solid: Solid, seam: Seam, size_mm: float) -> tuple[list[Solid], list[Solid]]:
    """Pieces below and above a flat seam."""
    plane = gp_Pln(gp_Pnt(*seam.origin_mm), gp_Dir(*seam.normal))
    reach = 2.0 * size_mm + float(np.linalg.norm(seam.origin_mm))
    face = BRepBuilderAPI_MakeFace(plane, -reach, reach, -reach, reach).Face()
    sides: tuple[list[Solid], list[Solid]] = ([], [])
    for piece in solids_of(boolean(BRepAlgoAPI_Splitter(), [solid.wrapped], [face])):
        height = np.subtract(tuple(piece.center(CenterOf.MASS)), seam.origin_mm) @ seam.up
        sides[int(height > 0.0)].append(piece)
    return sides


def _stepped_sides(solid: Solid, seam: Seam, size_mm: float) -> tuple[list[Solid], list[Solid]]:
    """Pieces of the lower and of the upper part.

    The tongue is left out of the tool that cuts the upper part, so nothing has to be joined in the plane.
    """
    below, above = (tool_shape(space) for space in seam.half_spaces(size_mm))
    if seam.tongue:
        below = boolean(BRepAlgoAPI_Cut(), [below], map(tool_shape, seam.tongue))
    groove = [above, *map(tool_shape, seam.taken_below)]
    lower = boolean(BRepAlgoAPI_Cut(), [solid.wrapped], groove)
    upper = boolean(BRepAlgoAPI_Cut(), [solid.wrapped], [below])
    return solids_of(lower), solids_of(upper)


def _drilled(shape: TopoDS_Shape, hollow: HollowBody) -> Solid:
    """Cut the openings, and again those that OCCT leaves in place.

    Where the seam line of a cylinder meets the surface it may, once in some hundred cuts, give the whole
    body and the plug beside it. With the seam line elsewhere the cut is right.
    """
    probes = _probes(hollow.open_cuts, hollow.in_wall)
    turn_rad = dict.fromkeys(hollow.open_cuts, _TURN_RAD)
    for _ in range(_TRIALS):
        cut = boolean(BRepAlgoAPI_Cut(), [shape], itertools.starmap(tool_shape, turn_rad.items()))
        pieces = solids_of(cut)
        body = max(pieces, key=lambda solid: solid.bounding_box(optimal=False).diagonal)
        inside = is_inside(body, [probe for _, probe in probes])
        left = [tool for (tool, _), still_there in zip(probes, inside, strict=True) if still_there]
        if not left:
            break
        for tool in left:
            turn_rad[tool] += _TURN_RAD
    _refuse_leftovers([body], hollow.open_cuts, hollow.in_wall)
    return only_one(pieces, "The hollow body")


@lru_cache(maxsize=4)
def _core_voids(hollow: HollowBody) -> tuple[Solid, ...]:
    """Solids that an unshifted core takes away."""
    pieces = [tool_shape(hole) for hole in hollow.holes]
    if hollow.inner is not None:
        cavity = inset_solid(hollow.inner).wrapped
        if hollow.bosses:
            cavity = boolean(BRepAlgoAPI_Cut(), [cavity], map(tool_shape, hollow.bosses))
        pieces.insert(0, cavity)
    if len(pieces) > 1:
        pieces = [boolean(BRepAlgoAPI_Fuse(), pieces[:1], pieces[1:])]
    voids = tuple(Solid(void.wrapped) for piece in pieces for void in Shape.cast(piece).solids())
    if any(len(void.shells()) != 1 for void in voids):
        raise GeometryError("A boss stands free in the cavity; lengthen it until it reaches the wall.")
    _refuse_leftovers(voids, hollow.bosses, hollow.in_cavity)
    return tuple(checked(void, "The cavity") for void in voids)


def _refuse_leftovers(
    solids: Sequence[Solid], tools: Iterable[Tool], was_material: Callable[[Array], NDArray[np.bool_]]
) -> None:
    """Refuse solids that still hold what a tool should have taken.

    Where the rim of a tool touches a surface along its whole length, OCCT may leave it out and say nothing.
    """
    probes = [probe for _, probe in _probes(tools, was_material)]
    left = np.any([is_inside(solid, probes) for solid in solids], axis=0)
    if left.any():
        x, y, z = probes[int(np.argmax(left))]
        raise GeometryError(
            f"OCCT left out the boss, hole or opening at ({x:.2f}, {y:.2f}, {z:.2f}) mm, as its rim just "
            "touches a surface; move it a little."
        )


def _probes(
    tools: Iterable[Tool], was_material: Callable[[Array], NDArray[np.bool_]]
) -> list[tuple[Tool, Array]]:
    """A point of the material inside each tool, shape (3,); tools that take none are left out."""
    result = []
    for tool in tools:
        points = tool.inside_mm()
        points = points[was_material(points)]
        result += [(tool, point) for point in points[len(points) // 2 :][:1]]
    return result


@lru_cache(maxsize=4)
def _core_mass(hollow: HollowBody) -> MassProperties:
    voids = [Solid(smooth_edges(void.wrapped)) for void in _core_voids(hollow)]
    if not voids:
        return MassProperties.from_arrays(0.0, np.zeros(3), np.zeros((3, 3)))
    return solid_mass(Compound(children=voids))
