"""B-rep of a closed surface over the sphere: six B-spline patches on a cubed sphere.

Each face of a cube carries one patch, parametrised by two angles in ±45° (the equiangular projection), so two
neighbours sample their common edge at the same directions. Quintic interpolation in both angles, with the
first and second derivatives clamped at both ends, makes the common edge the same curve in both patches and
the cross derivatives agree at every sample, which leaves the surface smooth to about 1e-4 degree.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from build123d import Shape, Solid
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeSolid, BRepBuilderAPI_Sewing
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepLib import BRepLib
from OCP.Geom import Geom_BSplineSurface
from OCP.gp import gp_Pnt
from OCP.TColgp import TColgp_Array2OfPnt
from OCP.TColStd import TColStd_Array1OfInteger, TColStd_Array1OfReal
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopoDS import TopoDS, TopoDS_Shape
from scipy.interpolate import BSpline, make_interp_spline

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, unit
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.offset import InsetSurface
from gomboc_cad.solid.spans import spline_face

if TYPE_CHECKING:
    from gomboc_cad.solid.hollow.tools import Ellipsoid

DEGREE = 5
POINTS_PER_EDGE = (17, 25, 33, 49, 65)
"""Samples along a patch edge that are tried in turn until the fit is close enough."""

_SEWING_TOLERANCE_MM = 1e-6
_POLE_DECIMALS = 10
_STENCIL = np.arange(-4, 5)
_FIRST = np.array([3, -32, 168, -672, 0, 672, -168, 32, -3]) / 840.0
_SECOND = np.array([-9, 128, -1008, 8064, -14350, 8064, -1008, 128, -9]) / 5040.0
# Each face of the cube: outward axis, then the axes of the two angles, right-handed.
_FRAMES = tuple(
    np.roll(np.eye(3), shift, axis=1)[[0, 1, 2] if sign > 0 else [0, 2, 1]] * [[sign], [1.0], [1.0]]
    for shift in range(3)
    for sign in (1.0, -1.0)
)

SurfaceFunction = Callable[[Array], Array]


@dataclass(frozen=True)
class Patch:
    """One face of the cubed sphere as a tensor-product B-spline.

    Attributes:
        frame: Outward axis of the cube's face and the axes of the two angles as rows, shape (3, 3).
        knots: Knot vector of either angle in radians, with repetitions, shape (n + DEGREE + 1,).
        poles_mm: Control points, shape (n, n, 3).
    """

    frame: Array
    knots: Array
    poles_mm: Array

    def sample(self, first: Array, second: Array) -> tuple[Array, Array]:
        """Evaluate at the grid of two arrays of angles.

        Returns:
            Directions that the angles stand for and points of the patch, both (len(first)·len(second), 3).
        """
        rows = BSpline(self.knots, np.eye(len(self.poles_mm)), DEGREE)
        points = np.einsum("ai,bj,ijx->abx", rows(first), rows(second), self.poles_mm, optimize=True)
        return _directions(self.frame, first, second), points.reshape(-1, 3)


def body_solid(body: Body, deviation_um: float | None = None) -> Solid:
    """Make the solid that a body's surface bounds.

    Args:
        body: The body.
        deviation_um: Largest distance allowed between the solid and the analytic surface; by default
            0.1 µm on a diameter of 100 mm and in proportion.

    Raises:
        GeometryError: If no fit comes that close, or the solid is not valid.
    """
    return inset_solid(InsetSurface(body), deviation_um)


def inset_solid(surface: InsetSurface, deviation_um: float | None = None) -> Solid:
    """Make the solid that an inset surface bounds; see `body_solid`."""
    return patches_solid(fit_patches(surface, deviation_um))


def fit_patches(surface: InsetSurface, deviation_um: float | None = None) -> tuple[Patch, ...]:
    """Fit six patches with as few samples as the allowed deviation asks for.

    Raises:
        GeometryError: If even the finest fit deviates more.
    """
    allowed = default_deviation_um(surface.body) if deviation_um is None else deviation_um
    for points in POINTS_PER_EDGE:
        patches = interpolate_patches(surface.position_mm, points)
        deviation = patches_deviation_um(patches, surface)
        if deviation <= allowed:
            return patches
    raise GeometryError(
        f"The surface of {surface.body.name!r} cannot be drawn to {allowed:.3g} µm: with {points} points per "
        f"patch edge it still deviates by {deviation:.3g} µm; allow more or use a smoother body."
    )


def max_deviation_um(solid: Shape, surfaces: Sequence[InsetSurface | Ellipsoid]) -> float:
    """Largest distance of a solid's B-spline faces from the analytic surfaces they stand for.

    Each face counts against the surface that it fits best. Works on any solid, also one read from a file.

    Raises:
        GeometryError: If the solid has no B-spline face.
    """
    deviations = []
    for face in solid.faces():
        spline = BRep_Tool.Surface_s(face.wrapped)
        if isinstance(spline, Geom_BSplineSurface):
            points = _sample_spline(spline)
            deviations.append(min(float(np.abs(s.signed_distance_mm(points)).max()) for s in surfaces))
    if not deviations:
        raise GeometryError("The solid has no B-spline face to compare with the analytic surface.")
    return 1e3 * max(deviations)


def default_deviation_um(body: Body) -> float:
    """Deviation allowed by default: 0.02 µm on 100 mm, in proportion to the diameter.

    Far less than any machine holds, but the equilibria depend on second derivatives, and these have to be
    close enough for the solid to inherit the census.
    """
    return 2e-4 * body.diameter_mm


def interpolate_patches(surface: SurfaceFunction, points: int) -> tuple[Patch, ...]:
    """Interpolate a surface over the sphere by six patches.

    Args:
        surface: Points (n, 3) in mm at unit vectors (n, 3), vectorised.
        points: Samples along a patch edge.
    """
    angles, knots, operator = _interpolation(points)
    patches = []
    for frame in _FRAMES:
        samples = surface(_directions(frame, angles, angles)).reshape(len(angles), len(angles), 3)
        poles = np.einsum("ia,jb,abx->ijx", operator, operator, samples, optimize=True)
        # A picometre is nothing to the shape; rounding makes shared edges equal to the last bit.
        patches.append(Patch(frame, knots, poles.round(_POLE_DECIMALS)))
    return tuple(patches)


@lru_cache(maxsize=8)
def _interpolation(points: int) -> tuple[Array, Array, Array]:
    """Sampling angles, knots, and the linear map from samples to control points.

    The derivatives at both ends are central differences of eighth order: the angle runs on beyond the
    patch's edge, where the projection is as smooth as inside.
    """
    grid = np.linspace(-0.25 * np.pi, 0.25 * np.pi, points)
    step = 0.25 * (grid[1] - grid[0])
    beyond = _STENCIL[_STENCIL != 0] * step
    angles = np.concatenate([grid, grid[0] + beyond, grid[-1] + beyond])
    count = len(angles)
    stencils = []
    for end, tail in ((0, np.arange(points, points + 8)), (points - 1, np.arange(points + 8, points + 16))):
        columns = np.insert(tail, 4, end)
        for order, weights in ((1, _FIRST / step), (2, _SECOND / step**2)):
            row = np.zeros(count)
            row[columns] = weights
            stencils.append((order, row))
    ends = (stencils[:2], stencils[2:])
    spline = make_interp_spline(grid, np.eye(count)[:points], k=DEGREE, bc_type=ends)  # type: ignore[arg-type]
    return angles, spline.t, spline.c


def _directions(frame: Array, first: Array, second: Array) -> Array:
    """Unit vectors of a grid of equiangular coordinates, shape (len(first)·len(second), 3)."""
    a, b = np.meshgrid(np.tan(first), np.tan(second), indexing="ij")
    return unit(np.stack([np.ones_like(a), a, b], axis=-1).reshape(-1, 3) @ frame)


def patches_deviation_um(patches: tuple[Patch, ...], surface: InsetSurface) -> float:
    """Largest distance of the patches from the analytic surface, sampled between the interpolated points."""
    worst = 0.0
    for patch in patches:
        angles = _between(patch.knots)
        directions, points = patch.sample(angles, angles)
        worst = max(worst, float(np.abs(surface.signed_distance_mm(points, directions)).max()))
    return 1e3 * worst


def _between(knots: Array) -> Array:
    """Angles off the interpolated ones: three in each interval, and both ends."""
    breaks = np.unique(knots)
    inside = breaks[:-1, None] + np.diff(breaks)[:, None] * np.array([0.2, 0.5, 0.8])
    return np.concatenate([breaks[[0, -1]], inside.ravel()])


def patches_solid(patches: tuple[Patch, ...]) -> Solid:
    """Sew patches to a closed shell and make it a solid, oriented outwards.

    Raises:
        GeometryError: If the patches do not close or the solid is not valid.
    """
    sewing = BRepBuilderAPI_Sewing(_SEWING_TOLERANCE_MM)
    for patch in patches:
        sewing.Add(BRepBuilderAPI_MakeFace(_spline_surface(patch), _SEWING_TOLERANCE_MM).Face())
    sewing.Perform()
    shell = sewing.SewedShape()
    if shell.ShapeType() != TopAbs_ShapeEnum.TopAbs_SHELL or sewing.NbFreeEdges() > 0:
        raise GeometryError(
            "The patches of the surface do not close; this should not happen, please report the body."
        )
    return closed_solid(shell)


def closed_solid(shell: TopoDS_Shape) -> Solid:
    """Make a valid solid of one closed shell, oriented outwards.

    Raises:
        GeometryError: If OCCT finds the solid faulty.
    """
    solid = BRepBuilderAPI_MakeSolid(TopoDS.Shell_s(shell)).Solid()
    BRepLib.OrientClosedSolid_s(solid)
    if not BRepCheck_Analyzer(solid).IsValid():
        raise GeometryError(
            "The B-rep of the surface is not valid; this should not happen, please report the body."
        )
    return Solid(solid)


def _sample_spline(spline: Geom_BSplineSurface) -> Array:
    """Points of a B-spline surface between its knots, shape (n, 3)."""
    face = spline_face(spline)
    rows = (
        BSpline(knots, np.eye(count), degree)(_between(knots))
        for knots, count, degree in zip(face.knots, face.poles_mm.shape, face.degrees, strict=False)
    )
    return np.einsum("ai,bj,ijx->abx", *rows, face.poles_mm, optimize=True).reshape(-1, 3)


def _spline_surface(patch: Patch) -> Geom_BSplineSurface:
    """Hand a patch over to OCCT."""
    rows, columns, _ = patch.poles_mm.shape
    poles = TColgp_Array2OfPnt(1, rows, 1, columns)
    for i, row in enumerate(patch.poles_mm.tolist(), start=1):
        for j, (x, y, z) in enumerate(row, start=1):
            poles.SetValue(i, j, gp_Pnt(x, y, z))
    values, counts = np.unique(patch.knots, return_counts=True)
    knots = TColStd_Array1OfReal(1, len(values))
    multiplicities = TColStd_Array1OfInteger(1, len(values))
    for i, (value, count) in enumerate(zip(values.tolist(), counts.tolist(), strict=True), start=1):
        knots.SetValue(i, value)
        multiplicities.SetValue(i, count)
    return Geom_BSplineSurface(poles, knots, knots, multiplicities, multiplicities, DEGREE, DEGREE)
