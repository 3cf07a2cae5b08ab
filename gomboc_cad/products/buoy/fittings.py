"""What opens or seals the buoy's shell: the mooring eye, the filling port, and the O-ring in its flange."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.buoy.hardware import EyeBolt, ScrewPlug, load_eye_bolt, load_screw_plug
from gomboc_cad.products.buoy.o_rings import FaceSeal, face_seal, largest_face_seal, load_series
from gomboc_cad.products.buoy.site import BuoySite
from gomboc_cad.products.closures.records import ClosureLayout
from gomboc_cad.products.openings.sites import OpeningRequest, PlacedOpening
from gomboc_cad.solid.hollow import Cylinder, Seam

_OVERLAP_MM = 1.0
"""How far a core hole runs into its recess, and beyond the end of its thread."""

_ABOVE_SEAM_MM = 0.2
"""How far the tool of the groove, which is taken from the lower half only, reaches above the seam."""

_BESIDE_EYE_MM = 3.0
"""Least room on both sides of an eye."""

_NARROWEST_SHARE = 0.6
"""Standard O-rings that would make the flange wider than this share of the seam's radius are not taken."""


@dataclass(frozen=True)
class Mooring:
    """The eye bolt in its recess.

    Attributes:
        eye: The bolt.
        recess: The recess.
        thread_hole: The core hole of its thread, over the recess.
        seat_mm: Height of the recess's end over the body's origin.
        boss_top_mm: Height of the end of the boss around all this.
    """

    eye: EyeBolt
    recess: PlacedOpening
    thread_hole: Cylinder
    seat_mm: float
    boss_top_mm: float


@dataclass(frozen=True)
class Port:
    """The screw plug in its counterbore.

    Attributes:
        plug: The plug.
        counterbore: What opens the surface.
        thread_hole: The core hole from the counterbore into the cavity.
        boss: Material around both.
        in_upper: Whether it is in the upper half.
    """

    plug: ScrewPlug
    counterbore: PlacedOpening
    thread_hole: Cylinder
    boss: Cylinder
    in_upper: bool


def lay_out_mooring(site: BuoySite) -> Mooring | None:
    """Sink the eye bolt at the resting point; None if none is wanted.

    Raises:
        GeometryError: If the recess is too narrow for the eye.
    """
    spec = site.spec.mooring
    if spec.eye == "none":
        return None
    eye = load_eye_bolt(spec.eye)
    radius = 0.5 * spec.recess_diameter_mm
    least = eye.ring_outside_mm + 2.0 * _BESIDE_EYE_MM
    if 2.0 * radius < least:
        raise GeometryError(
            f"The mooring recess of {2.0 * radius:g} mm leaves no room beside the eye bolt {spec.eye}, which "
            f"is {eye.ring_outside_mm:g} mm wide; make mooring.recess_diameter_mm at least {least:g} mm."
        )
    depth = eye.recess_depth_mm(radius, site.smallest_radius_mm())
    request = OpeningRequest("the mooring recess", radius, depth, direction="rest")
    recess = site.placed(request, site.spec.shell.wall_mm)
    seat = site.height_mm(recess.tool.base_mm)
    end = seat + eye.thread_length_mm + _OVERLAP_MM
    thread_hole = site.upright(seat - _OVERLAP_MM, end, 0.5 * eye.tap_drill_mm)
    return Mooring(eye, recess, thread_hole, seat, end + spec.wall_mm)


def lay_out_port(site: BuoySite, closure: ClosureLayout, mooring: Mooring | None) -> Port | None:
    """Put the screw plug where its counterbore is no rest; None if none is wanted.

    Raises:
        GeometryError: If it has no place, or meets another opening or the tube inside.
    """
    spec = site.spec.port
    if spec.plug == "none":
        return None
    plug = load_screw_plug(spec.plug)
    radius, depth = plug.recess_radius_mm, plug.recess_depth_mm(site.smallest_radius_mm())
    request = OpeningRequest("the filling port", radius, depth, direction=spec.direction, side=spec.side)
    others = (*closure.openings, *(() if mooring is None else (mooring.recess,)))
    # Its boss keeps clear of the flange.
    away = site.spec.flange.thickness_mm + spec.wall_mm
    counterbore = site.placed(request, away, closure.columns, others)
    axis = counterbore.tool.axis
    length = plug.thread_length_mm + spec.wall_mm
    inner = as_vector(np.subtract(counterbore.tool.base_mm, length * np.array(counterbore.tool.direction)))
    boss = Cylinder(inner, axis, radius + spec.wall_mm, length + 2.0 * depth)
    if float(site.beside_mm(boss.rims_mm()).min()) < site.tube_mm:
        raise GeometryError(
            "The boss of the filling port meets the tube of the battery; give port.direction a place further "
            "from the vertical, or choose a smaller plug or battery."
        )
    thread_hole = Cylinder(inner, axis, 0.5 * plug.tap_drill_mm, length + 0.5 * depth)
    in_upper = site.height_mm(counterbore.position_mm) > site.seam_mm
    return Port(plug, counterbore, thread_hole, boss, in_upper)


def lay_out_seal(site: BuoySite, closure: ClosureLayout) -> FaceSeal:
    """The largest O-ring inside the wall and the holes of the closure, or the one that is asked for.

    Raises:
        SpecError: If there is none of that thickness.
        GeometryError: If it does not fit into the flange.
    """
    spec = site.spec.flange
    depth = load_series(spec.cross_section_mm).groove_depth_mm
    if spec.thickness_mm < depth + spec.land_mm:
        raise GeometryError(
            f"flange.thickness_mm = {spec.thickness_mm:g} leaves too little under the O-ring's groove, which "
            f"is {depth:g} mm deep; it needs at least {depth + spec.land_mm:g} mm."
        )
    outermost = closure.site.widest_ring_mm(depth, 0.0, site.spec.shell.wall_mm)
    for hole in closure.holes:
        first, second, base = site.frame.matrix() @ np.array(hole.base_mm)
        low, high = sorted((base, base + hole.length_mm * float(np.dot(hole.direction, site.frame.up))))
        if low < site.seam_mm and high > site.seam_mm - depth - spec.land_mm:
            outermost = min(outermost, float(np.hypot(first, second)) - hole.radius_mm)
    outermost -= spec.land_mm
    if spec.inside_diameter_mm == "auto":
        return largest_face_seal(spec.cross_section_mm, outermost, _NARROWEST_SHARE * outermost)
    return face_seal(spec.cross_section_mm, spec.inside_diameter_mm, outermost)


def flange(site: BuoySite, seal: FaceSeal) -> Cylinder:
    """The flange, from its bore to beyond the wall, on both sides of the seam."""
    spec = site.spec.flange
    bore = seal.inner_radius_mm - spec.land_mm
    low, high = site.seam_mm - spec.thickness_mm, site.seam_mm + spec.thickness_mm
    return site.centred(low, high, -site.below_mm, bore)


def grooved(site: BuoySite, seam: Seam, seal: FaceSeal) -> Seam:
    """The seam with the O-ring's groove in the lower half."""
    low, high = site.seam_mm - seal.groove_depth_mm, site.seam_mm + _ABOVE_SEAM_MM
    groove = site.centred(low, high, seal.outer_radius_mm, seal.inner_radius_mm)
    return replace(seam, groove=(*seam.taken_below, groove))
