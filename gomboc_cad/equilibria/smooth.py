"""The smooth census: all resting positions of a strictly convex body about a centre of mass."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gomboc_cad.body.mass import mass_properties
from gomboc_cad.body.sphere import Array
from gomboc_cad.body.support import depth_mm, support_about
from gomboc_cad.body.surface import Body
from gomboc_cad.equilibria.convexity import as_point, require_strictly_convex
from gomboc_cad.equilibria.critical import critical_directions
from gomboc_cad.equilibria.heights import BodyHeights
from gomboc_cad.equilibria.margin import com_margin
from gomboc_cad.equilibria.records import Census, Equilibrium, Kind, Rest, as_vector
from gomboc_cad.errors import CensusError, DegenerateEquilibriaError

_DEGENERATE_STIFFNESS = 1e-9
"""Below this stiffness, in units of R₀, an equilibrium is not told from a neutral one."""

_FAR = 1e3
"""No body reaches so far, in units of R₀."""


def smooth_census(body: Body, com: Sequence[float] | Array | None = None, *, margins: bool = True) -> Census:
    """Count and describe every equilibrium of a strictly convex body on a flat table.

    The height of the COM over the table when direction u points down is the support function about
    the COM; its minima are the stable rests, its maxima the unstable ones. `S − H + U = 2` is asserted.

    Args:
        body: The body.
        com: Centre of mass in mm, shape (3,); the homogeneous centroid if not given.
        margins: Whether to search for the COM margins too, which takes most of the time.

    Raises:
        NotConvexError: If the body is not strictly convex; its rests are those of its hull.
        DegenerateEquilibriaError: If the equilibria are not isolated.
        CensusError: If the COM is not a finite point inside the body, or the counts contradict
            Poincaré–Hopf.
    """
    center = None if com is None else as_point(com)
    curvature = require_strictly_convex(body)
    mass = mass_properties(body)
    if center is None:
        center = np.array(mass.com_mm)
    _require_inside(body, center)
    equilibria, rest = _equilibria_and_rest(body, center)
    heights = [e.height_mm for e in equilibria]
    stable = sum(e.kind == "stable" for e in equilibria)
    return Census(
        com_mm=as_vector(center),
        equilibria=equilibria,
        height_range_mm=max(heights) - min(heights),
        rest=rest,
        verdict="monostable" if stable == 1 else "multistable",
        reason=f"The smooth body has {stable} stable equilibri{'um' if stable == 1 else 'a'}.",
        mass_properties=mass,
        convexity=curvature,
        margin=com_margin(body, center) if margins else None,
        height_at=BodyHeights(body, center),
    )


def find_equilibria(body: Body, com: Sequence[float] | Array) -> tuple[Equilibrium, ...]:
    """Find every equilibrium of a strictly convex body about a centre of mass in mm, the lowest first.

    This is the census without margins, and correspondingly quick.

    Raises:
        NotConvexError: If the body is not strictly convex.
        DegenerateEquilibriaError: If the equilibria are not isolated.
        CensusError: If the COM is not a finite point inside the body, or the counts contradict
            Poincaré–Hopf.
    """
    center = as_point(com)
    require_strictly_convex(body)
    _require_inside(body, center)
    return _equilibria_and_rest(body, center)[0]


def _equilibria_and_rest(body: Body, center: Array) -> tuple[tuple[Equilibrium, ...], Rest]:
    equilibria, rest = _describe(body, critical_directions(body, center), center)
    _assert_poincare_hopf(body, equilibria)
    return equilibria, rest


def _require_inside(body: Body, center: Array) -> None:
    if np.abs(center).max() > _FAR * body.radius_mm or depth_mm(body, center)[0] <= 0.0:
        place = ", ".join(f"{c:g}" for c in center)
        raise CensusError(f"The centre of mass ({place}) mm lies outside the body; give one inside it.")


def _describe(body: Body, directions: Array, center: Array) -> tuple[tuple[Equilibrium, ...], Rest]:
    """Type the critical points by the Hessian of the height and describe the lowest rest."""
    points = body.surface(directions)
    heights, _, hessians = support_about(points, center)
    values, vectors = np.linalg.eigh(hessians)
    if np.any(np.abs(values) < _DEGENERATE_STIFFNESS * body.radius_mm):
        raise DegenerateEquilibriaError(
            f"An equilibrium of {body.name!r} about this centre of mass is neutral, so its kind cannot be "
            "told; move the centre of mass."
        )
    order = np.argsort(heights)
    equilibria = tuple(
        Equilibrium(
            kind=_kind(values[i]),
            direction=as_vector(points.normal[i]),
            height_mm=float(heights[i]),
            stiffness_mm=(float(values[i, 0]), float(values[i, 1])),
        )
        for i in order
    )
    lowest = order[0]
    axes = vectors[lowest].T @ points.tangents[lowest]
    rest = Rest(
        direction=equilibria[0].direction,
        height_mm=equilibria[0].height_mm,
        stiffness_mm=(float(values[lowest, 0]), float(values[lowest, 1])),
        soft_direction=as_vector(axes[0]),
        stiff_direction=as_vector(axes[1]),
    )
    return equilibria, rest


def _kind(stiffness: Array) -> Kind:
    if stiffness[0] > 0.0:
        return "stable"
    return "unstable" if stiffness[1] < 0.0 else "saddle"


def _assert_poincare_hopf(body: Body, equilibria: tuple[Equilibrium, ...]) -> None:
    """Check S − H + U = 2, the Euler characteristic of the sphere."""
    total = sum(-1 if e.kind == "saddle" else 1 for e in equilibria)
    if total != 2:
        raise CensusError(
            f"The census of {body.name!r} is incomplete (S − H + U = {total}, not 2); move the centre of "
            "mass by a micrometre, and report this body."
        )
