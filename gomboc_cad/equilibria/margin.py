"""The exact COM margin: distance from the centre of mass to the focal surface.

The census changes only when the COM crosses the surface of the centres of curvature `x − n/κᵢ`. About
the COM, the distance to such a centre is `sqrt(|∇h|² + λᵢ²)`, λᵢ an eigenvalue of `∇²h`. The sheet of
the larger curvature κ₁ is where a stable rest meets a saddle, the sheet of κ₂ where an unstable one does.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gomboc_cad.body.sphere import Array, geodesic_triangulation, unit
from gomboc_cad.body.surface import Body
from gomboc_cad.equilibria.cells import minimise_on_sphere
from gomboc_cad.equilibria.convexity import as_point, require_strictly_convex
from gomboc_cad.equilibria.records import Margin, as_vector

_RELATIVE_GAP = 0.005
_START_LEVEL = 4
_STARTS = 64
_STEPS = 60
_DIFFERENCE = 1e-5


def focal_points_mm(body: Body, directions: Array, sheet: int) -> Array:
    """Centres of curvature `x − n/κ` of the sheet 0 (κ₁, changes S) or 1 (κ₂, changes U), shape (n, 3)."""
    points = body.surface(directions)
    curvature = points.principal_curvatures_per_mm()[:, sheet]
    result: Array = points.position_mm - points.normal / curvature[:, None]
    return result


def com_margin(body: Body, com_mm: Sequence[float] | Array) -> Margin:
    """Find how far the COM may move before S, U or either changes, by global search and refinement.

    Args:
        body: A strictly convex body.
        com_mm: Centre of mass, shape (3,).

    Raises:
        NotConvexError: If the body is not strictly convex: its focal surface reaches infinity.
        CensusError: If the COM is not three finite numbers.
    """
    center = as_point(com_mm)
    require_strictly_convex(body)
    s_witness = _nearest_focal_point(body, center, 0)
    u_witness = _nearest_focal_point(body, center, 1)
    s_margin = float(np.linalg.norm(s_witness - center))
    u_margin = float(np.linalg.norm(u_witness - center))
    return Margin(min(s_margin, u_margin), s_margin, u_margin, as_vector(s_witness), as_vector(u_witness))


def s_margin_mm(body: Body, com_mm: Sequence[float] | Array) -> float:
    """Find how far the COM may move before S changes: the S-margin of `com_margin`, in half its time.

    Args:
        body: A strictly convex body.
        com_mm: Centre of mass, shape (3,).

    Raises:
        NotConvexError: If the body is not strictly convex.
        CensusError: If the COM is not three finite numbers.
    """
    center = as_point(com_mm)
    require_strictly_convex(body)
    return float(np.linalg.norm(_nearest_focal_point(body, center, 0) - center))


def _nearest_focal_point(body: Body, com_mm: Array, sheet: int) -> Array:
    def distance(directions: Array) -> Array:
        result: Array = np.linalg.norm(focal_points_mm(body, directions, sheet) - com_mm, axis=1)
        return result

    # A refined upper bound from the start lets the search drop most of every valley at once.
    grid = geodesic_triangulation(_START_LEVEL)[0]
    start = grid[np.argsort(distance(grid), kind="stable")[:_STARTS]]
    first = _refine(body, start, com_mm, sheet)
    best = distance(first).min()
    search = minimise_on_sphere(distance, _RELATIVE_GAP * best, upper_bound=best)
    candidates = np.concatenate([first, search.candidates, _refine(body, search.candidates, com_mm, sheet)])
    nearest: Array = focal_points_mm(body, candidates, sheet)[distance(candidates).argmin()]
    return nearest


def _refine(body: Body, directions: Array, com_mm: Array, sheet: int) -> Array:
    """Levenberg–Marquardt on the focal point, which follows narrow valleys where a grid cannot.

    The Jacobian is by central differences along the surface parameter.
    """
    u = directions.copy()
    residual = focal_points_mm(body, u, sheet) - com_mm
    cost = np.einsum("nx,nx->n", residual, residual)
    damping = np.full(len(u), 1e-3)
    for _ in range(_STEPS):
        frame = body.radial_jet(u).frame
        probes = unit(u[:, None, None] + _DIFFERENCE * np.stack([frame, -frame], axis=2))
        focal = focal_points_mm(body, probes.reshape(-1, 3), sheet).reshape(len(u), 2, 2, 3)
        jacobian = (focal[:, :, 0] - focal[:, :, 1]) / (2.0 * _DIFFERENCE)
        normal_matrix = jacobian @ jacobian.transpose(0, 2, 1)
        slope = np.einsum("nax,nx->na", jacobian, residual)
        damped = normal_matrix.copy()
        damped[:, [0, 1], [0, 1]] *= 1.0 + damping[:, None]
        damped[:, [0, 1], [0, 1]] += 1e-12 * body.radius_mm**2
        step = -np.linalg.solve(damped, slope[:, :, None])[:, :, 0]
        step *= np.minimum(1.0, 0.1 / np.maximum(np.linalg.norm(step, axis=1), 1e-300))[:, None]
        trial = unit(u + np.einsum("na,nax->nx", step, frame))
        trial_residual = focal_points_mm(body, trial, sheet) - com_mm
        trial_cost = np.einsum("nx,nx->n", trial_residual, trial_residual)
        better = trial_cost < cost
        u[better], residual[better], cost[better] = trial[better], trial_residual[better], trial_cost[better]
        damping = np.where(better, 0.3 * damping, 10.0 * damping)
        if np.all((np.linalg.norm(step, axis=1) < 1e-10) | (damping > 1e8)):
            break
    return u
