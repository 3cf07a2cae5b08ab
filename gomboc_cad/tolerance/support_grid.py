"""Cells over the surface of the nominal body, and how all small changes act on the slopes in them.

Everything is told as a function of the surface parameter w, whose normal is v = n(w). The height of the
centre of mass (COM) over the table is the support function f. Its slope g, and the derivative of that slope
along the surface, `A = ∇²f κ`, are linear in the coefficients of the form error, in the shift of the COM, in
the shift of the upper part and, to first order, in the stretch. So for thousands of variants they are one
matrix product.

The cells are small where the slope is small, as around the rest and along the valleys, and large elsewhere.
In a cell the slope is known with two derivatives, in the principal frame of its centre and as a function of
the place projected on the tangent plane there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, BoolArray, geodesic_triangulation, unit
from gomboc_cad.equilibria.cells import CORNER_SAFETY, Cells
from gomboc_cad.equilibria.convexity import require_strictly_convex
from gomboc_cad.tolerance.harmonics import harmonic_jets, harmonic_slopes
from gomboc_cad.tolerance.surface_frames import SurfaceFrames
from gomboc_cad.tolerance.variants import Nominal, SeamPlane

SYMMETRIC = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Places of the six components of a symmetric matrix."""

_SCALE_LEVEL = 5
_START_LEVEL = 3
_LAST_LEVEL = 7
_MOST_CELLS = 9000
_EXPECTED_SLOPE, _EXPECTED_BEND, _EXPECTED_THIRD = 1.0, 40.0, 600.0
"""Perturbation that the cells are made for: its derivatives in units of the S-margin (and of R₀)."""

_CHORD_SAFETY = 1.03
"""How much longer than its chord a way across a cell may be along the surface."""

_DIFFERENCE = 2e-3
"""Step of the second differences of the slope, in units of R₀."""

_REMAINDER_SAFETY = 2.0
"""How much larger than at its corners the error of the expansion may be inside a cell."""


@dataclass(frozen=True, eq=False)
class SupportGrid:
    """Cells that cover the surface; lengths in mm.

    Attributes:
        corners: Corners of the cells as directions w, shape (m, 3, 3).
        centers: Their centres, shape (m, 3).
        position_mm: Points of the surface there, shape (m, 3).
        frame: Principal directions there as rows, shape (m, 2, 3).
        reach_mm: How far from the centre a cell extends along the surface, shape (m,).
        rate_per_mm: Bound on the change of A per mm, without perturbation, shape (m,).
        curvature_rate: The same for the curvatures, per mm², shape (m,).
        curvature_per_mm: Principal curvatures κ₁ ≥ κ₂ at the centres, shape (m, 2).
        remainder_mm: Error of the expansion of the slope in the cell, without perturbation, shape (m,).
        upper: Share of the cell in the upper part: 0, ½ where the seam passes, or 1, shape (m,).
        linear: How the rows (g₁, g₂, H₁₁, H₁₂, H₂₂) at the centres follow from the coordinates of a variant,
            float32, shape (D, 5, m); H = ∇²f is multiplied by what gives A times the reach for cells as round
            as a sphere: H₁₁ and H₁₂ by κ₁ r, H₂₂ by κ₂ r. The coordinates are those of the form error, the
            shift of the COM, the stretch, the shift of the upper part, and 1.
        second: The same for the second derivatives of the slope along the surface, g₁ and g₂ by 11, 12, 22,
            shape (m, 6, D).
        height_mm: Largest f.
        smallest_radius_mm: Smallest radius of curvature.
    """

    corners: Array
    centers: Array
    position_mm: Array
    frame: Array
    reach_mm: Array
    rate_per_mm: Array
    curvature_rate: Array
    curvature_per_mm: Array
    remainder_mm: Array
    upper: Array
    linear: NDArray[np.float32]
    second: NDArray[np.float32]
    height_mm: float
    smallest_radius_mm: float

    def __len__(self) -> int:
        """Number of cells."""
        return len(self.centers)


