"""The finished product rechecked: on what does the hull of the parts as exported come to rest?

Two questions are asked, and both must be answered with one rest:

* The hull of the parts is sampled on their true surfaces, and its rests are counted down to a barrier that
  the sampling proves. That needs no word of how the parts were meant.
* Below that barrier the product rests where its smooth body does, unless a mouth has taken the place away,
  and on a rim wherever the foot of the perpendicular from the centre of mass falls inside it. The rims are
  taken from the edges of the exported solids; each is decided exactly, however low its barrier.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import Any

import numpy as np
from build123d import Shape
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve

from gomboc_cad.body import Body, depth_mm
from gomboc_cad.body.sphere import Array, tangent_frame
from gomboc_cad.body.support import touching_directions
from gomboc_cad.equilibria import Census, find_equilibria
from gomboc_cad.equilibria.mesh import mesh_census
from gomboc_cad.equilibria.records import CensusVerdict, Vector
from gomboc_cad.equilibria.rim import RimRest, hole_rims_mm, rim_clearance_mm, rim_rest
from gomboc_cad.errors import CensusError
from gomboc_cad.products.openings.sites import PlacedOpening
from gomboc_cad.products.placement import Parting
from gomboc_cad.progress import Progress, silent
from gomboc_cad.solid.offset import InsetSurface
from gomboc_cad.solid.surface_sampling import SurfacePoints, SurfaceSampler

_SAG = 3e-4
"""Sag of the points over the size of the product; the second round, if it needs one, halves it."""

_ROUNDS = 2
_EDGE_POINTS = 96
_ON_RIM = 1e-4
"""Distance from a hole's side and from the outer surface, in units of R₀, within which an edge is its rim."""

_WIDEST_GAP_DEG = 20.0
"""A rim with a larger gap between its points, seen along its axis, is not a whole one."""


@dataclass(frozen=True)
class RimFinding:
    """What was found at one opening.

    Attributes:
        name: Name of the opening.
        state: As it was placed: `allowed`, `rest`, `plugged` or `forced`.
        on_solid: Whether its whole rim was found among the edges of the exported solids; where other parts
            cross it, the rim is that of the hole in the body.
        rest: The rest on its rim; None if there is none, or if it is plugged.
        com_clearance_mm: How far the centre of mass may move before there is one, or, at the rest itself,
            one beside it; 0 if there is one, None if it is plugged.
    """

    name: str
    state: str
    on_solid: bool
    rest: RimRest | None
    com_clearance_mm: float | None


@dataclass(frozen=True)
class Recheck:
    """The rests of the hull of the exported parts.

    Attributes:
        verdict: Whether there is one stable rest; `undecided` where the sampling does not tell.
        stable: Number of stable rests that are known.
        reasons: Sentences for it, the deciding ones first.
        barrier_mm: Rests with a lower barrier can be told on rims and on the smooth surface only.
        census: Census of the sampled hull.
        rims: What was found at the openings.
        outside_mm: How far the hull reaches out of the body's surface.
    """

    verdict: CensusVerdict
    stable: int
    reasons: tuple[str, ...]
    barrier_mm: float
    census: Census
    rims: tuple[RimFinding, ...]
    outside_mm: float


def recheck(
    solids: Mapping[str, Shape],
    com_mm: Vector,
    openings: Sequence[PlacedOpening],
    body: Body,
    parting: Parting | None = None,
    progress: Progress = silent,
) -> Recheck:
    """Count the rests of the hull of all parts of a product.

    Args:
        solids: The parts as read back from their files, in place, by name.
        com_mm: Centre of mass of the product.
        openings: What opens the outer surface, in place.
        body: The outer surface as it was meant, without a step or gap of the seam.
        parting: The seam, where it has a step or a gap.
        progress: Told about each round of the census.

    Raises:
        CensusError: If the centre of mass is outside of the hull.
        GeometryError: If OCCT cannot mesh a part.
    """
    outer = [solid for solid in solids.values() if _may_reach_hull(solid, body)]
    rims = _rims(outer, openings, body, np.array(com_mm))
    points, census = _sampled_census(outer, com_mm, progress)
    smooth = _smooth_rests(body, np.array(com_mm), openings, parting)
    on_rims = [rim for rim in rims if rim.rest is not None]
    verdict, stable, reasons = _judged(census, smooth, on_rims)
    outside = float(InsetSurface(body).signed_distance_mm(points.points_mm).max())
    assert census.mesh is not None  # it is a census of points
    return Recheck(verdict, stable, reasons, census.mesh.barrier_mm, census, rims, max(0.0, outside))


