"""Parallel pins across the seam."""

from __future__ import annotations

import math

from gomboc_cad.products.assembly import Part
from gomboc_cad.products.closures.records import ClosureLayout, ClosureSite
from gomboc_cad.products.closures.spec import DowelsSpec
from gomboc_cad.products.fasteners import dowel_pin
from gomboc_cad.products.materials import load_material
from gomboc_cad.products.placement import boss_radius_from_axis_mm

_METAL = (0.62, 0.64, 0.66)


def lay_out_dowels(spec: DowelsSpec, site: ClosureSite) -> ClosureLayout:
    """Put the pins as far out as the wall behind their holes stays whole.

    Raises:
        GeometryError: If they do not fit at the seam or meet something.
    """
    places = [_place(spec, site, index) for index in range(spec.count)]
    columns = tuple(site.column(place, spec.boss_radius_mm) for place in places)
    site.check_clear("closure pin", columns)
    half = spec.half_hole_mm
    return ClosureLayout(
        site=site,
        seam=site.seam(),
        bosses=columns,
        holes=tuple(site.upright(place, half, half, 0.5 * spec.diameter_mm) for place in places),
        parts=_pins(spec, site, places),
        columns=columns,
        notes=(
            f"Press or glue the {spec.count} pins into one part, put glue on the seam, and push the other "
            "part on; the outer surface stays whole.",
        ),
    )


def _place(spec: DowelsSpec, site: ClosureSite, index: int) -> tuple[float, float]:
    half = spec.half_hole_mm
    seam = site.seam_height_mm
    angle = math.radians(spec.angle_deg) + 2.0 * math.pi * index / spec.count
    depth = site.shell.wall_mm + 0.5 * spec.diameter_mm
    heights = (seam - half, seam, seam + half)
    radius = boss_radius_from_axis_mm(site.body, site.frame, angle, heights, depth)
    return radius * math.cos(angle), radius * math.sin(angle)


def _pins(spec: DowelsSpec, site: ClosureSite, places: list[tuple[float, float]]) -> tuple[Part, ...]:
    pin = dowel_pin(spec.diameter_mm, spec.length_mm)
    standard = f"ISO 8734 {spec.diameter_mm:g} x {spec.length_mm:g}"
    material = load_material(spec.material)
    return tuple(
        Part.homogeneous(f"pin-{number}", pin.moved(site.location(place, 0.0)), material, _METAL, standard)
        for number, place in enumerate(places, start=1)
    )
