"""What is bought for the buoy, in place: battery, electronics, O-ring, eye bolt, screw plug and ballast."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from build123d import Align, Cylinder

from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.assembly import Part
from gomboc_cad.products.batteries import Battery
from gomboc_cad.products.buoy.fittings import Mooring, Port
from gomboc_cad.products.buoy.layout import BuoyLayout
from gomboc_cad.products.buoy.spec import BuoySpec
from gomboc_cad.products.loads import UncertainLoad
from gomboc_cad.products.materials import load_material
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.products.placing.com_placement import Cost
from gomboc_cad.solid.mass import solid_mass

Masses = list[tuple[float, Vector]]

_METAL, _COPPER, _RUBBER = (0.62, 0.64, 0.66), (0.72, 0.45, 0.20), (0.12, 0.12, 0.13)
_BLUE, _GREEN = (0.20, 0.30, 0.55), (0.10, 0.35, 0.20)

_TURNED_MM = 0.1
"""Step of the ballast's height: what a lathe holds without effort."""

_BASE = (Align.CENTER, Align.CENTER, Align.MIN)


@dataclass(frozen=True)
class Contents:
    """Bought parts, where the unmoved core has them.

    Attributes:
        moving: Those that move with the core.
        fixed: Those in openings of the outer surface, which stay.
        ballast_cost: What the ballast does for the centre of mass; None without ballast.
    """

    moving: tuple[Part, ...]
    fixed: tuple[Part, ...]
    ballast_cost: Cost | None = None

    @property
    def masses(self) -> Masses:
        """Mass and place of every part."""
        return [(part.mass_g, part.com_mm) for part in (*self.moving, *self.fixed)]

    def at(self, shift_mm: Array) -> tuple[Part, ...]:
        """All parts, with the core moved by a vector of the body's frame, shape (3,)."""
        return (*(part.moved(shift_mm) for part in self.moving), *self.fixed)

    def loads(self, spec: BuoySpec, battery: Battery) -> tuple[UncertainLoad, ...]:
        """Those whose mass and place are not exactly known; the battery can move in its tube."""
        bay, ballast = spec.electronics, spec.ballast
        known = {
            "battery": (battery.mass_tolerance_g, battery.com_tolerance_mm + spec.battery.clearance_mm),
            "electronics": (bay.mass_tolerance_g, bay.com_tolerance_mm + spec.battery.clearance_mm),
            "ballast": (ballast.mass_tolerance_g, ballast.clearance_mm),
        }
        return tuple(
            UncertainLoad(part.name, *known[part.name]) for part in self.moving if part.name in known
        )


def buoy_contents(spec: BuoySpec, layout: BuoyLayout, battery: Battery) -> Contents:
    """Everything that is bought, without the ballast.

    Raises:
        SpecError: If a material is not known.
    """
    moving = (
        _battery(layout, battery),
        _electronics(spec, layout, battery),
        _o_ring(spec, layout),
        *layout.closure.parts,
    )
    eye = () if layout.mooring is None else (_eye_bolt(spec, layout, layout.mooring),)
    plug = () if layout.port is None else _screw_plug(spec, layout.port)
    return Contents(moving, (*eye, *plug))


def with_ballast(
    contents: Contents, spec: BuoySpec, layout: BuoyLayout, shell: tuple[float, Vector], target_mm: Vector
) -> Contents:
    """Add the ballast ring, as tall as the centre of mass or the spec wants it.

    Args:
        contents: Everything else that is bought.
        spec: What is asked for.
        layout: Where things are.
        shell: Mass and centre of mass of the made parts.
        target_mm: Where the centre of mass is to be.

    Raises:
        GeometryError: If the bay is too small for it.
        SpecError: If its material is not known.
    """
    material = load_material(spec.ballast.material)
    inner, outer = layout.ballast_radii_mm
    per_height = material.mass_g(math.pi * (outer**2 - inner**2))
    masses = [shell, *contents.masses]
    up = np.array(layout.frame.up)
    if spec.ballast.mass_g == "auto":
        moment = sum(mass * float(up @ np.subtract(place, target_mm)) for mass, place in masses)
        wanted = _ring_height(moment / per_height, layout.ballast_seat_mm - float(up @ np.array(target_mm)))
    else:
        wanted = spec.ballast.mass_g / per_height
    room = layout.battery_seat_mm - layout.ballast_seat_mm
    if wanted > room:
        raise GeometryError(
            f"The ballast does not fit: its bay takes {room:.1f} mm of {spec.ballast.material}, "
            f"{per_height * room:.0f} g, and {'no height' if math.isinf(wanted) else f'{wanted:.1f} mm'} "
            "would do; make ballast.outer_diameter_mm or ballast.bay_height_mm larger, take a denser "
            "material, or bring com.target nearer to the middle."
        )
    height = _TURNED_MM * round(wanted / _TURNED_MM)
    if height == 0.0:
        return contents
    ring = Cylinder(outer, height, align=_BASE)
    if inner > 0.0:
        ring = ring - Cylinder(inner, 3.0 * height)
    solid = ring.solid().moved(layout.frame.location(layout.on_stack(layout.ballast_seat_mm)))
    size = f"turned, {2.0 * outer:g} x {2.0 * inner:g} x {height:.1f} mm"
    part = Part.homogeneous("ballast", solid, material, _METAL, size)
    others = sum(mass for mass, _ in masses)
    effect = 1e3 * part.mass_g * float(np.linalg.norm(np.subtract(part.com_mm, target_mm))) / others
    cost = Cost("ballast", height, "mm", part.mass_g, effect, room, height > room - _TURNED_MM)
    return replace(contents, moving=(*contents.moving, part), ballast_cost=cost)


