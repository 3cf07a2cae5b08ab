"""Every critical point of the distance from the COM, found by exclusion and not by a lucky grid.

For a strictly convex body the equilibria are the critical points of `d(u) = |x(u) − c|²/2`. The sphere
is covered by triangular cells; a cell is dropped when the gradient at its centre is too large to
vanish inside it, given how much the Hessian changes over the cell; it is handed to Newton when the
Hessian cannot become singular in it, so that it holds one critical point at most; every other cell
is split. Valleys of any width are found this way, because the test is about sizes and not about
local minima on a grid.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray, unit
from gomboc_cad.body.surface import Body, RadialJet
from gomboc_cad.equilibria.cells import CORNER_SAFETY, Cells
from gomboc_cad.errors import DegenerateEquilibriaError

_START_LEVEL = 4
_MAX_CELLS = 250_000
_SMALLEST_RADIUS = 1e-8
_NEWTON_STEPS = 50
_SAME_POINT = 1e-6


class DistanceJet(NamedTuple):
    """Gradient (n, 2) and Hessian (n, 2, 2) of d in units of R₀², with the tangent frame (n, 2, 3)."""

    gradient: Array
    hessian: Array
    frame: Array


def distance_jet(body: Body, directions: Array, center_mm: Array) -> DistanceJet:
    """Covariant derivatives of `d(u) = |x(u) − c|²/2 / R₀²` on the sphere of directions u."""
    return _about(body, body.radial_jet(directions), directions, center_mm)


def _about(body: Body, jet: RadialJet, directions: Array, center_mm: Array) -> DistanceJet:
    """`distance_jet` from the radius, which does not depend on the COM."""
    scale = 1.0 / body.radius_mm
    r, v, bend = jet.radius_mm * scale, jet.gradient_mm * scale, jet.hessian_mm * scale
    c = center_mm * scale
    along = directions @ c
    across = jet.frame @ c
    gradient = (r - along)[:, None] * v - r[:, None] * across
    mixed = v[:, :, None] * across[:, None, :]
    hessian = (
        v[:, :, None] * v[:, None, :] + (r - along)[:, None, None] * bend - mixed - mixed.transpose(0, 2, 1)
    )
    hessian[:, [0, 1], [0, 1]] += (r * along)[:, None]
    return DistanceJet(gradient, hessian, jet.frame)


def critical_directions(body: Body, center_mm: Array) -> Array:
    """Find all directions u at which the distance from the COM is stationary, shape (k, 3).

    Raises:
        DegenerateEquilibriaError: If they are not isolated at the finest resolution.
    """
    cells = Cells.covering_sphere(_START_LEVEL)
    at_corners, at_centers = _first_jets(body)
    corner_hessians = _hessian_in_space(_about(body, at_corners, cells.vertices, center_mm))
    middle = _about(body, at_centers, cells.centers(), center_mm)
    found = np.empty((0, 3))
    visited = 0
    while True:
        visited += len(cells)
        radii = cells.radii()
        excluded, regular = _classify(cells, corner_hessians, middle)
        found = np.concatenate([found, _newton(body, cells.centers()[regular], radii[regular], center_mm)])
        rest = ~(excluded | regular)
        hopeless = visited + 4 * int(rest.sum()) > _MAX_CELLS or np.any(radii[rest] < _SMALLEST_RADIUS)
        # On a sphere about its centre rounding may leave nothing at all, though every place is critical.
        if hopeless or not (rest.any() or len(found)):
            raise DegenerateEquilibriaError(
                f"The equilibria of {body.name!r} about this centre of mass are not isolated, as on a sphere "
                "or a body of revolution, or too close together to be counted; move the centre of mass or "
                "change the shape."
            )
        if not rest.any():
            return _distinct(found)
        known = len(cells.vertices)
        cells = cells.subdivided(rest)
        fresh = _hessian_in_space(distance_jet(body, cells.vertices[known:], center_mm))
        corner_hessians = np.concatenate([corner_hessians, fresh])
        middle = distance_jet(body, cells.centers(), center_mm)


@lru_cache(maxsize=4)
def _first_jets(body: Body) -> tuple[RadialJet, RadialJet]:
    """The radius at corners and centres of the first cells; kept, since a body is asked about many COMs."""
    cells = Cells.covering_sphere(_START_LEVEL)
    return body.radial_jet(cells.vertices), body.radial_jet(cells.centers())


def _hessian_in_space(jet: DistanceJet) -> Array:
    """The Hessians as forms in space, shape (n, 3, 3), where those of different places compare."""
    result: Array = jet.frame.transpose(0, 2, 1) @ jet.hessian @ jet.frame
    return result


def _classify(cells: Cells, corner_hessians: Array, jet: DistanceJet) -> tuple[BoolArray, BoolArray]:
    """Say of each cell whether it holds no critical point, and whether it holds one at most.

    Args:
        cells: The cells.
        corner_hessians: Hessians at their corners as forms in space.
        jet: Derivatives at their centres.
    """
    difference = corner_hessians[cells.triangles] - _hessian_in_space(jet)[:, None]
    change = CORNER_SAFETY * np.linalg.norm(difference, axis=(2, 3)).max(axis=1)
    values, basis = np.linalg.eigh(jet.hessian)
    slope = np.abs(np.einsum("nab,na->nb", basis, jet.gradient))
    reach = (np.abs(values) + 0.5 * change[:, None]) * cells.radii()[:, None]
    excluded = np.any(slope > reach, axis=1)
    regular = ~excluded & (np.abs(values).min(axis=1) > 2.0 * change)
    return excluded, regular


def _newton(body: Body, start: Array, radii: Array, center_mm: Array) -> Array:
    """Newton from cell centres; runs that leave the neighbourhood of their cell hold no zero in it."""
    u = start.copy()
    if len(u) == 0:
        return u
    size = np.full(len(u), np.inf)
    for _ in range(_NEWTON_STEPS):
        jet = distance_jet(body, u, center_mm)
        step = -np.linalg.solve(jet.hessian, jet.gradient[:, :, None])[:, :, 0]
        size = np.linalg.norm(step, axis=1)
        step *= np.minimum(1.0, 2.0 * radii / np.maximum(size, 1e-300))[:, None]
        u = unit(u + np.einsum("na,nax->nx", step, jet.frame))
        if size.max() < 1e-14:
            break
    near = np.linalg.norm(u - start, axis=1) < 4.0 * radii
    converged: Array = u[near & (size < 1e-10)]
    return converged


def _distinct(directions: Array) -> Array:
    """Keep one of each group of converged directions that are the same point."""
    kept: list[Array] = []
    for u in directions:
        if all(np.linalg.norm(u - other) > _SAME_POINT for other in kept):
            kept.append(u)
    return np.array(kept).reshape(-1, 3)
