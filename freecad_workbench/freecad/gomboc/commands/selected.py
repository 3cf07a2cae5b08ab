"""What the user has selected, in the words of the buttons."""

from __future__ import annotations

from typing import Any, Tuple

from freecad.gomboc import door
from freecad.gomboc.objects.check import point_of
from freecad.gomboc.views import icons, marks
from freecad.gomboc.views.appearance import PRODUCTS

SUBJECTS = ("body", *PRODUCTS)

Point = Tuple[float, float, float]


def product() -> Any | None:
    """The selected product, or the one whose part is selected."""
    return _first(PRODUCTS)


def subject() -> Any | None:
    """The selected body or product of this workbench, or the one whose part is selected."""
    return _first(SUBJECTS)


def own() -> Any | None:
    """The selected object of this workbench, whatever it is."""
    return _first(tuple(icons.OF_KIND))


def part() -> Any | None:
    """The selected part, body or mesh of anyone: the first selected object that is more than a point."""
    return next((each for each in _objects() if has_volume(each)), None)


def vertex() -> tuple[Any, str] | None:
    """The selected vertex as an object and its name, a point object with no name; None if not just one."""
    found = [each for selected in door.Gui.Selection.getSelectionEx() for each in _vertices(selected)]
    return found[0] if len(found) == 1 else None


def point() -> Point | None:
    """Where the selected vertex or point object is."""
    found = vertex()
    return None if found is None else point_of((found[0], [found[1]]))


def has_volume(document_object: Any) -> bool:
    """Whether it is a solid shape or a mesh, or a group that may hold such."""
    if hasattr(document_object, "Mesh"):
        return True
    shape = getattr(document_object, "Shape", None)
    if shape is not None and hasattr(shape, "Solids"):
        return bool(shape.Solids)
    return document_object.isDerivedFrom("App::Part")


def _first(kinds: tuple[str, ...]) -> Any | None:
    for selected in door.Gui.Selection.getSelection():
        if marks.kind(selected) in kinds:
            return selected
        for owner in selected.InListRecursive:
            if marks.kind(owner) in kinds and getattr(owner, "Parts", None) in (selected, *selected.InList):
                return owner
    return None


def _objects() -> list[Any]:
    """The selected objects; for a feature of a PartDesign body, the body."""
    return [_body_of(each) or each for each in door.Gui.Selection.getSelection()]


def _body_of(document_object: Any) -> Any | None:
    return next((each for each in document_object.InList if each.isDerivedFrom("PartDesign::Body")), None)


def _vertices(selected: Any) -> list[tuple[Any, str]]:
    names = [name for name in selected.SubElementNames if name.rpartition(".")[2].startswith("Vertex")]
    if not names and not selected.SubElementNames and _is_point(selected.Object):
        names = [""]
    return [(selected.Object, name) for name in names]


def _is_point(document_object: Any) -> bool:
    shape = getattr(document_object, "Shape", None)
    return shape is not None and not shape.isNull() and len(shape.Vertexes) == 1 and not shape.Edges
