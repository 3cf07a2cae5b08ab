"""The camera: a body of this workbench rests on minus x, FreeCAD's own views show it on its side."""

from __future__ import annotations

from typing import Any

from freecad.gomboc import door

# Looking down at the front right corner, z upwards, as FreeCAD's isometric view.
_ISOMETRIC = (0.424708, 0.17592, 0.339851, 0.820473)


def view_at_rest(document_object: Any) -> None:
    """Look at an object obliquely from above, as it stands on the table."""
    view = document_object.ViewObject.Document.ActiveView
    if not hasattr(view, "setCameraOrientation"):
        return
    up = -rest_direction(document_object)
    upright = door.App.Rotation(door.App.Vector(0, 0, 1), up)
    view.setCameraOrientation(upright.multiply(door.App.Rotation(*_ISOMETRIC)))
    view.fitAll()


def rest_direction(document_object: Any) -> Any:
    """The direction that points down when the object rests; minus x where it does not say so."""
    direction = getattr(document_object, "RestDirection", None)
    return direction if direction is not None and direction.Length > 0 else door.App.Vector(-1, 0, 0)
