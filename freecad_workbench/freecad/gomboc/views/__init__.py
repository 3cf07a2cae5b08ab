"""How the objects of this workbench look: icons with their state, colours, display modes."""

from __future__ import annotations

from typing import Any

from . import appearance
from .provider import ObjectView, refresh_icon


def attach(document_object: Any) -> None:
    """Give an object its view provider."""
    from freecad.gomboc.panels import status  # which shows views

    status.watch()
    view = document_object.ViewObject
    if not isinstance(view.Proxy, ObjectView):
        ObjectView(view)
        appearance.begin(document_object)


def refresh(document_object: Any) -> None:
    """Show the state and the results that an object has now."""
    attach(document_object)
    refresh_icon(document_object)
    appearance.show_results(document_object)
