"""The drill map: how large a hole or flat may be at each place before the body rests on it.

A hole or flat whose middle is the surface point with outward normal n adds a piece of flat or nearly flat
hull. It is a new rest when the foot of the perpendicular from the COM falls inside it, and the foot is
`|∇h(n)|` away from the middle, h being the support function about the COM.

* Hole of radius a, drilled along n: the hull over it is that of its rim. To second order in a that piece is
  straight along the direction of the larger radius of curvature ρ₂ and has the curvature `k = 1/ρ₁ − 1/ρ₂`
  across. So it is a rest when `g₂² + (g₁ / (1 − h k))² < a²` and the bracket is positive, g₁ and g₂ being the
  components of ∇h along the directions of ρ₁ and ρ₂. `|∇h|` is the limit for equal radii and below it
  otherwise. A rim so wide that the change of curvature across it counts is not described by that, so
  every limit is checked on the true rim and lowered where the hull of the rim says so.
* Flat, cut by a plane: exactly a rest when the plane cuts the ray from the COM along n inside the body, so
  when its depth exceeds `h(n)` less the length of that ray.

The COM is that of the finished part: what is removed must be balanced or filled.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gomboc_cad.body.mass import mass_properties
from gomboc_cad.body.sphere import (
    Array,
    BoolArray,
    IntArray,
    fibonacci_directions,
    geodesic_triangulation,
    tangent_frame,
    unit,
)
from gomboc_cad.body.support import support_about, touching_directions
from gomboc_cad.body.surface import Body, SurfacePoints
from gomboc_cad.equilibria.convexity import as_point, require_strictly_convex
from gomboc_cad.equilibria.records import Rest, Vector, as_vector
from gomboc_cad.equilibria.rim import hole_rims_mm, ray_lengths_mm, rim_rest
from gomboc_cad.equilibria.smooth import smooth_census

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_GRID_LEVEL = 5
_STARTS = 4
_COMPASS_POINTS = 8
_FIRST_STEP, _LAST_STEP = 0.05, 1e-3
"""Of the search for the best places, in radians."""

_SAME_PLACE = 0.3
"""Angle in radians within which two tops are one: the search may stop anywhere along a level ridge."""

_SMALLEST_HOLE = 1e-5
"""Radius, in units of R₀, below which a rim is plane and needs no check."""

_CHUNK = 512
_BISECTION = 0.002
"""Relative accuracy of a radius that the rim limits."""


@dataclass(frozen=True, eq=False)
class DrillLimits:
    """What is allowed at n places of a surface.

    Attributes:
        directions: Outward normals, shape (n, 3).
        positions_mm: Surface points, shape (n, 3).
        radius_mm: `|∇h|`, or less where the rim of a hole asks for less: a hole, recess or round flat up to
            this radius adds no rest, shape (n,).
        refined_radius_mm: The same for a drilled hole alone, larger where the curvatures differ; searched
            up to half the smaller radius of curvature, shape (n,).
        flat_depth_mm: Depth up to which a plane flat adds no rest, shape (n,).
    """

    directions: Array
    positions_mm: Array
    radius_mm: Array
    refined_radius_mm: Array
    flat_depth_mm: Array

    def __len__(self) -> int:
        """Number of places."""
        return len(self.directions)


@dataclass(frozen=True, eq=False)
class DrillMap:
    """The drill map of a body about a COM.

    Attributes:
        body: The body.
        com_mm: The centre of mass of the finished part.
        rest: The lowest rest; a hole or flat right there is the rest, and adds none.
        max_radius_mm: Largest allowed radius on the whole surface.
        max_direction: Outward normal where that is.
        best: The best places, the best first, each the best within 0.3 rad.
        sites: Places spread evenly over the directions.
    """

    body: Body
    com_mm: Vector
    rest: Rest
    max_radius_mm: float
    max_direction: Vector
    best: DrillLimits
    sites: DrillLimits

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the allowed radius by the direction of the outward normal, in Mollweide's projection.

        Args:
            ax: Axes of that projection to draw on; new ones if not given.

        Returns:
            The axes.
        """
        from gomboc_cad.report.drill_figures import plot_drill_map

        return plot_drill_map(self, ax)


