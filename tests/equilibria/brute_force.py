"""Slow ways to the same answers: Newton from thousands of starts, and a grid with a simplex search."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import fibonacci_directions, tangent_frame

Array = NDArray[np.float64]


def critical_points(body: Body, com: Array, starts: int = 20_000, steps: int = 40) -> Array:
    """Newton on the surface for (x − c)_T = 0 from `starts` directions; distinct ends, shape (k, 3)."""
    u = fibonacci_directions(starts)
    length = np.full(len(u), np.inf)
    for _ in range(steps):
        points = body.surface(u)
        arm = points.position_mm - com
        slope = np.einsum("nax,nx->na", points.tangents, arm)
        height = np.einsum("nx,nx->n", points.normal, arm)
        values, axes = np.linalg.eigh(np.eye(2) - height[:, None, None] * points.shape_operator_per_mm)
        values = np.where(np.abs(values) < 1e-12, 1e-12, values)
        step = -np.einsum("nab,nb->na", axes, np.einsum("nab,na->nb", axes, slope) / values)
        length = np.linalg.norm(step, axis=1)
        step *= np.minimum(1.0, 0.05 * body.radius_mm / np.maximum(length, 1e-300))[:, None]
        x = points.position_mm + np.einsum("na,nax->nx", step, points.tangents)
        u = x / np.linalg.norm(x, axis=1, keepdims=True)
    return distinct(u[length < 1e-9 * body.radius_mm])


def distinct(directions: Array, tolerance: float = 1e-6) -> Array:
    """One of each group of nearly equal directions."""
    kept = []
    while len(directions):
        kept.append(directions[0])
        directions = directions[np.linalg.norm(directions - directions[0], axis=1) > tolerance]
    return np.array(kept)


def margins(body: Body, com: Array, grid: int = 30_000, starts: int = 12) -> tuple[float, float]:
    """Least `sqrt(|∇h|² + λ²)` for the smaller and the larger eigenvalue λ of ∇²h: S- and U-margin.

    By a dense grid and Nelder–Mead from its best places, without the centres of curvature.
    """

    def distance(u: Array, sheet: int) -> Array:
        points = body.surface(u)
        arm = points.position_mm - com
        along = np.einsum("nax,nx->na", points.tangents, arm)
        height = np.einsum("nx,nx->n", points.normal, arm)
        stiffness = np.linalg.eigvalsh(np.linalg.inv(points.shape_operator_per_mm)) - height[:, None]
        return np.sqrt(np.sum(along**2, axis=1) + stiffness[:, sheet] ** 2)

    def least(sheet: int) -> float:
        u = fibonacci_directions(grid)
        best = u[np.argsort(distance(u, sheet))]
        found = np.inf
        chosen: list[Array] = []
        for start in best:
            if len(chosen) == starts:
                break
            if any(np.linalg.norm(start - other) < 0.03 for other in chosen):
                continue
            chosen.append(start)
            first, second = (e[0] for e in tangent_frame(start[None]))

            def local(p: Array, u: Array = start, e: Array = first, f: Array = second) -> float:
                v = u + p[0] * e + p[1] * f
                return float(distance((v / np.linalg.norm(v))[None], sheet)[0])

            simplex = np.array([[0.0, 0.0], [0.02, 0.0], [0.0, 0.02]])
            options = {"initial_simplex": simplex, "xatol": 1e-8, "fatol": 1e-13, "maxiter": 400}
            found = min(found, minimize(local, np.zeros(2), method="Nelder-Mead", options=options).fun)
        return found

    return least(0), least(1)
