"""Children of a product or body: plain parts with their shapes, and datums, in a group that moves as one.

They are ordinary features, so that a file shows them without the workbench too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Sequence

from freecad.gomboc import door, texts
from freecad.gomboc.texts import QT_TRANSLATE_NOOP

from . import properties
from .computed import vector

CENTRE_OF_MASS, DOWN_AT_REST = "CentreOfMass", "DownAtRest"
"""Roles of the datums."""

_LABELS = {
    CENTRE_OF_MASS: QT_TRANSLATE_NOOP("gomboc", "Centre of mass"),
    DOWN_AT_REST: QT_TRANSLATE_NOOP("gomboc", "Down at rest"),
}
_DATUM_COLOR = (0.85, 0.20, 0.15)
BEYOND_FLOOR = 1.25
"""How far the line of the rest reaches, in heights of the centre of mass over the floor."""


@dataclass(frozen=True)
class PartShape:
    """A part of a product.

    Attributes:
        name: As in the assembly.
        material: What it is made of.
        mass_g: Its mass.
        color: RGB in 0…1.
        shape: FreeCAD's solid.
    """

    name: str
    material: str
    mass_g: float
    color: tuple[float, float, float]
    shape: Any


@dataclass(frozen=True)
class RestingPose:
    """Where the centre of mass is, and what points down at rest.

    Attributes:
        com_mm: In the frame of the body.
        down: Unit vector.
        height_mm: Of the centre of mass over the floor.
    """

    com_mm: tuple[float, float, float]
    down: tuple[float, float, float]
    height_mm: float


def show_parts(owner: Any, parts: Sequence[PartShape]) -> None:
    """Make the children of the owner's group those parts; children of the same name are kept and changed."""
    group = _group(owner)
    wanted = {part.name for part in parts}
    for child in list(group.Group):
        if child.TypeId == "Part::Feature" and child.Role not in wanted:
            group.Document.removeObject(child.Name)
    for part in parts:
        child = _child(group, "Part::Feature", part.name, part.name)
        properties.add_results(child, _PART_RESULTS)
        properties.add_results(child, _PART_INTERNALS, properties.INTERNAL)
        child.Shape = part.shape
        child.Material, child.Mass, child.Colour = part.material, part.mass_g, part.color
        door.paint(child, part.color)
        child.purgeTouched()
    group.purgeTouched()


def show_rest(owner: Any, pose: RestingPose) -> None:
    """Show the centre of mass as a point and the direction that points down at rest as a line."""
    group = _group(owner)
    com, down = vector(pose.com_mm), vector(pose.down)
    point = _child(group, "Part::Vertex", CENTRE_OF_MASS, texts.tr(_LABELS[CENTRE_OF_MASS]))
    point.X, point.Y, point.Z = com
    line = _child(group, "Part::Line", DOWN_AT_REST, texts.tr(_LABELS[DOWN_AT_REST]))
    end = com + down * (BEYOND_FLOOR * pose.height_mm)
    line.X1, line.Y1, line.Z1 = com
    line.X2, line.Y2, line.Z2 = end
    for datum in (point, line):
        datum.recompute()
        door.mark(datum, _DATUM_COLOR)
        datum.purgeTouched()
    group.purgeTouched()


def move(owner: Any) -> None:
    """Put the group where its owner is."""
    if getattr(owner, "Parts", None) is not None and owner.Parts.Placement != owner.Placement:
        owner.Parts.Placement = owner.Placement


def child_with_role(owner: Any, role: str) -> Any:
    """The part or datum of a role; None if there is none."""
    if getattr(owner, "Parts", None) is None:
        return None
    return next((child for child in owner.Parts.Group if getattr(child, "Role", "") == role), None)


_PART_RESULTS = {"Material": "App::PropertyString", "Mass": "App::PropertyFloat"}
_PART_INTERNALS = {"Colour": "App::PropertyColor"}
_ROLE = {"Role": "App::PropertyString"}


def _group(owner: Any) -> Any:
    if owner.Parts is None:
        group = owner.Document.addObject("App::Part", f"{owner.Name}_Parts")
        group.Label = f"{owner.Label} parts"
        owner.Parts = group
        group.Placement = owner.Placement
        for plane_or_axis in (group.Origin, *group.Origin.OriginFeatures):
            plane_or_axis.purgeTouched()
    return owner.Parts


def _child(group: Any, kind: str, role: str, label: str) -> Any:
    for child in group.Group:
        if getattr(child, "Role", "") == role:
            return child
    child = group.Document.addObject(kind, "".join(c if c.isalnum() else "_" for c in role))
    properties.add_results(child, _ROLE, properties.INTERNAL)
    child.Role, child.Label = role, label
    group.addObject(child)
    return child
