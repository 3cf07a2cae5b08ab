"""Calls of the API by their text, so that FreeCAD's macro recorder writes down what the buttons do."""

from __future__ import annotations

from typing import Any

from . import door


def call(text: str) -> Any | None:
    """Call a function of the API.

    Args:
        text: For example `create_body(App.ActiveDocument, 'primary')`.

    Returns:
        The object of this workbench that the call made, if it made one.
    """
    before = _own_objects()
    door.Gui.addModule("freecad.gomboc.api")
    door.Gui.doCommand(f"freecad.gomboc.api.{text}")
    made = _own_objects().keys() - before.keys()
    return _own_objects()[made.pop()] if made else None


def document(of: Any) -> str:
    """The document of an object as a macro names it."""
    return f"App.getDocument({of.Document.Name!r})"


def name(document_object: Any) -> str:
    """An object as a macro names it."""
    return f"{document(document_object)}.getObject({document_object.Name!r})"


def keywords(values: dict[str, Any]) -> str:
    """Keyword arguments, each after a comma."""
    return "".join(f", {keyword}={value!r}" for keyword, value in values.items())


def _own_objects() -> dict[tuple[str, str], Any]:
    return {
        (document.Name, each.Name): each
        for document in door.App.listDocuments().values()
        for each in document.Objects
        if getattr(getattr(each, "Proxy", None), "kind", "")
    }