def _ring_height(moment_per_height: float, base: float) -> float:
    """Height of a ring that brings a moment to zero.

    A ring of area A and density ρ whose underside is z₀ over the target adds `ρ A h (z₀ + h/2)` to the moment
    M of everything else about the target; h is the smaller root of `h²/2 + z₀ h + M/(ρ A) = 0`.

    Args:
        moment_per_height: M/(ρ A).
        base: z₀.

    Returns:
        The height: zero where the centre of mass is low enough without it, infinite where no ring does.
    """
    if moment_per_height <= 0.0:
        return 0.0
    square = base**2 - 2.0 * moment_per_height
    return -base - math.sqrt(square) if base < 0.0 and square >= 0.0 else math.inf


def _battery(layout: BuoyLayout, battery: Battery) -> Part:
    solid = battery.solid(layout.frame, layout.on_stack(layout.battery_seat_mm))
    mass = solid_mass(solid)
    return Part("battery", battery.name, battery.mass_g, mass.com_mm, solid, mass, False, battery.name, _BLUE)


def _electronics(spec: BuoySpec, layout: BuoyLayout, battery: Battery) -> Part:
    """The bay as a cylinder, with mass and centre of mass of what is in it."""
    bay = spec.electronics
    radius = battery.outline_radius_mm
    seat = layout.on_stack(layout.electronics_seat_mm)
    solid = Cylinder(radius, bay.height_mm, align=_BASE).solid().moved(layout.frame.location(seat))
    mass = solid_mass(solid)
    com = as_vector(np.array(mass.com_mm) + layout.frame.point(*bay.com_mm))
    size = f"bay, {2.0 * radius:.1f} x {bay.height_mm:g} mm"
    return Part("electronics", "electronics", bay.mass_g, com, solid, mass, False, size, _GREEN)


def _o_ring(spec: BuoySpec, layout: BuoyLayout) -> Part:
    groove = layout.frame.point(0.0, 0.0, layout.seam_mm - layout.seal.groove_depth_mm)
    ring = layout.seal.squeezed_solid().moved(layout.frame.location(groove))
    return Part.homogeneous(
        "o-ring", ring, load_material(spec.flange.material), _RUBBER, layout.seal.standard
    )


def _eye_bolt(spec: BuoySpec, layout: BuoyLayout, mooring: Mooring) -> Part:
    solid = mooring.eye.solid().moved(layout.frame.location(layout.on_stack(mooring.seat_mm)))
    mass = solid_mass(solid)
    material = load_material(spec.mooring.material).name
    standard = f"DIN 580 {spec.mooring.eye}"
    return Part("eye-bolt", material, mooring.eye.mass_g, mass.com_mm, solid, mass, False, standard, _METAL)


def _screw_plug(spec: BuoySpec, port: Port) -> tuple[Part, Part]:
    """The plug on its seal ring, at the bottom of the counterbore."""
    outwards = np.array(port.counterbore.tool.direction)
    frame = RestFrame.from_rest(as_vector(-outwards))
    bottom = np.array(port.counterbore.tool.base_mm)
    inner, outer, thickness = port.plug.seal_mm
    plug = port.plug.solid().moved(frame.location(bottom + thickness * outwards))
    seal = port.plug.seal_solid().moved(frame.location(bottom))
    metal, copper = load_material(spec.port.material), load_material("copper")
    return (
        Part.homogeneous("port-plug", plug, metal, _METAL, f"DIN 908 {spec.port.plug}"),
        Part.homogeneous(
            "port-seal", seal, copper, _COPPER, f"DIN 7603 A {inner:g} x {outer:g} x {thickness:g}"
        ),
    )
