"""The recipe of the IMU calibration housing: from a spec to parts whose centre of mass is where it should be.

Everything inside the outer surface (cavity, standoffs, pins, board and seam) is one rigid core. The centre
of mass of the assembly is an exactly linear function of the core's position, so one linear equation
places it; the finished solids are then measured.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from build123d import Location

from gomboc_cad.body import Body, mass_properties
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.assembly import Assembly, Part, center_of_mass
from gomboc_cad.products.boards import Board, load_board
from gomboc_cad.products.fasteners import Insert, Screw, dowel_pin, heat_set_insert, pan_head_screw
from gomboc_cad.products.housing_layout import HousingLayout, lay_out
from gomboc_cad.products.imu_housing_spec import ImuHousingSpec
from gomboc_cad.products.materials import Material, load_material
from gomboc_cad.products.mounting import board_solid
from gomboc_cad.progress import Progress, silent
from gomboc_cad.solid import hollow
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.mesh import Mesh

LOWER, UPPER = "imu-housing-lower", "imu-housing-upper"
_HALF_COLORS = {LOWER: (0.27, 0.51, 0.71), UPPER: (0.74, 0.83, 0.90)}
_METAL, _BRASS, _LAMINATE = (0.62, 0.64, 0.66), (0.80, 0.66, 0.30), (0.10, 0.35, 0.20)


@dataclass(frozen=True)
class HousingDesign:
    """A finished housing, not yet written.

    Attributes:
        spec: What was asked for.
        body: The outer shape.
        board: The sensor board.
        layout: Where everything is.
        assembly: All parts in place.
        meshes: Meshes of the two halves by name.
        min_wall_left_mm: What the moved cavity leaves of the wall at its thinnest place.
    """

    spec: ImuHousingSpec
    body: Body
    board: Board
    layout: HousingLayout
    assembly: Assembly
    meshes: dict[str, Mesh]
    min_wall_left_mm: float


@dataclass(frozen=True)
class _Purchases:
    """What is bought, looked up once."""

    board: Board
    insert: Insert
    screw: Screw
    plastic: Material
    brass: Material
    steel: Material
    pin: Material


def design_imu_housing(
    spec: ImuHousingSpec, spec_folder: Path | None = None, progress: Progress = silent
) -> HousingDesign:
    """Make the housing's parts and place its centre of mass.

    Args:
        spec: A checked spec.
        spec_folder: Folder that a board's file name starts from.
        progress: Called with the name of each stage as it begins.

    Raises:
        SpecError: If a name or a size in the spec is not available.
        GeometryError: If something does not fit, or the centre of mass cannot be brought to its target.
    """
    progress("laying out the interior")
    body = spec.body.body()
    bought = _Purchases(
        board=load_board(spec.board.type, spec_folder),
        insert=heat_set_insert(spec.standoffs),
        screw=pan_head_screw(spec.standoffs),
        plastic=load_material(spec.shell.material),
        brass=load_material("brass"),
        steel=load_material("steel"),
        pin=load_material(spec.closure.material),
    )
    layout = lay_out(spec, body, bought.board, bought.insert, bought.screw)
    target = mass_properties(body).com_mm if spec.com.target == "centroid" else spec.com.target

    progress("placing the centre of mass")
    contents = _contents(spec, layout, bought)
    shift = _core_shift(body, layout, contents, bought.plastic, target)
    left = spec.shell.wall_mm - float(np.linalg.norm(shift))
    _check_reach(spec, shift, left)
    layout = layout.moved(shift)
    contents = [_moved(part, shift) for part in contents]

    progress("making the solids")
    seam = layout.seam_point_mm
    lower, upper = hollow.split_brep(hollow.brep(layout.hollow), seam, layout.frame.up)
    halves = [
        Part.homogeneous(name, solid, bought.plastic, _HALF_COLORS[name])
        for name, solid in ((LOWER, lower), (UPPER, upper))
    ]
    assembly = Assembly("imu-housing", (*halves, *contents), target)

    progress("making the meshes")
    meshes = hollow.split_mesh(hollow.mesh(layout.hollow, spec.mesh.sag_um), seam, layout.frame.up)
    return HousingDesign(
        spec, body, bought.board, layout, assembly, dict(zip((LOWER, UPPER), meshes, strict=True)), left
    )


def _contents(spec: ImuHousingSpec, layout: HousingLayout, bought: _Purchases) -> list[Part]:
    """The board, inserts, screws and pins where the unmoved core has them."""
    frame = layout.frame
    board, seat = bought.board, layout.seat_height_mm
    corner = layout.board_corner_mm
    board_com = frame.point(corner[0] + board.com_mm[0], corner[1] + board.com_mm[1], seat + board.com_mm[2])
    laminate = board_solid(board).moved(frame.location(frame.point(*corner, seat)))
    parts = [
        Part(
            "board",
            board.name,
            board.mass_g,
            as_vector(board_com),
            laminate,
            solid_mass(laminate),
            False,
            board.name,
            _LAMINATE,
        )
    ]
    insert, screw = bought.insert, bought.screw
    for index, (first, second) in enumerate(layout.hole_places_mm, start=1):
        sunk = insert.solid.moved(frame.location(frame.point(first, second, seat)))
        driven = screw.solid.moved(frame.location(frame.point(first, second, seat + board.thickness_mm)))
        parts.append(Part.homogeneous(f"insert-{index}", sunk, bought.brass, _BRASS, insert.standard))
        parts.append(Part.homogeneous(f"screw-{index}", driven, bought.steel, _METAL, screw.standard))
    pin = dowel_pin(spec.closure)
    standard = f"ISO 8734 {spec.closure.diameter_mm:g} x {spec.closure.length_mm:g}"
    for index, (first, second) in enumerate(layout.pin_places_mm, start=1):
        across = pin.moved(frame.location(frame.point(first, second, layout.seam_height_mm)))
        parts.append(Part.homogeneous(f"pin-{index}", across, bought.pin, _METAL, standard))
    return parts


def _core_shift(
    body: Body, layout: HousingLayout, contents: list[Part], plastic: Material, target: Vector
) -> Array:
    """Solve for the core's displacement s that brings the centre of mass to the target.

    With ρ the shell's density, V₀ c₀ of the full body, V₁ c₁ of all that is empty in it and mᵢ pᵢ the
    contents, `M c = ρ (V₀ c₀ − V₁ (c₁ + s)) + Σ mᵢ (pᵢ + s)`, M the constant total mass.
    """
    full = mass_properties(body)
    empty = hollow.void_properties(layout.hollow)
    outer_mass, empty_mass = plastic.mass_g(full.volume_mm3), plastic.mass_g(empty.volume_mm3)
    content_mass = sum(part.mass_g for part in contents)
    lever = empty_mass - content_mass
    if abs(lever) < 0.05 * empty_mass:
        raise GeometryError(
            "Moving the cavity does not move the centre of mass, because its contents weigh as much as "
            "the material it displaces; choose another material or wall."
        )
    moment = outer_mass * np.array(full.com_mm) - empty_mass * np.array(empty.com_mm)
    moment += content_mass * center_of_mass([(part.mass_g, part.com_mm) for part in contents])
    total = outer_mass - empty_mass + content_mass
    result: Array = (moment - total * np.array(target)) / lever
    return result


def _check_reach(spec: ImuHousingSpec, shift: Array, left: float) -> None:
    """Refuse a core displacement that the wall does not allow, and say how far it could go."""
    if left >= spec.shell.min_wall_mm:
        return
    needed = float(np.linalg.norm(shift))
    allowed = spec.shell.wall_mm - spec.shell.min_wall_mm
    raise GeometryError(
        f"The centre of mass cannot be brought to its target: the cavity would have to move {needed:.3g} "
        f"mm, but a wall of {spec.shell.wall_mm:g} mm with at least {spec.shell.min_wall_mm:g} mm left "
        f"allows {allowed:.3g} mm, which is {100.0 * allowed / needed:.0f} % of the way; make the wall "
        "thicker, the payload lighter, or com.target nearer."
    )


def _moved(part: Part, shift: Array) -> Part:
    """The same part, moved."""
    return replace(
        part,
        com_mm=as_vector(np.add(part.com_mm, shift)),
        solid=part.solid.moved(Location(tuple(shift))),
        measured=replace(part.measured, com_mm=as_vector(np.add(part.measured.com_mm, shift))),
    )
