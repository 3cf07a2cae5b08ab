"""Where everything is in a seed pod: the seed's chamber, the way in, and the way out for the root."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from gomboc_cad.body import Body, depth_mm
from gomboc_cad.body.sphere import Array, geodesic_triangulation
from gomboc_cad.equilibria import smooth_census
from gomboc_cad.equilibria.records import Rest, Vector, as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.closures.layout import ClosureLayout, ClosureSite, lay_out_closure
from gomboc_cad.products.openings.sites import OpeningRequest, PlacedOpening, place_openings
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.products.placing.trim import TrimSite
from gomboc_cad.products.seed_pod.seeds import Seed
from gomboc_cad.products.seed_pod.spec import LARGEST_MM, PlugSpec, SeedPodSpec
from gomboc_cad.solid.hollow import Cylinder, Ellipsoid, HollowBody, Tool

EXIT = "radicle exit"

_SPAN_LEVEL = 5
"""Subdivision at which support functions are compared: normals 2° apart, so walls to a few micrometres."""

_RIM_POINTS = 64
_REACH_SHARE = 0.8
"""How far the chamber may move before the exit would not reach it, in units of its half height."""


@dataclass(frozen=True)
class WayIn:
    """The opening at the top and the plug that closes it, before the core's shift.

    Attributes:
        throat: From the chamber to the ledge that the plug sits on.
        bore: From the ledge outwards.
        plug: What the plug is cut out with.
    """

    throat: Cylinder
    bore: Cylinder
    plug: Cylinder


@dataclass(frozen=True)
class PodLayout:
    """The interior of a seed pod before the core's shift.

    Attributes:
        body: The outer shape.
        frame: Frame of the resting pose.
        rest: The rest about the centre of mass that is wanted.
        seed: The seed in its place.
        chamber: The room around the seed, an ellipsoid too.
        way_in: Opening and plug of a pod in one piece; None for two halves.
        closure: How two halves are closed; None for a pod in one piece.
        exit: The way out for the root.
        wall_mm: The thinnest wall around the chamber.
    """

    body: Body
    frame: RestFrame
    rest: Rest
    seed: Ellipsoid
    chamber: Ellipsoid
    way_in: WayIn | None
    closure: ClosureLayout | None
    exit: PlacedOpening
    wall_mm: float

    @property
    def room(self) -> tuple[Tool, ...]:
        """What seed and substrate fill together: the chamber and what widens it, throat or bore."""
        if self.way_in is not None:
            return self.chamber, self.way_in.throat
        bores = () if self.closure is None else self.closure.holes
        return self.chamber, *(hole for hole in bores if self._is_around_seed(hole))

    @property
    def reach_mm(self) -> float:
        """How far the core may move before the exit no longer leads into the chamber."""
        return _REACH_SHARE * half_extent_mm(self.chamber, self.frame.up)

    def hollow(
        self,
        shift_mm: Vector = (0.0, 0.0, 0.0),
        core_holes: Sequence[Cylinder] = (),
        fixed_holes: Sequence[Cylinder] = (),
    ) -> HollowBody:
        """Give the whole pod with its core moved and with holes for trim masses."""
        bore = () if self.way_in is None else (self.way_in.throat, self.way_in.bore)
        closing = () if self.closure is None else self.closure.holes
        # A hole in the curved floor starts at the middle of the chamber, or its rim would stay covered.
        trim = (hole.extended(self._over_floor_mm(hole), 0.0) for hole in core_holes)
        holes = (self.chamber, *bore, *closing, *trim)
        return HollowBody(self.body, None, shift_mm, holes=holes, openings=(self.exit.tool, *fixed_holes))

    def _over_floor_mm(self, hole: Cylinder) -> float:
        """Height of the chamber's middle over the mouth of a hole in its floor."""
        return float(np.subtract(self.chamber.center_mm, hole.base_mm) @ np.array(self.frame.up))

    def _is_around_seed(self, hole: Cylinder) -> bool:
        """Whether a hole of the closure is the bore around the seed, and not that of a pin beside it."""
        arm, axis = np.subtract(self.seed.center_mm, hole.base_mm), np.array(hole.direction)
        return bool(np.linalg.norm(arm - (arm @ axis) * axis) < hole.radius_mm)


