"""Tools as shapes of the OCCT kernel, and the boolean operations that use them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from build123d import Shape, Solid
from OCP.BRepAlgoAPI import BRepAlgoAPI_BooleanOperation, BRepAlgoAPI_Cut, BRepAlgoAPI_Splitter
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepLib import BRepLib
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
from OCP.GeomAbs import GeomAbs_Shape
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
from OCP.ShapeUpgrade import ShapeUpgrade_ShapeDivideContinuity
from OCP.TopAbs import TopAbs_State
from OCP.TopoDS import TopoDS_Shape
from OCP.TopTools import TopTools_ListOfShape

from gomboc_cad.body.sphere import Array
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.hollow.tools import Box, Cylinder, Ellipsoid, Tool
from gomboc_cad.solid.patches import interpolate_patches, patches_solid

_ELLIPSOID_POINTS = 17
"""Samples along a patch edge: off by 2e-9 of the largest half-length, whatever the proportions."""

_BORE_OVERRUN_MM = 1.0
_SAME_PARAMETER_TOLERANCE_MM = 1e-7
_CONTINUITY_TOLERANCE_MM = 1e-6


def tool_shape(tool: Tool, turn_rad: float = 0.0) -> TopoDS_Shape:
    """Make the solid that a tool is; a cylinder is turned about its axis, which moves its seam line only."""
    match tool:
        case Cylinder():
            full = _cylinder(tool, turn_rad)
            if tool.bore is None:
                return full
            bore = _cylinder(tool.bore.extended(_BORE_OVERRUN_MM, _BORE_OVERRUN_MM), turn_rad)
            return boolean(BRepAlgoAPI_Cut(), [full], [bore])
        case Ellipsoid():
            # Interpolation commutes with the affine map, so the error is that of the sphere, stretched.
            return patches_solid(interpolate_patches(tool.position_mm, _ELLIPSOID_POINTS)).wrapped
        case Box():
            corner = gp_Pnt(*(tool.center_mm - 0.5 * tool.frame.T @ tool.size_mm))
            axes = gp_Ax2(corner, gp_Dir(*tool.frame[2]), gp_Dir(*tool.frame[0]))
            return BRepPrimAPI_MakeBox(axes, *tool.size_mm).Shape()


def boolean(
    operation: BRepAlgoAPI_BooleanOperation | BRepAlgoAPI_Splitter,
    arguments: Sequence[TopoDS_Shape],
    tools: Iterable[TopoDS_Shape],
) -> TopoDS_Shape:
    """Run a boolean operation with all tools at once, which is faster and safer than one by one.

    Raises:
        GeometryError: If OCCT gives up.
    """
    operation.SetArguments(_shape_list(arguments))
    operation.SetTools(_shape_list(tools))
    operation.SetToFillHistory(False)
    operation.SetNonDestructive(True)
    # The result is the same, to the byte of a STEP file.
    operation.SetRunParallel(True)
    operation.Build()
    if not operation.IsDone():
        raise GeometryError(
            "OCCT could not combine the parts; move bosses and holes that just touch each other."
        )
    return operation.Shape()


def solids_of(shape: TopoDS_Shape) -> list[Solid]:
    """Give the solids of a shape, their edges smooth."""
    return list(Shape.cast(smooth_edges(shape)).solids())


def is_inside(solid: Solid, points_mm: Sequence[Array]) -> list[bool]:
    """Whether points, each of shape (3,), lie in the material of a solid."""
    classifier = BRepClass3d_SolidClassifier(solid.wrapped)
    result = []
    for point in points_mm:
        classifier.Perform(gp_Pnt(*point), _SAME_PARAMETER_TOLERANCE_MM)
        result.append(classifier.State() == TopAbs_State.TopAbs_IN)
    return result


def smooth_edges(shape: TopoDS_Shape) -> TopoDS_Shape:
    """Divide intersection curves where their pieces meet with less than two continuous derivatives.

    CAD programs integrate volumes with one Gauss rule along each edge. Across such joints it is off by up to
    1000 ppm of a thin shell; along smooth edges it is exact to 0.01 ppm.

    It works on a copy: the result of a boolean operation shares edges with what went into it, and a second
    operation on that would differ from the first.
    """
    shape = BRepBuilderAPI_Copy(shape, True, False).Shape()
    divide = ShapeUpgrade_ShapeDivideContinuity(shape)
    divide.SetTolerance(_CONTINUITY_TOLERANCE_MM)
    divide.SetBoundaryCriterion(GeomAbs_Shape.GeomAbs_C2)
    divide.SetPCurveCriterion(GeomAbs_Shape.GeomAbs_C2)
    divide.SetSurfaceCriterion(GeomAbs_Shape.GeomAbs_C2)
    if not divide.Perform():
        return shape
    result = divide.Result()
    BRepLib.SameParameter_s(result, _SAME_PARAMETER_TOLERANCE_MM, True)
    return result


def single_solid(shape: TopoDS_Shape, what: str) -> Solid:
    """Give the one valid solid that a shape has to be, its edges smooth.

    Raises:
        GeometryError: If it is none or several, or OCCT finds it faulty.
    """
    return only_one(solids_of(shape), what)


def only_one(solids: Sequence[Solid], what: str) -> Solid:
    """Give the one valid solid that there has to be.

    Raises:
        GeometryError: If there is none or several, or OCCT finds it faulty.
    """
    if len(solids) != 1:
        raise GeometryError(
            f"{what} falls into {len(solids)} pieces; check the sizes and places of the holes."
        )
    return checked(solids[0], what)


def checked(solid: Solid, what: str) -> Solid:
    """Give back a plain solid that OCCT finds valid.

    Raises:
        GeometryError: If it does not.
    """
    if not BRepCheck_Analyzer(solid.wrapped).IsValid():
        raise GeometryError(f"{what} is not a valid solid; move bosses and holes that just touch each other.")
    return Solid(solid.wrapped)


def _cylinder(cylinder: Cylinder, turn_rad: float) -> TopoDS_Shape:
    axes = gp_Ax2(gp_Pnt(*cylinder.base_mm), gp_Dir(*cylinder.direction))
    axes.Rotate(axes.Axis(), turn_rad)
    return BRepPrimAPI_MakeCylinder(axes, cylinder.radius_mm, cylinder.length_mm).Shape()


def _shape_list(shapes: Iterable[TopoDS_Shape]) -> TopTools_ListOfShape:
    result = TopTools_ListOfShape()
    for shape in shapes:
        result.Append(shape)
    return result
