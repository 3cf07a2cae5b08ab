"""The recipe of the buoy: from a spec to parts with their centre of mass in its place, and how they float."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from gomboc_cad.body import mass_properties
from gomboc_cad.equilibria import smooth_census
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.products.assembly import Assembly, Part, center_of_mass
from gomboc_cad.products.batteries import load_battery
from gomboc_cad.products.buoy.contents import Contents, buoy_contents, with_ballast
from gomboc_cad.products.buoy.floating import (
    NOT_MODELLED,
    Floating,
    check_displacement,
    float_buoy,
    floating_summary,
    hydrostatics_document,
    water_of,
)
from gomboc_cad.products.buoy.layout import BuoyLayout, lay_out_buoy
from gomboc_cad.products.buoy.spec import BuoySpec
from gomboc_cad.products.closures.plugs import plug_parts
from gomboc_cad.products.design import ProductDesign
from gomboc_cad.products.loads import load_uncertainties
from gomboc_cad.products.materials import Material, load_material
from gomboc_cad.products.openings.placed_opening import PlacedOpening, displaced
from gomboc_cad.products.placement import parting_of
from gomboc_cad.products.placing.com_placement import (
    ComPlacement,
    CoreMove,
    Cost,
    com_target,
    converge,
    place_com,
)
from gomboc_cad.products.process import least_wall_mm
from gomboc_cad.progress import Progress, silent
from gomboc_cad.solid import hollow
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.hollow import Seam, Tool

LOWER, UPPER, PLUG = "buoy-lower", "buoy-upper", "buoy-plug"
HYDROSTATICS_FILE = "hydrostatics.json"

_COLORS = {LOWER: (0.93, 0.55, 0.13), UPPER: (0.96, 0.76, 0.20)}

_COARSE_SHARE = 3e-4
"""Sag of the meshes that the first guess of the masses is taken from, in units of R₀."""

_NUDGE_MM = 0.5


def design_buoy(
    spec: BuoySpec, spec_folder: Path | None = None, progress: Progress = silent
) -> ProductDesign:
    """Make the buoy's parts, place its centre of mass, and find out how it floats.

    Args:
        spec: A checked spec.
        spec_folder: Folder that the names of a user's own data files start from.
        progress: Called with the name of each stage as it begins.

    Raises:
        SpecError: If a name or a size in the spec is not available.
        GeometryError: If something does not fit, the centre of mass cannot be brought to its target, or the
            buoy is heavier than its displacement.
    """
    progress("laying out the interior")
    body, water = spec.body.body(), water_of(spec.water)
    battery = load_battery(spec.battery.type, spec_folder)
    core_limit = spec.shell.wall_mm - least_wall_mm(spec.shell, spec_folder)
    target = com_target(spec.com.target, body)
    layout = lay_out_buoy(spec, body, battery, target)

    progress("placing the centre of mass")
    plastic = load_material(spec.shell.material)
    shell, taken_g = _first_guess(layout, plastic)
    contents = with_ballast(buoy_contents(spec, layout, battery), spec, layout, shell, target)
    masses = [shell, *contents.masses]
    total = sum(mass for mass, _ in masses)
    check_displacement(total, mass_properties(body).volume_mm3, water)
    core = CoreMove(sum(part.mass_g for part in contents.moving) - taken_g, core_limit)
    placement = place_com((total, as_vector(center_of_mass(masses))), target, core)

    progress("making the solids")
    workshop = _Workshop(spec, layout, plastic, contents, target)
    placement = converge(workshop.measure, placement)
    placement = _with_cost(placement, contents.ballast_cost)

    progress("making the meshes")
    assembly = workshop.assembly(placement.core_shift_mm, meshed=True)
    closure = layout.closure.moved(np.array(placement.core_shift_mm))
    parting = parting_of(layout.frame, spec.split, placement.core_shift_mm)
    openings = displaced((*layout.fixed_openings, *closure.openings), parting)
    floating = float_buoy(body, _flooded(openings), assembly, layout.frame.up, water)
    soft = smooth_census(body, assembly.com_mm, margins=False).rest.soft_direction
    loads = contents.loads(spec, battery)
    return ProductDesign(
        spec=spec,
        body=body,
        frame=layout.frame,
        assembly=assembly,
        placement=placement,
        openings=openings,
        uncertainties=load_uncertainties(assembly, loads, soft),
        loads=loads,
        upper_parts=workshop.upper_parts(assembly.parts),
        parting_direction=layout.frame.up,
        parting=parting,
        documents=lambda verdict: {HYDROSTATICS_FILE: hydrostatics_document(floating, assembly, verdict)},
        summary={"floating": floating_summary(floating)},
        notes=(floating.sentence, *_notes(spec, layout, floating), *closure.notes),
    )


def _first_guess(layout: BuoyLayout, plastic: Material) -> tuple[tuple[float, Vector], float]:
    """What the made parts weigh, and what the core's place does to them, from coarse meshes.

    Returns:
        Mass and centre of mass of both halves with the core where it was laid out, and the mass of material
        whose moment a move of the core takes away.
    """
    sag_um = 1e3 * _COARSE_SHARE * layout.hollow.body.radius_mm
    up = np.array(layout.frame.up)
    grooved = replace(layout.hollow, holes=(*layout.hollow.holes, *layout.closure.seam.groove))
    moved = replace(grooved, core_shift_mm=as_vector(_NUDGE_MM * up))
    masses = [hollow.mesh(body, sag_um).mass() for body in (grooved, moved)]
    moments = [plastic.mass_g(mass.volume_mm3) * float(up @ np.array(mass.com_mm)) for mass in masses]
    shell = plastic.mass_g(masses[0].volume_mm3), masses[0].com_mm
    return shell, (moments[0] - moments[1]) / _NUDGE_MM


def _with_cost(placement: ComPlacement, ballast: Cost | None) -> ComPlacement:
    """Count the ballast among the variables that bring the centre of mass to its target."""
    if ballast is None:
        return placement
    sentence = (
        f"{placement.sentence} The ballast is turned to a height of {ballast.amount:.1f} mm, of "
        f"{ballast.limit:.1f} mm that its bay takes: it adds {ballast.mass_g:.0f} g and lowers the centre of "
        f"mass by {1e-3 * ballast.com_effect_um:.3g} mm."
    )
    return replace(placement, costs=(*placement.costs, ballast), sentence=sentence)


class _Workshop:
    """Makes the two halves with the core at a place and puts everything together."""

    def __init__(
        self, spec: BuoySpec, layout: BuoyLayout, plastic: Material, contents: Contents, target_mm: Vector
    ) -> None:
        self._spec, self._layout, self._plastic = spec, layout, plastic
        self._contents, self._target_mm = contents, target_mm
        self._last: tuple[Vector, tuple[Part, ...]] | None = None

    def measure(self, placement: ComPlacement) -> tuple[float, Vector]:
        """Mass and centre of mass of the assembly that a placement makes."""
        assembly = self.assembly(placement.core_shift_mm)
        return assembly.mass_g, assembly.com_mm

    def _seam(self, shift_mm: Vector) -> Seam:
        """The seam of the moved core."""
        return replace(self._layout.closure, openings=(), parts=()).moved(np.array(shift_mm)).seam

    def _halves(self, shift_mm: Vector) -> tuple[Part, ...]:
        """Both halves, without meshes; the last ones that were made are kept."""
        if self._last is None or self._last[0] != shift_mm:
            whole = hollow.brep(self._layout.hollow_at(shift_mm))
            solids = hollow.split_brep(whole, self._seam(shift_mm))
            halves = tuple(
                Part.homogeneous(name, solid, self._plastic, _COLORS[name])
                for name, solid in zip((LOWER, UPPER), solids, strict=True)
            )
            self._last = shift_mm, halves
        return self._last[1]

    def assembly(self, shift_mm: Vector, *, meshed: bool = False) -> Assembly:
        """All parts in place, the made ones with mesh and boundary if these are wanted."""
        layout, sag_um = self._layout, self._spec.mesh.sag_um
        made = list(self._halves(shift_mm))
        if meshed:
            body, seam = layout.hollow_at(shift_mm), self._seam(shift_mm)
            meshes = hollow.split_mesh(hollow.mesh(body, sag_um), seam, sag_um)
            boundaries = Boundary.of_hollow(body).split(seam)
            up = np.array(layout.frame.up)
            made = [
                # Printed with the seam on the bed.
                replace(part, mesh=mesh, boundary=boundary, print_up=as_vector(side * up))
                for part, mesh, boundary, side in zip(made, meshes, boundaries, (-1.0, 1.0), strict=True)
            ]
        if layout.closure.plugs:
            closure = layout.closure.moved(np.array(shift_mm))
            made += plug_parts(closure, self._plastic, _COLORS[UPPER], sag_um, PLUG)
        parts = self._stepped((*made, *self._contents.at(np.array(shift_mm))))
        return Assembly("buoy", parts, self._target_mm)

    def upper_parts(self, parts: Iterable[Part]) -> frozenset[str]:
        """Names of the parts that go with the upper half."""
        layout = self._layout
        names = {UPPER, *layout.closure.upper_parts}
        if layout.port is not None and layout.port.in_upper:
            names |= {"port-plug", "port-seal"}
        plugs = (part for part in parts if part.name.startswith(PLUG))
        names |= {plug.name for plug in plugs if np.dot(plug.com_mm, layout.frame.up) > layout.seam_mm}
        return frozenset(names)

    def _stepped(self, parts: tuple[Part, ...]) -> tuple[Part, ...]:
        """The parts, those of the upper half displaced by the seam's gap and step."""
        parting = parting_of(self._layout.frame, self._spec.split)
        if not parting.is_displaced:
            return parts
        upper, shift = self.upper_parts(parts), np.array(parting.shift_mm)
        return tuple(part.moved(shift) if part.name in upper else part for part in parts)