def lay_out(spec: SeedPodSpec, body: Body, seed: Seed, com_mm: Vector, least_wall_mm: float) -> PodLayout:
    """Place seed, chamber, way in and exit around the centre of mass that is wanted.

    Args:
        spec: What is asked for.
        body: The outer shape.
        seed: The seed.
        com_mm: Where the centre of mass is to be; the middle of the seed goes there.
        least_wall_mm: The least wall that may be left anywhere.

    Raises:
        GeometryError: If something does not fit.
    """
    rest = smooth_census(body, com_mm, margins=False).rest
    frame = RestFrame.from_rest(rest.direction)
    axes = _as_axes(seed.axes_in(frame.matrix()))
    inside = Ellipsoid(com_mm, axes, as_vector(seed.semi_axes_mm))
    chamber = Ellipsoid(com_mm, axes, as_vector(seed.semi_axes_mm + spec.seed.clearance_mm))
    way_in = (
        _way_in(spec.closure, frame, inside, chamber, least_wall_mm, body)
        if isinstance(spec.closure, PlugSpec)
        else None
    )
    spans = _Spans.of(body, chamber, way_in)
    if spans.wall_mm < spec.shell.wall_mm:
        raise GeometryError(_does_not_fit(spec, seed, spans))
    radicle_exit = _exit(spec, body, frame, rest, seed, inside, com_mm, least_wall_mm)
    closure = None
    if not isinstance(spec.closure, PlugSpec):
        site = ClosureSite(
            body,
            frame,
            spec.shell,
            spec.split.height_mm,
            com_mm,
            keep_out=(_column(frame, chamber),),
            bore_radius_mm=widest_across_mm(chamber, frame)[1],
        )
        closure = lay_out_closure(spec.closure, site)
    return PodLayout(body, frame, rest, inside, chamber, way_in, closure, radicle_exit, spans.wall_mm)


def half_extent_mm(ellipsoid: Ellipsoid, direction: Vector | Array) -> float:
    """Half of an ellipsoid's width along a unit vector: its support function."""
    along = ellipsoid.frame @ np.asarray(direction)
    return float(np.linalg.norm(along * np.array(ellipsoid.semi_axes_mm)))


def widest_across_mm(ellipsoid: Ellipsoid, frame: RestFrame) -> tuple[float, float]:
    """Least and greatest half-width of an ellipsoid seen along the vertical."""
    across = (ellipsoid.frame @ frame.matrix()[:2].T) * np.array(ellipsoid.semi_axes_mm)[:, None]
    narrow, wide = np.linalg.svd(across, compute_uv=False)[::-1]
    return float(narrow), float(wide)


def trim_sites(layout: PodLayout, least_wall_mm: float) -> tuple[TrimSite, ...]:
    """Places for trim masses: holes from the floor of the chamber down, around the exit.

    There are none in a pod of one piece, into which nothing can be pressed from above, and none where the
    wall under the chamber is too thin.
    """
    if layout.way_in is not None:
        return ()
    frame, chamber = layout.frame, layout.chamber
    narrow, _ = widest_across_mm(chamber, frame)
    room = narrow - layout.exit.tool.radius_mm - least_wall_mm
    from_axis = layout.exit.tool.radius_mm + least_wall_mm + 0.5 * room
    sites = []
    for number, (first, second) in enumerate(((1, 0), (0, 1), (-1, 0), (0, -1)), start=1):
        across = from_axis * (first * np.array(frame.first) + second * np.array(frame.second))
        floor = _floor_mm(chamber, np.array(chamber.center_mm) + across, np.array(frame.up))
        if floor is None:
            continue
        length = _length_under_mm(layout, floor, 0.5 * room + least_wall_mm)
        if length > 0.0:
            down = as_vector(-np.array(frame.up))
            sites.append(TrimSite(f"trim site {number}", as_vector(floor), down, length, room))
    return tuple(sites)


def _as_axes(rows: Array) -> tuple[Vector, Vector, Vector]:
    x, y, z = (as_vector(row) for row in rows)
    return x, y, z


def _way_in(
    spec: PlugSpec,
    frame: RestFrame,
    seed: Ellipsoid,
    chamber: Ellipsoid,
    ledge_mm: float,
    body: Body,
) -> WayIn:
    """A throat that the seed passes upright, and above its ledge the bore for the plug."""
    up = np.array(frame.up)
    middle = np.array(chamber.center_mm)
    throat_radius = widest_across_mm(seed, frame)[1] + spec.passage_mm
    ledge_height = half_extent_mm(chamber, up) + ledge_mm
    throat = Cylinder(as_vector(middle), frame.up, throat_radius, ledge_height)
    ledge = as_vector(middle + ledge_height * up)
    plug = Cylinder(ledge, frame.up, throat_radius + spec.shoulder_mm, 2.0 * body.radius_mm)
    bore = Cylinder(ledge, frame.up, plug.radius_mm + spec.gap_mm, plug.length_mm)
    return WayIn(throat, bore, plug)