def support_grid(nominal: Nominal, degree: int) -> SupportGrid:
    """The cells for a nominal product and form errors up to a degree; kept for the next call.

    Raises:
        NotConvexError: If the body is not strictly convex.
    """
    return _support_grid(nominal.body, nominal.com_mm, nominal.seam, degree)


@lru_cache(maxsize=4)
def _support_grid(
    body: Body, com_mm: tuple[float, float, float], seam: SeamPlane | None, degree: int
) -> SupportGrid:
    com = np.array(com_mm)
    convexity = require_strictly_convex(body)
    cells = _adapted(body, com, _margin_scale_mm(body, com))
    points = SurfaceFrames.at(body, cells.centers, com)
    upper = np.zeros(len(cells.centers))
    if seam is not None:
        above = (points.position - np.array(seam.origin_mm)) @ np.array(seam.normal)
        upper = np.where(np.abs(above) <= 2.0 * cells.reach_mm, 0.5, (above > 0.0).astype(float))
    linear = linear_jets(points, upper, degree)
    second = _second(body, com, points, upper, degree)
    kappa, reach = points.principal, cells.reach_mm
    remainder = _remainder(body, com, cells, points, linear[-1], second[:, :, -1])
    linear[:, 2:] *= np.stack([kappa[:, 0] * reach, kappa[:, 0] * reach, kappa[:, 1] * reach])
    return SupportGrid(
        corners=cells.corners,
        centers=cells.centers,
        position_mm=points.position,
        frame=points.frame,
        reach_mm=reach,
        rate_per_mm=cells.rate,
        curvature_rate=cells.curvature_rate,
        curvature_per_mm=kappa,
        remainder_mm=remainder,
        upper=upper,
        linear=linear.astype(np.float32),
        second=second.astype(np.float32),
        height_mm=float(points.height.max()),
        smallest_radius_mm=convexity.min_radius_of_curvature_mm,
    )


def linear_jets(points: SurfaceFrames, upper: Array, degree: int) -> Array:
    """Slope and Hessian at places for each coordinate of a variant, shape (D, 5, n).

    Args:
        points: The places.
        upper: Share of each in the displaced upper part, shape (n,).
        degree: Highest degree of the form error.
    """
    frame, normals = points.frame, points.normal
    base, shift = points.jet(), _translation(frame, normals)
    form = harmonic_jets(normals, frame, degree)[1:].transpose(1, 0, 2)
    stretch = _stretching(frame, normals, points.height, base)
    return np.concatenate([form, -shift, stretch, upper * shift, base[None]])


def _slope_vectors(points: SurfaceFrames, upper: Array, degree: int) -> Array:
    """Slope as a vector in space for each coordinate of a variant, shape (D, 3, m).

    A part along the normal does not matter.
    """
    normals = points.normal.T
    slope = np.einsum("ma,max->xm", points.slope, points.frame)
    shift = np.broadcast_to(np.eye(3)[:, :, None], (3, 3, normals.shape[1]))
    stretch = np.empty((6, 3, normals.shape[1]))
    for row, mu in zip(stretch, _units(), strict=True):
        image = mu @ normals
        row[:] = -points.height * image - 0.5 * (image * normals).sum(axis=0) * slope
    form = harmonic_slopes(points.normal, degree)
    return np.concatenate([form, -shift, stretch, upper * shift, slope[None]])


def _second(body: Body, com: Array, points: SurfaceFrames, upper: Array, degree: int) -> Array:
    """Second derivatives of the slope in the tangent plane of each centre by differences, shape (m, 6, D)."""
    step = _DIFFERENCE * body.radius_mm

    def slopes(one: float, two: float) -> Array:
        target = step * np.array([one, two])
        place = SurfaceFrames.at(body, _at_offset(body, points, target), com)
        vectors = _slope_vectors(place, upper, degree)
        vectors -= (vectors * place.normal.T).sum(axis=1)[:, None] * place.normal.T
        result: Array = np.einsum("max,dxm->mad", points.frame, vectors)
        return result

    here = slopes(0.0, 0.0)
    first = slopes(1.0, 0.0), slopes(-1.0, 0.0)
    second = slopes(0.0, 1.0), slopes(0.0, -1.0)
    both = slopes(1.0, 1.0) + slopes(-1.0, -1.0)
    d11, d22 = (one + other - 2.0 * here for one, other in (first, second))
    d12 = 0.5 * (both - 2.0 * here - d11 - d22)
    stacked = np.stack([d11, d12, d22], axis=2) / step**2
    return stacked.reshape(len(here), 6, -1)