def _judged(
    census: Census, smooth: Sequence[Vector], on_rims: Sequence[RimFinding]
) -> tuple[CensusVerdict, int, tuple[str, ...]]:
    """Put the sampled census and the exact rests together."""
    exact = len(smooth) + len(on_rims)
    if exact > 1:
        extra = [rim for rim in on_rims if rim.state != "rest" or smooth]
        said = tuple(_rests_on(rim) for rim in extra) or (f"The outer surface has {len(smooth)} rests.",)
        return "multistable", max(exact, census.stable), said
    if census.verdict == "monostable":
        return "monostable", 1, (f"The hull of the exported parts was sampled: {census.reason}",)
    return census.verdict, census.stable, (f"The hull of the exported parts was sampled: {census.reason}",)


def _rests_on(rim: RimFinding) -> str:
    assert rim.rest is not None  # the caller has seen to it
    x, y, z = rim.rest.direction
    if rim.state == "rest":
        return (
            f"The product rests on the rim of {rim.name} and also beside it, on the smooth surface: the "
            "centre of mass is off by more than that rim allows; make the opening wider or move the centre "
            "of mass."
        )
    return (
        f"The product also rests on the rim of {rim.name}, with ({x:.3f}, {y:.3f}, {z:.3f}) down and a "
        f"barrier of {1e3 * rim.rest.barrier_mm:.3g} µm; move it, make it smaller or plug it."
    )


def _may_reach_hull(solid: Shape, body: Body) -> bool:
    """Whether a solid is not certainly inside the body."""
    box = solid.bounding_box(optimal=False)
    corners = np.array(list(product(*zip(tuple(box.min), tuple(box.max), strict=True))))
    return bool(np.any(depth_mm(body, corners) <= 0.0))


def _sampled_census(
    solids: Sequence[Shape], com_mm: Vector, progress: Progress
) -> tuple[SurfacePoints, Census]:
    """Census of the hull of points of the surfaces, finer where the first ones do not decide it."""
    boxes = [solid.bounding_box(optimal=False) for solid in solids]
    low, high = (np.array([tuple(getattr(box, end)) for box in boxes]) for end in ("min", "max"))
    size = float(np.linalg.norm(high.max(axis=0) - low.min(axis=0)))
    sampler = SurfaceSampler(solids, size)
    sag = _SAG * size
    for _ in range(_ROUNDS):
        progress(f"census at a sag of {1e3 * sag:.3g} µm")
        points = sampler.sample(sag)
        census = mesh_census(
            points.points_mm, points.faces, com_mm, sag_mm=points.sag_mm, probabilities=False
        )
        if census.verdict != "undecided":
            break
        sag *= 0.5
    return points, census


def _smooth_rests(
    body: Body, com: Array, openings: Sequence[PlacedOpening], parting: Parting | None
) -> tuple[Vector, ...]:
    """Directions in which the smooth surface rests, but for those whose place an open mouth has taken away.

    An upper part that is displaced by d has the rests of the undisplaced one about the centre of mass less d.
    None for a body that is not strictly convex, whose rests the sampled census alone tells.
    """
    mouths = [opening for opening in openings if opening.state != "plugged"]

    def rests(center: Array, upper: bool | None) -> list[Vector]:
        found = [e.direction for e in find_equilibria(body, center) if e.kind == "stable"]
        places = body.position_mm(touching_directions(body, np.array(found)))
        return [
            direction
            for direction, place in zip(found, places, strict=True)
            if not any(_in_mouth(opening, place) for opening in mouths)
            and (parting is None or upper is None or parting.above(place) == upper)
        ]

    try:
        if parting is None or not parting.is_displaced:
            return tuple(rests(com, None))
        return (*rests(com, upper=False), *rests(com - np.array(parting.shift_mm), upper=True))
    except CensusError:
        return ()


def _in_mouth(opening: PlacedOpening, place_mm: Array) -> bool:
    """Whether a point of the surface lies in the mouth of an opening, and not on the body's other side."""
    arm = place_mm - np.array(opening.position_mm)
    across, along = _polar(opening, arm[None])
    near = along[0] > -opening.rim_radius_mm
    return bool(near and across[0] < opening.tool.radius_mm)


def _polar(opening: PlacedOpening, arms: Array) -> tuple[Array, Array]:
    """Distance of points (n, 3), given from the middle of a mouth, across and along its axis, shapes (n,)."""
    axis = np.array(opening.tool.direction)
    along = arms @ axis
    return np.linalg.norm(arms - along[:, None] * axis, axis=1), along


