"""The resting poses of any part: one that a user modelled, one of ours, or a mesh."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any, Sequence

from freecad.gomboc import cli, door, texts
from freecad.gomboc.errors import GombocCadError

from . import properties
from .computed import Computed, assign_results, kind_of, vector
from .parts import BEYOND_FLOOR

OWN, GIVEN, POINT = "own", "given", "point"
"""Where the centre of mass comes from: the part itself, a place, or a point of the document."""

_SHOWN_POSES = 50


class Check(Computed):
    """Proxy of a check."""

    kind = "check"

    def _add_properties(self, document_object: Any) -> None:
        super()._add_properties(document_object)
        for name, kind in _SETTINGS.items():
            if properties.add(document_object, kind, name) and name == "ComFrom":
                document_object.ComFrom = [OWN, GIVEN, POINT]
        properties.add_results(document_object, _RESULTS)

    def inputs(self, document_object: Any) -> str:
        """Digest of the part's geometry, and the centre of mass."""
        part = _part(document_object)
        return f"{digest(part)} {com_mm(document_object)}"

    def prepare(self, document_object: Any, folder: Path) -> list[str]:
        """`gomboc-cad check` of the part, written to a file."""
        return cli.check(write_part(_part(document_object), folder), com_mm(document_object))

    def read(self, document_object: Any, document: dict[str, Any], folder: Path) -> dict[str, Any]:
        """Counts, poses and the verdict; a line from the centre of mass down in each pose."""
        com, poses = vector(document["com_mm"]), document["poses"]
        downs = [vector(p["direction"]) * (BEYOND_FLOOR * p["height_mm"]) for p in poses[:_SHOWN_POSES]]
        return {
            "Verdict": document["verdict"],
            "Good": document["verdict"] == "monostable",
            "Reasons": document["reasons"],
            "Stable": document["stable"],
            "Unstable": document["unstable"],
            "Saddles": document["saddles"],
            "CentreOfMass": com,
            "Poses": [_pose_text(pose) for pose in poses],
            "Shape": door.Part.makeCompound([door.Part.makeLine(com, com + down) for down in downs]),
        }

    def show(self, document_object: Any, results: dict[str, Any]) -> None:
        """Show them."""
        assign_results(document_object, results)


def has_solid(part: Any) -> bool:
    """Whether a document object is something that can lie on a table: a solid or a mesh."""
    if hasattr(part, "Mesh"):
        return part.Mesh.CountFacets > 0
    shape = _shape(part)
    return shape is not None and bool(shape.Solids)


def write_part(part: Any, folder: Path) -> Path:
    """Write a part, where it is in the document, to a file that the package reads.

    Raises:
        GombocCadError: If it has no solid.
    """
    if not has_solid(part):
        raise GombocCadError(texts.tr(texts.NO_SOLID, label=part.Label))
    if hasattr(part, "Mesh"):
        path = folder / "part.stl"
        part.Mesh.write(str(path))
    else:
        path = folder / "part.step"
        _shape(part).exportStep(str(path))
    return path


def digest(part: Any) -> str:
    """A short text that changes with the part's geometry and place.

    Raises:
        GombocCadError: If it has no solid.
    """
    if not has_solid(part):
        raise GombocCadError(texts.tr(texts.NO_SOLID, label=part.Label))
    if hasattr(part, "Mesh"):
        points, facets = part.Mesh.Topology
        content = repr(([tuple(point) for point in points], facets))
    else:
        content = _shape(part).exportBrepToString()
    return hashlib.sha256(content.encode("utf-8")).hexdigest()


def own_com_mm(part: Any) -> tuple[float, float, float] | None:
    """The centre of mass that a part knows of itself, in the document's frame; None if it is homogeneous.

    Only a product of ours knows more than its shape: it is made of several materials.
    """
    if kind_of(part) != "product":
        return None
    x, y, z = part.Placement.multVec(part.CentreOfMass)
    return x, y, z


def com_mm(check: Any) -> tuple[float, float, float] | None:
    """The centre of mass that a check is about; None for that of the homogeneous part.

    Raises:
        GombocCadError: If the point that is chosen is none.
    """
    if check.ComFrom == GIVEN:
        return properties.point("Com", check.Com)
    if check.ComFrom == POINT:
        return point_of(check.ComPoint)
    return own_com_mm(_part(check))


def point_of(link: Any) -> tuple[float, float, float]:
    """Where a vertex or a point object is: the value of an `App::PropertyLinkSub`.

    Raises:
        GombocCadError: If there is no such point, or more than one.
    """
    document_object, names = link or (None, [])
    label = document_object.Label if document_object is not None else "ComPoint"
    if document_object is None:
        raise GombocCadError(texts.tr(texts.NO_POINT, label=label))
    shape = _shape(document_object)
    wanted = [name for name in names if name]
    if shape is None or (not wanted and len(shape.Vertexes) != 1):
        raise GombocCadError(texts.tr(texts.NO_POINT, label=label))
    found = shape.getElement(wanted[0]) if wanted else shape.Vertexes[0]
    if len(found.Vertexes) != 1:
        raise GombocCadError(texts.tr(texts.NO_POINT, label=f"{label}.{wanted[0]}"))
    x, y, z = found.Vertexes[0].Point
    return x, y, z


def _part(check: Any) -> Any:
    if check.Part is None:
        raise GombocCadError(texts.tr(texts.NO_SOLID, label=check.Label))
    return check.Part


def _shape(part: Any) -> Any:
    """The shape of an object in the document's frame, whatever groups it is in; None if it has none."""
    shape = door.Part.getShape(part)
    if shape.isNull():
        return None
    if hasattr(part, "getGlobalPlacement") and hasattr(part, "Placement"):
        shape = shape.copy()
        # The shape has the part's own placement; the groups around it come on top.
        around = part.getGlobalPlacement().multiply(part.Placement.inverse())
        shape.Placement = around.multiply(shape.Placement)
    return shape


def _pose_text(pose: dict[str, Any]) -> str:
    direction: Sequence[float] = pose["direction"]
    barrier = "–" if pose["barrier_um"] is None else f"{pose['barrier_um']:.4g} µm"
    down = ", ".join(f"{entry + 0.0:.4f}" for entry in direction)
    height_mm, percent = pose["height_mm"], 100.0 * pose["probability"]
    return texts.tr(texts.POSE, down=down, height=height_mm, barrier=barrier, probability=percent)


_SETTINGS = {
    "Part": "App::PropertyLink",
    "ComFrom": "App::PropertyEnumeration",
    "Com": "App::PropertyVectorDistance",
    "ComPoint": "App::PropertyLinkSub",
}
_RESULTS = {
    "Stable": "App::PropertyInteger",
    "Unstable": "App::PropertyInteger",
    "Saddles": "App::PropertyInteger",
    "Poses": "App::PropertyStringList",
    "CentreOfMass": "App::PropertyVector",
}
