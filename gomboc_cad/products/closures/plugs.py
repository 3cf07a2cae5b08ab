"""Flush plugs as parts: pieces of the body's own material that close head recesses."""

from __future__ import annotations

from dataclasses import replace

from gomboc_cad.products.assembly import Part
from gomboc_cad.products.closures.records import ClosureLayout
from gomboc_cad.products.materials import Material
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.hollow import plug_brep, plug_mesh
from gomboc_cad.solid.step import Color


def plug_parts(
    layout: ClosureLayout, material: Material, color: Color, sag_um: float, prefix: str
) -> tuple[Part, ...]:
    """Make the plugs of a closure that is in its final place.

    Args:
        layout: The closure, moved with its core.
        material: Material of the plugs.
        color: Their color.
        sag_um: How fine their meshes are.
        prefix: What their names begin with; a number is added.

    Raises:
        GeometryError: If the place of a plug is not in the body.
    """
    body = layout.site.body
    parts = []
    for number, tool in enumerate(layout.plugs, start=1):
        part = Part.homogeneous(f"{prefix}-{number}", plug_brep(body, tool), material, color)
        mesh, boundary = plug_mesh(body, tool, sag_um), Boundary.of_plug(body, tool)
        parts.append(replace(part, mesh=mesh, boundary=boundary, print_up=tool.direction))
    return tuple(parts)