def _rims(
    solids: Sequence[Shape], openings: Sequence[PlacedOpening], body: Body, com: Array
) -> tuple[RimFinding, ...]:
    """Judge the rim of each opening, taken from the solids' edges where it is there as a whole."""
    near = _ON_RIM * body.radius_mm
    edges = _edge_points(solids) if openings else np.empty((0, 3))

    @cache
    def on_surface(shift_mm: Vector) -> Array:
        """Points of edges on the body's surface when the displacement of its part is taken back."""
        undone: Array = edges - np.array(shift_mm)
        return undone[np.abs(InsetSurface(body).signed_distance_mm(undone)) < near] if len(edges) else edges

    return tuple(
        _rim_finding(opening, on_surface(opening.shift_mm), body, com - np.array(opening.shift_mm), near)
        for opening in openings
    )


def _rim_finding(opening: PlacedOpening, edges: Array, body: Body, com: Array, near_mm: float) -> RimFinding:
    """Judge a rim where its part was before it was displaced, with the centre of mass displaced back too."""
    middle = np.array(opening.position_mm)
    across, along = _polar(opening, edges - middle)
    on_side = np.abs(across - opening.tool.radius_mm) < near_mm
    rim = edges[on_side & (along > -opening.rim_radius_mm)]
    whole = len(rim) > 0 and _widest_gap_deg(opening, rim) < _WIDEST_GAP_DEG
    if opening.state == "plugged":
        return RimFinding(opening.name, opening.state, whole, None, None)
    if not whole:
        axis = np.array(opening.tool.direction)
        rim = hole_rims_mm(body, middle[None], axis[None], np.array([opening.tool.radius_mm]))[0]
    # At the rest itself the rim is the foot, and a second rest appears beside it, on the smooth surface.
    clearance = opening.com_clearance_mm if opening.state == "rest" else rim_clearance_mm(rim, com)
    return RimFinding(opening.name, opening.state, whole, rim_rest(rim, com), clearance)


def _widest_gap_deg(opening: PlacedOpening, rim: Array) -> float:
    """Widest angle between neighbouring points of a rim (n, 3), seen along the axis."""
    one, other = (axis[0] for axis in tangent_frame(np.array([opening.tool.direction])))
    arm = rim - np.array(opening.position_mm)
    angles = np.sort(np.degrees(np.arctan2(arm @ other, arm @ one)))
    return float(np.diff(angles, append=angles[0] + 360.0).max())


def _edge_points(solids: Sequence[Shape]) -> Array:
    """Points of all edges of solids, shape (n, 3)."""
    curves = [
        BRepAdaptor_Curve(edge.wrapped)
        for solid in solids
        for edge in solid.edges()
        if not BRep_Tool.Degenerated_s(edge.wrapped)
    ]
    points = [
        curve.Value(parameter)
        for curve in curves
        for parameter in np.linspace(curve.FirstParameter(), curve.LastParameter(), _EDGE_POINTS).tolist()
    ]
    return np.array([(point.X(), point.Y(), point.Z()) for point in points]).reshape(-1, 3)


def recheck_document(found: Recheck) -> dict[str, Any]:
    """The key `hull` of `verdict.json`."""
    mesh = found.census.mesh
    assert mesh is not None  # it is a census of points
    return {
        "verdict": found.verdict,
        "stable": found.stable,
        "reasons": list(found.reasons),
        "com_mm": list(found.census.com_mm),
        "facets": mesh.facets,
        "sag_um": 1e3 * mesh.sag_mm,
        "barrier_um": 1e3 * found.barrier_mm,
        "highest_uncounted_um": None
        if mesh.highest_uncounted_mm is None
        else 1e3 * mesh.highest_uncounted_mm,
        "outside_um": 1e3 * found.outside_mm,
        "poses": [
            {
                "direction": list(pose.direction),
                "height_mm": pose.height_mm,
                "barrier_um": None if pose.barrier_mm is None else 1e3 * pose.barrier_mm,
            }
            for pose in found.census.equilibria
            if pose.kind == "stable"
        ],
        "openings": [
            {
                "name": rim.name,
                "state": rim.state,
                "on_solid": rim.on_solid,
                "com_clearance_mm": rim.com_clearance_mm,
                "rest": None
                if rim.rest is None
                else {
                    "direction": list(rim.rest.direction),
                    "height_mm": rim.rest.height_mm,
                    "barrier_um": 1e3 * rim.rest.barrier_mm,
                },
            }
            for rim in found.rims
        ],
    }