def drill_map(body: Body, com: Sequence[float] | Array | None = None, *, sites: int = 500) -> DrillMap:
    """Map the largest hole or flat allowed over the whole surface.

    Args:
        body: A strictly convex body.
        com: Centre of mass in mm, shape (3,); the homogeneous centroid if not given.
        sites: Number of places in the table.

    Raises:
        NotConvexError: If the body is not strictly convex.
        DegenerateEquilibriaError: If the equilibria about the COM are not isolated.
        CensusError: If the COM is not a finite point inside the body.
    """
    center = np.array(mass_properties(body).com_mm) if com is None else as_point(com)
    rest = smooth_census(body, center, margins=False).rest
    spread = drill_limits(body, fibonacci_directions(sites), center)
    best = _limits(body, body.surface(_best_places(body, center, spread)), center)
    return DrillMap(
        body=body,
        com_mm=as_vector(center),
        rest=rest,
        max_radius_mm=float(best.radius_mm[0]),
        max_direction=as_vector(best.directions[0]),
        best=best,
        sites=spread,
    )


def drill_limits(body: Body, normals: Array, com: Sequence[float] | Array) -> DrillLimits:
    """Limits at the places with outward unit normals (n, 3), about a COM in mm.

    Raises:
        NotConvexError: If the body is not strictly convex.
        CensusError: If the COM is not three finite numbers.
    """
    center = as_point(com)
    require_strictly_convex(body)
    return _limits(body, body.surface(touching_directions(body, normals)), center)


def safe_radius_mm(body: Body, directions: Array, com: Sequence[float] | Array) -> Array:
    """The safe radius alone, at the places in directions (n, 3) from the origin, shape (n,).

    Raises:
        NotConvexError: If the body is not strictly convex.
        CensusError: If the COM is not three finite numbers.
    """
    center = as_point(com)
    require_strictly_convex(body)
    return _safe_radii_mm(body, body.surface(directions), center)


def _limits(body: Body, points: SurfacePoints, center: Array) -> DrillLimits:
    height, gradient, _ = support_about(points, center)
    shortest = 0.5 / points.principal_curvatures_per_mm()[:, 0]
    safe = _safe_radii_mm(body, points, center)
    hole = np.minimum(_second_order_mm(points, height, gradient), np.maximum(shortest, safe))
    return DrillLimits(
        directions=points.normal,
        positions_mm=points.position_mm,
        radius_mm=safe,
        refined_radius_mm=_checked_radii_mm(body, points, center, safe, hole),
        flat_depth_mm=height - ray_lengths_mm(body, center, points.normal),
    )


def _safe_radii_mm(body: Body, points: SurfacePoints, center: Array) -> Array:
    """`|∇h|`, or less where the rim of a hole asks for less, shape (n,)."""
    foot = np.linalg.norm(support_about(points, center)[1], axis=1)
    return _checked_radii_mm(body, points, center, np.zeros(len(foot)), foot)


def _second_order_mm(points: SurfacePoints, height: Array, gradient: Array) -> Array:
    """Smallest hole that is a rest, to second order; infinite where there is none, shape (n,)."""
    curvature = points.principal_curvatures_per_mm()
    in_space = np.einsum("na,nax->nx", gradient, points.tangents)
    across, along = np.abs(np.einsum("nix,nx->in", points.principal_directions(), in_space))
    bracket = 1.0 - height * (curvature[:, 0] - curvature[:, 1])
    stretched = np.divide(across, bracket, where=bracket > 0.0, out=np.full(len(across), np.inf))
    result: Array = np.hypot(along, stretched)
    return result


