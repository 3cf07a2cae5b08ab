"""Where everything is in the buoy, in the frame of the resting pose.

On the vertical over the resting point, upwards: the blind recess with the eye bolt; the boss around it, with
the ballast ring in its bay; the battery on both and the electronics on the battery, held by one tube. At the
seam there is a flange with the O-ring.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.batteries import Battery
from gomboc_cad.products.buoy.fittings import (
    Mooring,
    Port,
    flange,
    grooved,
    lay_out_mooring,
    lay_out_port,
    lay_out_seal,
)
from gomboc_cad.products.buoy.o_rings import FaceSeal
from gomboc_cad.products.buoy.site import BuoySite
from gomboc_cad.products.buoy.spec import BuoySpec
from gomboc_cad.products.closures.layout import ClosureLayout, ClosureSite, lay_out_closure
from gomboc_cad.products.openings.sites import PlacedOpening
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.solid.hollow import Cylinder, HollowBody

_CLEAR_MM = 1.0
"""By how much the edge of a level floor is kept off the cavity's surface, where booleans are undecided."""


@dataclass(frozen=True)
class BuoyLayout:
    """The interior of a buoy; heights are over the body's origin, for the unmoved core.

    Attributes:
        frame: Frame of the resting pose.
        stack_mm: The vertical over the resting point, across the frame.
        hollow: Outer surface, cavity, bosses and holes of the unmoved core, and the fixed openings.
        closure: The closure; its seam has the groove of the O-ring.
        seal: The O-ring.
        mooring: The eye bolt; None if there is none.
        port: The filling port; None if there is none.
        ballast_radii_mm: Inner and outer radius of the ballast ring.
        ballast_seat_mm: Height of the ballast's underside.
        battery_seat_mm: Height of the battery's underside, at the same time the end of the ballast bay.
        electronics_seat_mm: Height of the underside of the electronics.
        seam_mm: Height of the seam.
    """

    frame: RestFrame
    stack_mm: tuple[float, float]
    hollow: HollowBody
    closure: ClosureLayout
    seal: FaceSeal
    mooring: Mooring | None
    port: Port | None
    ballast_radii_mm: tuple[float, float]
    ballast_seat_mm: float
    battery_seat_mm: float
    electronics_seat_mm: float
    seam_mm: float

    def on_stack(self, height_mm: float) -> Array:
        """The place at a height on the vertical over the resting point, shape (3,)."""
        return self.frame.point(*self.stack_mm, height_mm)

    @property
    def fixed_openings(self) -> tuple[PlacedOpening, ...]:
        """Openings that stay where they are when the core moves."""
        recess = () if self.mooring is None else (self.mooring.recess,)
        counterbore = () if self.port is None else (self.port.counterbore,)
        return (*recess, *counterbore)

    def hollow_at(self, shift_mm: Vector) -> HollowBody:
        """The hollow body with its core moved."""
        return replace(self.hollow, core_shift_mm=shift_mm)