def _at_offset(body: Body, points: SurfaceFrames, offset_mm: Array) -> Array:
    """Directions w of the places whose projection on the tangent planes is off the centre by (2,)."""
    wanted = np.einsum("a,max->mx", offset_mm, points.frame)
    target = points.position + wanted
    for _ in range(4):
        place = body.position_mm(unit(target))
        missing = wanted - (place - points.position)
        missing -= np.einsum("mx,mx->m", missing, points.normal)[:, None] * points.normal
        target = place + missing
    return unit(target)


def _remainder(
    body: Body, com: Array, cells: _AdaptedCells, points: SurfaceFrames, linear: Array, second: Array
) -> Array:
    """Error of the expansion of the nominal slope, told from the corners, shape (m,)."""
    count = len(points.position)
    corners = SurfaceFrames.at(body, cells.corners.reshape(-1, 3), com)
    vectors = np.einsum("na,nax->nx", corners.slope, corners.frame).reshape(count, 3, 3)
    true = np.einsum("max,mkx->mka", points.frame, vectors)
    offset = corners.position.reshape(count, 3, 3) - points.position[:, None]
    x = np.einsum("max,mkx->mka", points.frame, offset)
    hessian = np.stack([linear[[2, 3]], linear[[3, 4]]])
    rate = hessian.transpose(2, 0, 1) * points.principal[:, None, :]
    squares = np.stack([0.5 * x[..., 0] ** 2, x[..., 0] * x[..., 1], 0.5 * x[..., 1] ** 2], axis=-1)
    told = points.slope[:, None] + np.einsum("mab,mkb->mka", rate, x)
    told += np.einsum("mat,mkt->mka", second.reshape(count, 2, 3), squares)
    result: Array = _REMAINDER_SAFETY * np.linalg.norm(told - true, axis=2).max(axis=1)
    return result


def _units() -> Sequence[Array]:
    """Symmetric matrices with one component 1."""
    result = []
    for i, j in SYMMETRIC:
        matrix = np.zeros((3, 3))
        matrix[i, j] = matrix[j, i] = 1.0
        result.append(matrix)
    return result


def _translation(frame: Array, normals: Array) -> Array:
    """Slope and Hessian of v_x, v_y and v_z, shape (3, 5, m)."""
    one, two, v = frame[:, 0].T, frame[:, 1].T, normals.T
    return np.stack([one, two, -v, np.zeros_like(v), -v], axis=1)


def _stretching(frame: Array, normals: Array, height: Array, base: Array) -> Array:
    """Slope and Hessian of `−½ f₀ vᵀ μ v` for each component of the symmetric μ, shape (6, 5, m)."""
    columns = []
    for mu in _units():
        image = normals @ mu
        q = np.einsum("mx,mx->m", image, normals)
        dq = 2.0 * np.einsum("max,mx->am", frame, image)
        bend = 2.0 * np.einsum("max,xy,mby->abm", frame, mu, frame)
        g = base[:2]
        columns.append(
            np.stack(
                [
                    height * dq[0] + q * g[0],
                    height * dq[1] + q * g[1],
                    height * (bend[0, 0] - 2.0 * q) + 2.0 * g[0] * dq[0] + q * base[2],
                    height * bend[0, 1] + g[0] * dq[1] + g[1] * dq[0] + q * base[3],
                    height * (bend[1, 1] - 2.0 * q) + 2.0 * g[1] * dq[1] + q * base[4],
                ]
            )
        )
    result: Array = -0.5 * np.stack(columns)
    return result


@dataclass(frozen=True, eq=False)
class _AdaptedCells:
    """Cells of all sizes."""

    corners: Array
    centers: Array
    reach_mm: Array
    rate: Array
    curvature_rate: Array

    def chosen(self, rows: BoolArray) -> _AdaptedCells:
        return _AdaptedCells(
            self.corners[rows],
            self.centers[rows],
            self.reach_mm[rows],
            self.rate[rows],
            self.curvature_rate[rows],
        )