def _flooded(openings: tuple[PlacedOpening, ...]) -> tuple[Tool, ...]:
    """What water enters: every opening that is not plugged flush."""
    return tuple(opening.tool for opening in openings if opening.state != "plugged")


def _notes(spec: BuoySpec, layout: BuoyLayout, floating: Floating) -> tuple[str, ...]:
    """What a user should know before the buoy is put into water."""
    seal = layout.seal
    notes = [
        f"Not modelled in how it floats: {'; '.join(NOT_MODELLED)}.",
        f"The seam is sealed by the {seal.standard}, squeezed by {100.0 * seal.squeeze:.0f} %: a design "
        "figure and no proof of tightness; face and groove of a printed part have to be machined or coated.",
        "Battery and electronics are held sideways by their tube; hold them down with a strap or foam, whose "
        "mass is not counted.",
    ]
    if layout.mooring is not None:
        notes.append(
            f"The eye bolt DIN 580 {spec.mooring.eye} is screwed {layout.mooring.eye.thread_length_mm:g} mm "
            "into the shell's own material; how much it holds is not computed."
        )
        notes.append(
            "Were all recesses full of trapped air instead of water, the metacentric height upright would be "
            f"{floating.gm_with_air_mm:.3g} mm in place of {floating.upright.gm_mm[0]:.3g} mm."
        )
    return tuple(notes)
