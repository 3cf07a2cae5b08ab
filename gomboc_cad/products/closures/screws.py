"""Screws parallel to the vertical, from outside through one part into inserts or core holes of the other."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gomboc_cad.body import depth_mm
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.errors import GeometryError, SpecError
from gomboc_cad.products.assembly import Part
from gomboc_cad.products.closures.records import ClosureLayout, ClosureSite
from gomboc_cad.products.closures.spec import ScrewsSpec
from gomboc_cad.products.fasteners import Insert, Screw, heat_set_insert, screw, screw_lengths_mm, thread_of
from gomboc_cad.products.materials import load_material
from gomboc_cad.products.openings.sites import PlacedOpening, place_around
from gomboc_cad.solid.hollow.tools import Cylinder

_METAL, _BRASS = (0.62, 0.64, 0.66), (0.80, 0.66, 0.30)
_TIP_ROOM_MM = 1.0
_RELIEF_MM = 0.2
"""How far the wider hole runs on beyond the seam: room for what bulges around an insert or a tapped hole."""

_HEAD_COVER_MM = 0.5
"""Least depth of a head under the surface."""

_THREADS_IN_PLASTIC = 2.0
"""Length of a tapped thread in soft material, in diameters."""

_RIM_POINTS = 16
_RADII = 6
_DIRECTIONS_LEVEL = 5
_STEEPEST_DEG = 55.0
"""Steepest surface that a recess is put into: what is left between them is a wedge of at least 35°."""

_ENOUGH_CLEARANCE = 0.01
"""Of the COM, in units of R₀, from which on more is of no use: bodies themselves have less."""


@dataclass(frozen=True)
class _Joint:
    """A screw with its holes; heights along its axis from the seam, positive towards the head."""

    screw: Screw
    insert: Insert | None
    clamp_mm: float
    hole_depth_mm: float
    boss_wall_mm: float

    @property
    def thread_radius_mm(self) -> float:
        """Radius of the hole for the insert, or of the core hole."""
        return 0.5 * (self.insert.hole_diameter_mm if self.insert else self.screw.tap_drill_mm)

    @property
    def recess_radius_mm(self) -> float:
        return 0.5 * self.screw.counterbore_mm

    @property
    def column_radius_mm(self) -> float:
        return max(self.recess_radius_mm, self.thread_radius_mm) + self.boss_wall_mm

    @property
    def head_top_mm(self) -> float:
        return self.clamp_mm + self.screw.head_height_mm


def lay_out_screws(spec: ScrewsSpec, site: ClosureSite) -> ClosureLayout:
    """Choose screws and their places so that no head recess becomes a rest.

    Raises:
        SpecError: If a screw or an insert is not available.
        GeometryError: If a screw is too long or too short, they do not fit at the seam, or a recess would be
            a rest wherever it is put.
    """
    joint = _joint(spec, site)
    recesses = _recesses(spec, site, joint)
    places = [site.across(recess.tool) for recess in recesses]
    columns = _columns(site, joint, recesses)
    _check_hole_ends(spec, site, joint, places)
    numbers = range(1, len(places) + 1)
    stay_with_head = tuple(f"closure-screw-{number}" for number in numbers)
    stay_with_thread = tuple(f"closure-insert-{number}" for number in numbers) if joint.insert else ()
    return ClosureLayout(
        site=site,
        seam=site.seam(),
        bosses=columns,
        holes=tuple(hole for place in places for hole in _holes(spec, site, joint, place)),
        openings=recesses,
        plugs=tuple(_plug(spec, site, joint, place) for place in places) if spec.plugged else (),
        parts=_parts(spec, site, joint, places),
        upper_parts=stay_with_head if spec.head_in == "upper" else stay_with_thread,
        columns=columns,
        notes=_notes(spec, joint),
    )


def _joint(spec: ScrewsSpec, site: ClosureSite) -> _Joint:
    insert = None
    engagement = _THREADS_IN_PLASTIC * thread_of(spec.screw)
    if spec.thread == "insert":
        insert = heat_set_insert(spec.insert, spec.insert_maker)
        engagement = insert.length_mm
        if thread_of(spec.insert) != thread_of(spec.screw):
            raise SpecError(
                f"The insert {insert.standard} and the screw {spec.screw} have different threads; make "
                "closure.insert and closure.screw match."
            )
    needed = spec.clamp_mm + engagement
    length = _length(spec, needed)
    if length < needed:
        raise GeometryError(
            f"The closure screw of {length:g} mm is too short: {spec.clamp_mm:g} mm are clamped, so it "
            f"engages {max(0.0, length - spec.clamp_mm):g} mm of thread where {engagement:g} mm are needed; "
            f"take at least {needed:g} mm or a smaller closure.clamp_mm."
        )
    depth = max(length - spec.clamp_mm + _TIP_ROOM_MM, insert.hole_depth_mm if insert else 0.0)
    wall = max(spec.boss_wall_mm, insert.min_wall_mm if insert else 0.0)
    return _Joint(screw(spec.screw, length, spec.standard), insert, spec.clamp_mm, depth, wall)


def _length(spec: ScrewsSpec, needed_mm: float) -> float:
    if spec.length_mm != "auto":
        return spec.length_mm
    lengths = screw_lengths_mm(spec.screw, spec.standard)
    return next((length for length in lengths if length >= needed_mm), lengths[-1])


def _recesses(spec: ScrewsSpec, site: ClosureSite, joint: _Joint) -> tuple[PlacedOpening, ...]:
    """The recesses farthest out that are harmless, or those that leave the centre of mass the most room."""
    placed: list[tuple[PlacedOpening, ...]] = []
    complaint: GeometryError | None = None
    for radius in _radii_mm(spec, site, joint):
        try:
            recesses = _recesses_at(spec, site, joint, radius)
            site.check_clear("closure screw", _columns(site, joint, recesses))
        except GeometryError as error:
            complaint = complaint or error
        else:
            placed.append(recesses)
            if _least_clearance_mm(recesses) > _ENOUGH_CLEARANCE * site.body.radius_mm:
                break
    if complaint and not placed:
        raise complaint
    return max(placed, key=_least_clearance_mm)


def _columns(site: ClosureSite, joint: _Joint, recesses: tuple[PlacedOpening, ...]) -> tuple[Cylinder, ...]:
    return tuple(site.column(site.across(recess.tool), joint.column_radius_mm) for recess in recesses)


def _radii_mm(spec: ScrewsSpec, site: ClosureSite, joint: _Joint) -> list[float]:
    """Distances from the vertical to be tried, the farthest first."""
    if spec.pitch_radius_mm != "auto":
        return [spec.pitch_radius_mm]
    towards_head, towards_thread = joint.head_top_mm + _HEAD_COVER_MM, joint.hole_depth_mm
    cover = max(joint.recess_radius_mm, joint.thread_radius_mm + site.shell.wall_mm)
    above, below = (
        (towards_head, towards_thread) if spec.head_in == "upper" else (towards_thread, towards_head)
    )
    farthest = min(
        site.widest_ring_mm(below, above, cover), _flat_radius_mm(spec, site) - joint.recess_radius_mm
    )
    nearest = joint.column_radius_mm / math.sin(math.pi / spec.count) if spec.count > 1 else 0.0
    if nearest > farthest:
        raise GeometryError(
            f"{spec.count} closure screws {joint.screw.standard} with bosses of "
            f"{2.0 * joint.column_radius_mm:.3g} mm do not fit beside each other at the seam; take fewer or "
            "smaller ones, or a larger diameter."
        )
    return np.linspace(farthest, nearest, _RADII).tolist()


def _flat_radius_mm(spec: ScrewsSpec, site: ClosureSite) -> float:
    """Distance from the vertical up to which a recess leaves no knife edge at its rim."""
    directions = geodesic_triangulation(_DIRECTIONS_LEVEL)[0]
    towards_head = site.body.normal(directions) @ (_side(spec) * np.array(site.frame.up))
    steep = (towards_head > 0.0) & (towards_head < math.cos(math.radians(_STEEPEST_DEG)))
    level = site.body.position_mm(directions[steep]) @ site.frame.matrix()[:2].T
    return float(np.linalg.norm(level, axis=1).min())


def _recesses_at(
    spec: ScrewsSpec, site: ClosureSite, joint: _Joint, radius_mm: float
) -> tuple[PlacedOpening, ...]:
    return place_around(
        site.body,
        site.com_mm,
        "closure screw",
        spec.count,
        radius_mm=joint.recess_radius_mm,
        from_axis_mm=radius_mm,
        base_height_mm=site.seam_height_mm + _side(spec) * joint.clamp_mm,
        outwards="up" if spec.head_in == "upper" else "down",
        frame=site.frame,
        wall_mm=site.shell.wall_mm,
        keep_out=site.keep_out,
        first_angle_deg=None if spec.angle_deg == "auto" else spec.angle_deg,
        plug=spec.plugged,
    )


def _least_clearance_mm(recesses: tuple[PlacedOpening, ...]) -> float:
    if any(recess.state == "forced" for recess in recesses):
        return -1.0
    return min((recess.com_clearance_mm or math.inf) for recess in recesses)


def _side(spec: ScrewsSpec) -> float:
    return 1.0 if spec.head_in == "upper" else -1.0


def _along(
    spec: ScrewsSpec, site: ClosureSite, place: tuple[float, float], start: float, end: float, radius: float
) -> Cylinder:
    """A cylinder along a screw between two heights from the seam, positive towards the head."""
    axis = as_vector(_side(spec) * np.array(site.frame.up))
    return Cylinder(site.point(*place, _side(spec) * start), axis, radius, end - start)


def _holes(
    spec: ScrewsSpec, site: ClosureSite, joint: _Joint, place: tuple[float, float]
) -> tuple[Cylinder, Cylinder, Cylinder]:
    """Thread hole, clearance hole and head recess of one screw, each running on into the next."""
    out = 2.0 * site.body.radius_mm
    return (
        _along(spec, site, place, -joint.hole_depth_mm, _RELIEF_MM, joint.thread_radius_mm),
        _along(spec, site, place, -_RELIEF_MM, joint.clamp_mm + _RELIEF_MM, 0.5 * joint.screw.clearance_mm),
        _along(spec, site, place, joint.clamp_mm, out, joint.recess_radius_mm),
    )


def _plug(spec: ScrewsSpec, site: ClosureSite, joint: _Joint, place: tuple[float, float]) -> Cylinder:
    radius = joint.recess_radius_mm - spec.plug_gap_mm
    out = 2.0 * site.body.radius_mm
    return _along(spec, site, place, joint.head_top_mm + spec.plug_gap_mm, out, radius)


def _check_hole_ends(
    spec: ScrewsSpec, site: ClosureSite, joint: _Joint, places: list[tuple[float, float]]
) -> None:
    """Refuse a hole that comes too near to the surface at its blind end, and a head that sticks out."""
    thread = (-joint.hole_depth_mm, _RELIEF_MM, joint.thread_radius_mm)
    head = (joint.clamp_mm, joint.head_top_mm, joint.recess_radius_mm)
    under, over = (
        float(depth_mm(site.body, np.concatenate([rim.rims_mm(_RIM_POINTS) for rim in rims])).min())
        for rims in ([_along(spec, site, place, *ends) for place in places] for ends in (thread, head))
    )
    if under < site.shell.wall_mm - 1e-6:
        raise GeometryError(
            f"The closure screw {joint.screw.standard} is longer than its boss: its hole of "
            f"{joint.hole_depth_mm:g} mm ends {max(0.0, under):.2f} mm under the surface and must stay "
            f"{site.shell.wall_mm:g} mm under it; take a shorter one, a smaller closure.pitch_radius_mm or a "
            "larger diameter."
        )
    if over < 0.0:
        raise GeometryError(
            f"The head of the closure screw {joint.screw.standard} sticks out of the surface; take a smaller "
            "closure.clamp_mm or closure.pitch_radius_mm."
        )


def _parts(
    spec: ScrewsSpec, site: ClosureSite, joint: _Joint, places: list[tuple[float, float]]
) -> tuple[Part, ...]:
    steel, brass = load_material(spec.material), load_material("brass")
    downwards = spec.head_in == "lower"
    parts = []
    for number, place in enumerate(places, start=1):
        seat = site.location(place, _side(spec) * joint.clamp_mm, downwards)
        driven = joint.screw.solid.moved(seat)
        parts.append(Part.homogeneous(f"closure-screw-{number}", driven, steel, _METAL, joint.screw.standard))
        if joint.insert:
            sunk = joint.insert.solid.moved(site.location(place, 0.0, downwards))
            parts.append(
                Part.homogeneous(f"closure-insert-{number}", sunk, brass, _BRASS, joint.insert.standard)
            )
    return tuple(parts)


def _notes(spec: ScrewsSpec, joint: _Joint) -> tuple[str, ...]:
    if spec.plugged:
        return ("Press or glue the plugs into the head recesses before the product is set down.",)
    return ()
