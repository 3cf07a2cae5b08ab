"""The recipe of the IMU calibration housing: from a spec to parts whose centre of mass is where it should be.

Everything inside the outer surface (cavity, standoffs, closure, board, battery and seam) is one rigid core,
whose place brings the centre of mass to its target; what opens the outer surface stays where the drill map
allows it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from gomboc_cad.body import Body, mass_properties
from gomboc_cad.body.sphere import unit
from gomboc_cad.equilibria import convexity, smooth_census
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.products.assembly import Assembly, center_of_mass
from gomboc_cad.products.design import ProductDesign
from gomboc_cad.products.imu_housing.battery_mount import TAPE_MM
from gomboc_cad.products.imu_housing.boards import Board
from gomboc_cad.products.imu_housing.housing_calibration import MountedBoard, calibration_documents
from gomboc_cad.products.imu_housing.layout import HousingContents, HousingLayout, lay_out
from gomboc_cad.products.imu_housing.parts import BATTERY, BOARD, PRODUCT, HousingParts
from gomboc_cad.products.imu_housing.spec import ImuHousingSpec
from gomboc_cad.products.loads import UncertainLoad, load_uncertainties
from gomboc_cad.products.materials import Material
from gomboc_cad.products.openings.placed_opening import PlacedOpening, displaced
from gomboc_cad.products.placement import RestFrame, parting_of
from gomboc_cad.products.placing.com_placement import ComPlacement, CoreMove, com_target, converge, place_com
from gomboc_cad.products.process import least_wall_mm
from gomboc_cad.progress import Progress, silent
from gomboc_cad.solid import hollow

_SOLID_NOTE = (
    "Print or machine both halves without infill or voids: the centre of mass counts on the full density of "
    "the material."
)


@dataclass(frozen=True, kw_only=True)
class HousingDesign(ProductDesign):
    """A finished housing, not yet written.

    Attributes:
        layout: Where everything is, the core not moved.
        mounted: The board in its place.
        min_wall_left_mm: What the moved cavity leaves of the wall at its thinnest place.
    """

    layout: HousingLayout
    mounted: MountedBoard
    min_wall_left_mm: float


def design_imu_housing(
    spec: ImuHousingSpec, spec_folder: Path | None = None, progress: Progress = silent
) -> HousingDesign:
    """Make the housing's parts and place its centre of mass.

    Args:
        spec: A checked spec.
        spec_folder: Folder that the names of a user's own data files start from.
        progress: Called with the name of each stage as it begins.

    Raises:
        SpecError: If a name or a size in the spec is not available, or the wall is too thin for the process.
        GeometryError: If something does not fit, or the centre of mass cannot be brought to its target.
        CensusError: If the best place for the centre of mass is asked for on a body that has none.
    """
    progress("laying out the interior")
    body = spec.body.body()
    contents = HousingContents.of(spec, spec_folder)
    least_wall = least_wall_mm(spec.shell, spec_folder)
    target = com_target(spec.com.target, body)
    layout = lay_out(spec, body, target, contents, least_wall)
    parts = HousingParts.of(spec, layout, contents)

    progress("placing the centre of mass")
    placement = _first_placement(parts, target, spec.shell.wall_mm - least_wall)

    progress("making the solids")
    placement, assembly = _converged(parts, placement)

    progress("making the meshes")
    assembly = replace(assembly, parts=parts.with_meshes(assembly.parts, placement))
    mounted = _mounted(contents.board, layout, placement)
    parting = parting_of(layout.frame, spec.split, placement.core_shift_mm)
    return HousingDesign(
        spec=spec,
        body=body,
        frame=layout.frame,
        assembly=assembly,
        placement=placement,
        openings=displaced((*parts.closure(placement).openings, *layout.fixed_openings), parting),
        uncertainties=load_uncertainties(
            assembly, mounted.loads, _soft_direction(body, assembly.com_mm, layout.frame)
        ),
        loads=mounted.loads,
        upper_parts=parts.upper_parts(assembly.parts, placement),
        parting_direction=layout.frame.up,
        parting=parting,
        documents=partial(calibration_documents, assembly, mounted, spec.tolerances),
        summary={
            "core_shift_mm": list(placement.core_shift_mm),
            "min_wall_left_mm": parts.hollow(placement).thinnest_wall_mm,
        },
        notes=_notes(spec, layout),
        layout=layout,
        mounted=mounted,
        min_wall_left_mm=parts.hollow(placement).thinnest_wall_mm,
    )


def _first_placement(parts: HousingParts, target: Vector, limit_mm: float) -> ComPlacement:
    """Place the core by its exact mass properties and those of the openings to first order.

    With ρ the shell's density, V₀ c₀ of the full body, V₁ c₁ of all that is empty in the core and mᵢ pᵢ the
    contents, a core moved by s has the moment `ρ (V₀ c₀ − V₁ (c₁ + s)) + Σ mᵢ (pᵢ + s)`.
    """
    unmoved, plastic = parts.layout.hollow, parts.plastic
    full, empty = mass_properties(unmoved.body), hollow.void_properties(unmoved)
    contents = [(part.mass_g, part.com_mm) for part in (*parts.unmoved, *parts.layout.closure.parts)]
    outer_g, empty_g = plastic.mass_g(full.volume_mm3), plastic.mass_g(empty.volume_mm3)
    lever = sum(mass for mass, _ in contents) - empty_g
    weighed = [
        (outer_g, full.com_mm),
        (-empty_g, empty.com_mm),
        *contents,
        *(_taken_away(opening, parts.spec.shell.wall_mm, plastic) for opening in parts.layout.fixed_openings),
    ]
    fixed = sum(mass for mass, _ in weighed), as_vector(center_of_mass(weighed))
    return place_com(
        fixed,
        target,
        CoreMove(lever, limit_mm),
        parts.layout.trim_sites,
        parts.spec.trim,
        plastic.density_g_cm3,
    )


def _taken_away(opening: PlacedOpening, wall_mm: float, plastic: Material) -> tuple[float, Vector]:
    """Mass, negative, and centre of what an opening takes from the wall."""
    mouth, base = np.array(opening.position_mm), np.array(opening.tool.base_mm)
    arm = base - mouth
    depth = min(float(np.linalg.norm(arm)), wall_mm)
    mass_g = plastic.mass_g(math.pi * opening.tool.radius_mm**2 * depth)
    return -mass_g, as_vector(mouth + 0.5 * depth * unit(arm))


def _converged(parts: HousingParts, placement: ComPlacement) -> tuple[ComPlacement, Assembly]:
    """Make the solids, weigh them, and correct the placement until the centre of mass is on its target."""
    made: list[Assembly] = []

    def weighed(tried: ComPlacement) -> tuple[float, Vector]:
        made.append(Assembly(PRODUCT, parts.made(tried), tried.target_mm))
        return made[-1].mass_g, made[-1].com_mm

    return converge(weighed, placement), made[-1]


def _mounted(board: Board, layout: HousingLayout, placement: ComPlacement) -> MountedBoard:
    loads = [UncertainLoad(BOARD, board.mass_tolerance_g, board.com_tolerance_mm)]
    if layout.battery:
        battery = layout.battery.battery
        loads.append(UncertainLoad(BATTERY, battery.mass_tolerance_g, battery.com_tolerance_mm))
    origin = layout.board_origin_mm + placement.core_shift_mm
    return MountedBoard(board, layout.frame, as_vector(origin), tuple(loads))


def _soft_direction(body: Body, com_mm: Vector, frame: RestFrame) -> Vector:
    """Direction along which an error tilts the rest most; any level one where there is no smooth census."""
    if not convexity(body).strictly_convex:
        return frame.first
    return smooth_census(body, com_mm, margins=False).rest.soft_direction


def _notes(spec: ImuHousingSpec, layout: HousingLayout) -> tuple[str, ...]:
    notes = [_SOLID_NOTE, *layout.closure.notes]
    if layout.battery:
        half = "upper" if layout.battery.in_upper else "lower"
        notes.append(
            f"Tape the battery {layout.battery.battery.name!r} to its pedestal in the {half} half with "
            f"double-sided tape {TAPE_MM:g} mm thick; its lead is not counted."
        )
    if spec.mark.text and layout.mark is None:
        notes.append("There is no mark: the body is not strictly convex, so no place for it is known.")
    if layout.port:
        notes.append(layout.port.note(spec.cable))
    return tuple(notes)