def _checked_radii_mm(
    body: Body, points: SurfacePoints, center: Array, harmless_mm: Array, wanted_mm: Array
) -> Array:
    """Radii as near to the wanted ones as the true rims allow, by bisection from harmless ones, (n,)."""
    low, high = harmless_mm.copy(), wanted_mm.copy()
    # Just short of the limit, at which the foot is on the rim itself.
    harmful = _adds_rest(body, points, center, (1.0 - _BISECTION) * high, np.arange(len(high)))
    low[~harmful] = high[~harmful]
    while len(open_rows := np.flatnonzero(high - low > _BISECTION * high)):
        middle = 0.5 * (low[open_rows] + high[open_rows])
        harmful = _adds_rest(body, points, center, middle, open_rows)
        high[open_rows[harmful]] = middle[harmful]
        low[open_rows[~harmful]] = middle[~harmful]
    return low


def _adds_rest(
    body: Body, points: SurfacePoints, center: Array, radii_mm: Array, rows: IntArray
) -> BoolArray:
    """Whether holes of the radii, drilled at some of the places, have a rest inside their rims."""
    result = np.zeros(len(rows), dtype=bool)
    large = np.flatnonzero(radii_mm > _SMALLEST_HOLE * body.radius_mm)
    for part in np.array_split(large, 1 + len(large) // _CHUNK):
        holes = points.position_mm[rows[part]], points.normal[rows[part]], radii_mm[part]
        result[part] = [rim_rest(rim, center) is not None for rim in hole_rims_mm(body, *holes)]
    return result


def _best_places(body: Body, center: Array, sites: DrillLimits) -> Array:
    """Surface parameters at which the safe radius has its highest maxima, the largest first, shape (k, 3)."""

    def foot(directions: Array) -> Array:
        result: Array = np.linalg.norm(support_about(body.surface(directions), center)[1], axis=1)
        return result

    def safe(directions: Array) -> Array:
        return _safe_radii_mm(body, body.surface(directions), center)

    vertices, triangles = geodesic_triangulation(_GRID_LEVEL)
    widest = unit(sites.positions_mm[np.argsort(-sites.radius_mm, kind="stable")[:_STARTS]])
    starts = np.concatenate([vertices[_peaks(foot(vertices), triangles)], widest])
    starts = starts[np.argsort(-foot(starts), kind="stable")[: 2 * _STARTS]]
    places, radii = _climbed(safe, starts)
    places = places[np.argsort(-radii, kind="stable")]
    apart = [i for i in range(len(places)) if np.all(places[:i] @ places[i] < np.cos(_SAME_PLACE))]
    return places[apart]


def _peaks(values: Array, triangles: IntArray) -> BoolArray:
    """Whether no neighbour of a vertex of a triangulation has a higher value."""
    highest_around = values.copy()
    for turn in range(3):
        np.maximum.at(highest_around, triangles[:, turn], values[triangles].max(axis=1))
    result: BoolArray = highest_around <= values
    return result


def _climbed(function: Callable[[Array], Array], starts: Array) -> tuple[Array, Array]:
    """Climb on the sphere by a compass search from starts (n, 3), which may have kinks in its way.

    Returns:
        The tops (n, 3) and the values there (n,).
    """
    u, best = starts.copy(), function(starts)
    angle = 2.0 * np.pi * np.arange(_COMPASS_POINTS) / _COMPASS_POINTS
    step = np.full(len(u), _FIRST_STEP)
    while np.any(step > _LAST_STEP):
        # Turned each time, because along a ridge few directions lead up.
        angle = angle + 1.0
        compass = np.stack([np.cos(angle), np.sin(angle)], axis=-1) @ np.stack(tangent_frame(u), axis=1)
        trial = unit(u[:, None] + step[:, None, None] * compass)
        values = function(trial.reshape(-1, 3)).reshape(len(u), -1)
        rows, pick = np.arange(len(u)), values.argmax(axis=1)
        better = values[rows, pick] > best
        u[better], best[better] = trial[rows, pick][better], values[rows, pick][better]
        step[~better] *= 0.5
    return u, best