def _margin_scale_mm(body: Body, com: Array) -> float:
    """Roughly the S-margin: distance to the focal surface from the bottom of the valleys near grid points."""
    points = SurfaceFrames.at(body, geodesic_triangulation(_SCALE_LEVEL)[0], com)
    rate = 1.0 - points.height[:, None] * points.principal
    radius = float(np.max(np.linalg.norm(points.position, axis=1)))
    across = np.maximum(np.abs(points.slope[:, 1]) - np.abs(rate[:, 1]) * radius * 2.0**-_SCALE_LEVEL, 0.0)
    softest = 1.0 / points.principal[:, 0] - points.height
    return float(np.sqrt(points.slope[:, 0] ** 2 + across**2 + softest**2).min())


def _adapted(body: Body, com: Array, margin_mm: float) -> _AdaptedCells:
    """Split cells until an expected perturbation makes no rest in them, they are small, or they are many."""
    cells = Cells.covering_sphere(_START_LEVEL)
    kept: list[_AdaptedCells] = []
    count = 0
    for level in range(_START_LEVEL, _LAST_LEVEL + 1):
        measured, points = _measured(body, cells, com)
        open_cells = _may_rest(measured, points, margin_mm)
        if level == _LAST_LEVEL or count + len(cells) + 3 * int(open_cells.sum()) > _MOST_CELLS:
            open_cells[:] = False
        kept.append(measured.chosen(~open_cells))
        count += int((~open_cells).sum())
        if not open_cells.any():
            break
        cells = cells.subdivided(open_cells)
    names = ("corners", "centers", "reach_mm", "rate", "curvature_rate")
    return _AdaptedCells(*(np.concatenate([getattr(part, name) for part in kept]) for name in names))


def _measured(body: Body, cells: Cells, com: Array) -> tuple[_AdaptedCells, SurfaceFrames]:
    """Reach of cells and how fast A and the curvature change in them, from the corners.

    The forms of the corners are compared in the tangent plane of the centre: that the normal turns on the way
    is no change.
    """
    corners = cells.vertices[cells.triangles]
    centers = cells.centers()
    middle = SurfaceFrames.at(body, centers, com)
    used, places = np.unique(cells.triangles, return_inverse=True)
    around = SurfaceFrames.at(body, cells.vertices[used], com)
    chords = np.linalg.norm(around.position[places] - middle.position[:, None], axis=2)
    rates = []
    for at_corners, at_center in zip(around.forms(), middle.forms(), strict=True):
        change = at_corners[places] - at_center[:, None]
        tangential = np.einsum("max,mkxy,mby->mkab", middle.frame, change, middle.frame)
        rate = np.linalg.norm(tangential, axis=(2, 3)) / chords
        rates.append(CORNER_SAFETY * rate.max(axis=1))
    reach = _CHORD_SAFETY * chords.max(axis=1)
    return _AdaptedCells(corners, centers, reach, *rates), middle


def _may_rest(cells: _AdaptedCells, points: SurfaceFrames, margin_mm: float) -> BoolArray:
    """Which cells may hold a rest of a body with the perturbation that the cells are made for."""
    kappa = points.principal[:, 0]
    bend = _EXPECTED_BEND * margin_mm * kappa
    rate = cells.rate + _EXPECTED_BEND * margin_mm * cells.curvature_rate
    rate += _EXPECTED_THIRD * margin_mm * kappa**2
    change = rate * cells.reach_mm
    diagonal = 1.0 - points.height[:, None] * points.principal
    slope = np.abs(points.slope) - _EXPECTED_SLOPE * margin_mm
    reach = (np.abs(diagonal) + (bend + 0.5 * change)[:, None]) * cells.reach_mm[:, None]
    falls = np.any(slope > reach, axis=1)
    topples = diagonal.min(axis=1) + bend + change < 0.0
    result: BoolArray = ~(falls | topples)
    return result