@dataclass(frozen=True, eq=False)
class _Spans:
    """Support functions about the wanted centre of mass, of the body and of what is hollow in it, (n,) each.

    The least distance between the surface of a convex body and a convex void in it is the least difference
    of the two. A body of another size has `height_mm` in proportion.
    """

    height_mm: Array
    reach_mm: Array

    @classmethod
    def of(cls, body: Body, chamber: Ellipsoid, way_in: WayIn | None) -> _Spans:
        surface = body.surface(geodesic_triangulation(_SPAN_LEVEL)[0])
        normal, center = surface.normal, np.array(chamber.center_mm)
        height = np.einsum("nx,nx->n", surface.position_mm - center, normal)
        reach = np.linalg.norm((normal @ chamber.frame.T) * np.array(chamber.semi_axes_mm), axis=1)
        if way_in is not None:
            rim = way_in.bore.rims_mm(_RIM_POINTS)[:_RIM_POINTS] - center
            reach = np.maximum(reach, (normal @ rim.T).max(axis=1))
        return cls(height, reach)

    @property
    def wall_mm(self) -> float:
        """The thinnest wall."""
        return float((self.height_mm - self.reach_mm).min())

    def scale_for(self, wall_mm: float) -> float:
        """How many times as large the body must be to leave a wall."""
        return float(((wall_mm + self.reach_mm) / self.height_mm).max())


def _does_not_fit(spec: SeedPodSpec, seed: Seed, spans: _Spans) -> str:
    diameter, wall = spec.body.diameter_mm, spans.wall_mm
    left = f"leaves a wall of {wall:.2f} mm" if wall > 0.0 else "breaks through the surface"
    needed = math.ceil(diameter * spans.scale_for(spec.shell.wall_mm))
    remedy = (
        f"take a diameter of {needed:g} mm or more"
        if needed <= LARGEST_MM
        else f"it would need {needed:g} mm and a pod has up to {LARGEST_MM:g} mm: take a smaller seed"
    )
    return (
        f"The seed {seed.name!r} of {seed.length_mm:g} x {seed.width_mm:g} x {seed.thickness_mm:g} mm with "
        f"{spec.seed.clearance_mm:g} mm of room around it does not fit a pod of {diameter:g} mm: its chamber "
        f"{left} and shell.wall_mm asks for {spec.shell.wall_mm:g} mm; {remedy}, a smaller seed.clearance_mm "
        "or a thinner shell.wall_mm."
    )


def _exit(
    spec: SeedPodSpec,
    body: Body,
    frame: RestFrame,
    rest: Rest,
    seed: Seed,
    inside: Ellipsoid,
    com_mm: Vector,
    least_wall_mm: float,
) -> PlacedOpening:
    """The hole at the rest point, up to the middle of the chamber."""
    diameter = spec.exit.diameter_mm or seed.radicle_diameter_mm
    narrow, _ = widest_across_mm(inside, frame)
    if diameter >= 2.0 * narrow:
        raise GeometryError(
            f"The exit of {diameter:g} mm lets the seed fall out, which is {2.0 * narrow:.3g} mm across over "
            "it; make exit.diameter_mm smaller."
        )
    # The rest point is right under the centre of mass, around which the chamber is.
    request = OpeningRequest(EXIT, 0.5 * diameter, rest.height_mm, direction="rest")
    return place_openings(body, com_mm, (request,), frame=frame, wall_mm=least_wall_mm)[0]


def _column(frame: RestFrame, chamber: Ellipsoid) -> Cylinder:
    """What a closure must stay clear of: the chamber, seen along the vertical."""
    half = half_extent_mm(chamber, frame.up)
    base = np.array(chamber.center_mm) - half * np.array(frame.up)
    return Cylinder(as_vector(base), frame.up, widest_across_mm(chamber, frame)[1], 2.0 * half)


def _floor_mm(chamber: Ellipsoid, place_mm: Array, up: Array) -> Array | None:
    """Where the vertical through a place leaves the chamber at its bottom; None beside the chamber."""
    scale = np.array(chamber.semi_axes_mm)
    start = chamber.frame @ (place_mm - np.array(chamber.center_mm)) / scale
    slope = chamber.frame @ up / scale
    along, across, rest = slope @ slope, start @ slope, start @ start - 1.0
    root = across * across - along * rest
    if root <= 0.0:
        return None
    result: Array = place_mm - (across + np.sqrt(root)) / along * up
    return result


def _length_under_mm(layout: PodLayout, floor_mm: Array, cover_mm: float) -> float:
    """How deep a hole may go from the chamber's floor before its end comes within a cover of the surface."""
    down = -np.array(layout.frame.up)

    def spare(length: float) -> float:
        return float(depth_mm(layout.body, floor_mm + length * down)[0]) - cover_mm

    return float(brentq(spare, 0.0, layout.body.diameter_mm, xtol=1e-6)) if spare(0.0) > 0.0 else 0.0