def lay_out_buoy(spec: BuoySpec, body: Body, battery: Battery, target_mm: Vector) -> BuoyLayout:
    """Place the mooring, the bays, the flange, the closure and the port, and check that they fit.

    Args:
        spec: What is asked for.
        body: The outer shape.
        battery: The battery.
        target_mm: Where the centre of mass is to be, which decides the resting direction.

    Raises:
        SpecError: If a standard part is not available.
        GeometryError: If something does not fit.
    """
    site = BuoySite(spec, body, battery, target_mm)
    mooring = lay_out_mooring(site)
    radii = _ballast_radii_mm(site, mooring)
    bay = radii[1] + spec.ballast.clearance_mm + spec.ballast.wall_mm
    floor = site.level_floor_mm(bay + _CLEAR_MM)
    battery_seat = floor + spec.ballast.bay_height_mm
    if mooring is not None:
        battery_seat = max(battery_seat, mooring.boss_top_mm)
    electronics_seat = battery_seat + battery.height_mm + battery.terminals_mm + spec.electronics.gap_mm
    top = electronics_seat + spec.electronics.height_mm
    _check_stack(site, battery_seat, top)

    keep_out = (site.upright(site.below_mm, -site.below_mm, site.tube_mm),)
    around = ClosureSite(
        body, site.frame, spec.shell, site.seam_mm, target_mm, keep_out=keep_out, sag_um=spec.mesh.sag_um
    )
    closure = lay_out_closure(spec.closure, around)
    seal = lay_out_seal(site, closure)
    _check_passes(site, seal)
    port = lay_out_port(site, closure, mooring)

    bosses = (
        site.upright(site.below_mm, floor, bay + 3.0 * _CLEAR_MM),
        site.upright(site.below_mm, battery_seat, bay, bay - spec.ballast.wall_mm),
        site.upright(site.below_mm, _tube_top_mm(site, top), site.tube_mm, site.tube_bore_mm),
        flange(site, seal),
        *(() if mooring is None else (_mooring_boss(site, mooring),)),
        *(() if port is None else (port.boss,)),
    )
    recesses = [] if mooring is None else [mooring.recess.tool, mooring.thread_hole]
    recesses += [] if port is None else [port.counterbore.tool, port.thread_hole]
    hollow = HollowBody(
        body,
        spec.shell.wall_mm,
        bosses=(*bosses, *closure.bosses),
        holes=closure.holes,
        openings=tuple(recesses),
    )
    return BuoyLayout(
        frame=site.frame,
        stack_mm=site.stack_mm,
        hollow=hollow,
        closure=replace(closure, seam=grooved(site, closure.seam, seal)),
        seal=seal,
        mooring=mooring,
        port=port,
        ballast_radii_mm=radii,
        ballast_seat_mm=floor,
        battery_seat_mm=battery_seat,
        electronics_seat_mm=electronics_seat,
        seam_mm=site.seam_mm,
    )


def _mooring_boss(site: BuoySite, mooring: Mooring) -> Cylinder:
    radius = mooring.recess.tool.radius_mm + site.spec.mooring.wall_mm
    return site.upright(site.below_mm, mooring.boss_top_mm, radius)


def _ballast_radii_mm(site: BuoySite, mooring: Mooring | None) -> tuple[float, float]:
    """Of a ring around the mooring's boss, or of a disc where there is none."""
    spec = site.spec
    outer = 0.5 * spec.ballast.outer_diameter_mm
    if mooring is None:
        return 0.0, outer
    post = mooring.recess.tool.radius_mm + spec.mooring.wall_mm
    inner = post + spec.ballast.clearance_mm
    if inner >= outer:
        raise GeometryError(
            f"The ballast ring of {2.0 * outer:g} mm does not go around the mooring's boss of {2.0 * post:g} "
            "mm; make ballast.outer_diameter_mm larger or mooring.recess_diameter_mm smaller."
        )
    return inner, outer


def _tube_top_mm(site: BuoySite, top_mm: float) -> float:
    """The tube belongs to the lower half and ends under the flange."""
    return min(top_mm, site.seam_mm - site.spec.flange.thickness_mm)


def _check_stack(site: BuoySite, battery_seat: float, top: float) -> None:
    """Battery and electronics must lie in the cavity, and the battery at least half in the tube."""
    name, height = site.battery.name, site.battery.height_mm
    for level, what in (
        (battery_seat, f"The battery {name!r}, at its underside,"),
        (top, "The electronics bay, at its top,"),
    ):
        if (room := site.room_mm(level, site.tube_bore_mm)) < 0.0:
            raise GeometryError(
                f"{what} does not fit: {-room:.1f} mm of room is missing to the wall; take a smaller battery "
                "or bay, a thinner wall or a larger diameter."
            )
    held = _tube_top_mm(site, top) - battery_seat
    if held < 0.5 * height:
        raise GeometryError(
            f"The battery {name!r} does not fit: its tube ends under the flange and would hold "
            f"{max(0.0, held):.1f} mm of its {height:g} mm; choose a flatter battery, raise split.height_mm, "
            "or take a larger diameter."
        )


def _check_passes(site: BuoySite, seal: FaceSeal) -> None:
    """The battery must go in through the flange."""
    bore = seal.inner_radius_mm - site.spec.flange.land_mm
    needed = site.tube_mm + float(np.hypot(*site.stack_mm))
    if needed > bore:
        raise GeometryError(
            f"The battery {site.battery.name!r} does not fit: with its tube it needs a radius of "
            f"{needed:.1f} mm, and the flange at the seam leaves {bore:.1f} mm; take a smaller battery, a "
            "thinner O-ring or a larger diameter."
        )
