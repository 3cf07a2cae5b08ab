"""The parts of a housing: what is bought for it, and what is made around that."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from build123d import Solid

from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.products.assembly import Part
from gomboc_cad.products.closures.plugs import plug_parts
from gomboc_cad.products.closures.records import ClosureLayout
from gomboc_cad.products.imu_housing.layout import HousingContents, HousingLayout
from gomboc_cad.products.imu_housing.mounting import board_solid
from gomboc_cad.products.imu_housing.spec import ImuHousingSpec
from gomboc_cad.products.materials import Material, load_material
from gomboc_cad.products.placement import Parting, parting_of
from gomboc_cad.products.placing.com_placement import ComPlacement
from gomboc_cad.products.placing.trim import trim_parts
from gomboc_cad.solid import hollow
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.hollow import HollowBody
from gomboc_cad.solid.mass import solid_mass

PRODUCT = "imu-housing"
LOWER, UPPER, CABLE_PLUG = f"{PRODUCT}-lower", f"{PRODUCT}-upper", f"{PRODUCT}-cable-plug"
BOARD, BATTERY = "board", "battery"

_CLOSURE_PLUG = f"{PRODUCT}-plug"

_LOWER_COLOR, _UPPER_COLOR, _PLUG_COLOR = (0.27, 0.51, 0.71), (0.74, 0.83, 0.90), (0.88, 0.55, 0.25)
_METAL, _BRASS = (0.62, 0.64, 0.66), (0.80, 0.66, 0.30)
_LAMINATE, _CELL = (0.10, 0.35, 0.20), (0.30, 0.32, 0.36)


@dataclass(frozen=True)
class HousingParts:
    """Makes the parts of a housing for any place of its core.

    Attributes:
        spec: What is asked for.
        layout: Where everything is.
        contents: What is bought.
        plastic: Material of the halves.
        unmoved: Board, fasteners and battery in the unmoved core.
    """

    spec: ImuHousingSpec
    layout: HousingLayout
    contents: HousingContents
    plastic: Material
    unmoved: tuple[Part, ...]

    @classmethod
    def of(cls, spec: ImuHousingSpec, layout: HousingLayout, contents: HousingContents) -> HousingParts:
        """Make what is bought.

        Raises:
            SpecError: If a material is not available.
        """
        bought = (*_board_parts(layout, contents), *_battery_parts(layout))
        return cls(spec, layout, contents, load_material(spec.shell.material), bought)

    def closure(self, placement: ComPlacement) -> ClosureLayout:
        """The closure in its place."""
        return self.layout.closure.moved(np.array(placement.core_shift_mm))

    def hollow(self, placement: ComPlacement) -> HollowBody:
        """What the halves are cut from."""
        unmoved = self.layout.hollow
        return replace(
            unmoved,
            core_shift_mm=placement.core_shift_mm,
            holes=(*unmoved.holes, *placement.core_holes),
            openings=(*unmoved.openings, *placement.fixed_holes),
        )

    def made(self, placement: ComPlacement) -> tuple[Part, ...]:
        """All parts in place, made ones without their meshes."""
        shift = np.array(placement.core_shift_mm)
        closure = self.closure(placement)
        lower, upper = hollow.split_brep(hollow.brep(self.hollow(placement)), closure.seam)
        up = np.array(self.layout.frame.up)
        halves = (
            replace(self._homogeneous(LOWER, lower, _LOWER_COLOR), print_up=as_vector(-up)),
            replace(self._homogeneous(UPPER, upper, _UPPER_COLOR), print_up=as_vector(up)),
        )
        contents = [part.moved(shift) for part in self.unmoved]
        trims = trim_parts(placement.trims)
        sag = self.spec.mesh.sag_um
        plugs = (*self._cable_plug(), *plug_parts(closure, self.plastic, _PLUG_COLOR, sag, _CLOSURE_PLUG))
        parts = (*halves, *plugs, *contents, *closure.parts, *trims)
        return self._lifted(parts, self.upper_parts(parts, placement))

    def with_meshes(self, parts: Iterable[Part], placement: ComPlacement) -> tuple[Part, ...]:
        """The parts, the halves with their meshes and boundaries."""
        whole, seam = self.hollow(placement), self.closure(placement).seam
        sag = self.spec.mesh.sag_um
        meshes = hollow.split_mesh(hollow.mesh(whole, sag), seam, sag)
        boundaries = Boundary.of_hollow(whole).split(seam)
        finished = dict(zip((LOWER, UPPER), zip(meshes, boundaries, strict=True), strict=True))

        def with_mesh(part: Part) -> Part:
            mesh, boundary = finished[part.name]
            lift = self.parting.shift_mm if part.name == UPPER else (0.0, 0.0, 0.0)
            raised = replace(mesh, vertices_mm=mesh.vertices_mm + lift)
            return replace(part, mesh=raised, boundary=boundary.moved(lift))

        return tuple(with_mesh(part) if part.name in finished else part for part in parts)

    @property
    def parting(self) -> Parting:
        """The seam with its gap and step."""
        return parting_of(self.layout.frame, self.spec.split)

    def _homogeneous(self, name: str, solid: Solid, color: tuple[float, float, float]) -> Part:
        return Part.homogeneous(name, solid, self.plastic, color)

    def _cable_plug(self) -> tuple[Part, ...]:
        port, recess = self.layout.port, self.layout.recess
        if port is None or recess is None or recess.state != "plugged":
            return ()
        body, tool = self.layout.hollow.body, port.plug(recess)
        part = self._homogeneous(CABLE_PLUG, hollow.plug_brep(body, tool), _PLUG_COLOR)
        mesh = hollow.plug_mesh(body, tool, self.spec.mesh.sag_um)
        # Its flat inner face lies on the printer's bed.
        return (replace(part, mesh=mesh, boundary=Boundary.of_plug(body, tool), print_up=tool.direction),)

    def upper_parts(self, parts: Iterable[Part], placement: ComPlacement) -> frozenset[str]:
        """Names of the parts that go with the upper half."""
        closure = self.closure(placement)
        up, seam = np.array(self.layout.frame.up), np.array(closure.seam.origin_mm)
        plugs = (part for part in parts if part.name.startswith((CABLE_PLUG, _CLOSURE_PLUG)))
        names = {UPPER, *closure.upper_parts}
        names |= {trim.name for trim in placement.trims if np.dot(trim.site.axis, up) > 0.0}
        names |= {plug.name for plug in plugs if (np.array(plug.com_mm) - seam) @ up > 0.0}
        if self.layout.battery and self.layout.battery.in_upper:
            names.add(BATTERY)
        return frozenset(names)

    def _lifted(self, parts: Iterable[Part], names: frozenset[str]) -> tuple[Part, ...]:
        if not self.parting.is_displaced:
            return tuple(parts)
        lift = np.array(self.parting.shift_mm)
        return tuple(part.moved(lift) if part.name in names else part for part in parts)


def _board_parts(layout: HousingLayout, contents: HousingContents) -> list[Part]:
    """The board on its inserts and screws."""
    frame, board, seat = layout.frame, contents.board, layout.seat_height_mm
    laminate = board_solid(board).moved(frame.location(layout.board_origin_mm))
    com = layout.board_origin_mm + np.array(board.com_mm) @ frame.matrix()
    parts = [_bought(BOARD, board.name, board.mass_g, as_vector(com), laminate, _LAMINATE)]
    insert, screw = contents.insert, contents.screw
    brass, steel = load_material("brass"), load_material("steel")
    for number, (first, second) in enumerate(layout.hole_places_mm, start=1):
        sunk = insert.solid.moved(frame.location(frame.point(first, second, seat)))
        driven = screw.solid.moved(frame.location(frame.point(first, second, seat + board.thickness_mm)))
        parts.append(Part.homogeneous(f"insert-{number}", sunk, brass, _BRASS, insert.standard))
        parts.append(Part.homogeneous(f"screw-{number}", driven, steel, _METAL, screw.standard))
    return parts


def _battery_parts(layout: HousingLayout) -> list[Part]:
    if (mount := layout.battery) is None:
        return []
    battery = mount.battery
    return [_bought(BATTERY, battery.name, battery.mass_g, mount.com_mm, mount.solid, _CELL)]


def _bought(
    name: str,
    product: str,
    mass_g: float,
    com_mm: Vector,
    solid: Solid,
    color: tuple[float, float, float],
) -> Part:
    """A part with a mass and a centre of mass of its own."""
    return Part(name, product, mass_g, com_mm, solid, solid_mass(solid), False, product, color)
