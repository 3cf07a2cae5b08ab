"""A finished design as parts with masses: which are shells, which carry which, and what is known of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gomboc_cad.body import mass_properties
from gomboc_cad.products.closures.spec import DowelsSpec, ThreadRingSpec
from gomboc_cad.products.imu_housing.spec import ImuHousingSpec
from gomboc_cad.products.process import Process
from gomboc_cad.tolerance.com_model import Role, WeighedPart, spread_mm2
from gomboc_cad.tolerance.weighing import build_direction, volume_above_mm3

if TYPE_CHECKING:
    from gomboc_cad.products.assembly import Part
    from gomboc_cad.products.design import ProductDesign


def weighed_parts(design: ProductDesign, process: Process) -> tuple[WeighedPart, ...]:
    """The parts of a design as far as their masses are concerned.

    Of the made parts, the largest on each side of the seam is the shell there: it has the outer surface, and
    a void that is all of the outer shape on that side which it does not fill. Whatever else is on that side
    sits on its core, but for what is in an opening of the outer surface.

    Args:
        design: The design.
        process: How its made parts are made.
    """
    parts, payload = design.assembly.parts, {load.part for load in design.loads}
    trims = {trim.name for trim in design.placement.trims}
    above = design.upper_parts
    sides = [
        [part for part in parts if part.made and (part.name in above) == upper] for upper in (False, True)
    ]
    shells = {
        max(made, key=lambda part: part.volume_mm3).name: upper for upper, made in enumerate(sides) if made
    }
    names = {upper: name for name, upper in shells.items()}
    outer = _outer_volumes_mm3(design)

    def role(part: Part) -> Role:
        if part.made:
            return "shell" if part.name in shells else "plug"
        return "payload" if part.name in payload else "trim" if part.name in trims else "fastener"

    def weighed(part: Part) -> WeighedPart:
        upper = part.name in above
        shell = part.name in shells
        carried = not shell and not _in_opening(design, part)
        void = outer[upper] / part.volume_mm3 - 1.0 if shell else 0.0
        return _weighed(part, process, role(part), upper, names[upper] if carried else None, void)

    return tuple(weighed(part) for part in parts)


def _weighed(
    part: Part, process: Process, role: Role, upper: bool, carrier: str | None, void_share: float
) -> WeighedPart:
    if not part.made:
        return WeighedPart(part.name, role, part.mass_g, part.com_mm, upper, carrier)
    # Made parts of a finished design have both.
    assert part.mesh is not None
    assert part.print_up is not None
    build_up = build_direction(process, part.print_up)
    return WeighedPart(
        name=part.name,
        role=role,
        mass_g=part.mass_g,
        com_mm=part.com_mm,
        upper=upper,
        carrier=carrier,
        build_up=build_up,
        height_mm=float(np.ptp(part.mesh.vertices_mm @ np.array(build_up))),
        spread_mm2=spread_mm2(part.measured),
        volume_mm3=part.volume_mm3,
        void_share=void_share,
    )


def com_error_mm(design: ProductDesign) -> float:
    """What the spec allows the centre of mass to be off along each axis besides; 0 if it says nothing."""
    spec = design.spec
    return 1e-3 * spec.tolerances.com_error_um if isinstance(spec, ImuHousingSpec) else 0.0


def is_glued(design: ProductDesign) -> bool:
    """Whether there is glue along the seam."""
    return isinstance(getattr(design.spec, "closure", None), DowelsSpec | ThreadRingSpec)


def _outer_volumes_mm3(design: ProductDesign) -> tuple[float, float]:
    """Volume of the outer shape below and above the seam."""
    whole = mass_properties(design.body).volume_mm3
    if design.parting is None:
        return whole, 0.0
    above = volume_above_mm3(design.body, np.array(design.parting.up), design.parting.height_mm)
    return whole - above, above


def _in_opening(design: ProductDesign, part: Part) -> bool:
    """Whether a part is in an opening of the outer surface, and stays with that.

    By the corners of its solid: the centre of mass of a ring around an opening is in that opening too.
    """
    corners = np.array([tuple(vertex) for vertex in part.solid.vertices()]).reshape(-1, 3)
    return any(bool(opening.tool.contains(corners).any()) for opening in design.openings)
