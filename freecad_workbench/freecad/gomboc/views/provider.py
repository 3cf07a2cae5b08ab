"""The view provider of every object of this workbench."""

from __future__ import annotations

from typing import Any

from freecad.gomboc import door, gui_texts, jobs
from freecad.gomboc.texts import tr

from . import camera, icons, marks

PARTS_MODE = "Parts"
"""A display mode in which an object draws nothing itself: what is seen are its parts."""


class ObjectView:
    """Icon with its state, parts below it in the tree, context menu; a double click opens the result."""

    was_seen = False
    """Whether its results were shown once; what is arranged then is left to the user afterwards."""

    def __init__(self, view: Any) -> None:
        view.Proxy = self

    def attach(self, view: Any) -> None:
        """FreeCAD has made the view."""
        self.view = view
        if hasattr(view, "addDisplayMode"):
            view.addDisplayMode(door.coin.SoGroup(), PARTS_MODE)

    def getDisplayModes(self, view: Any) -> list[str]:
        """The display modes besides those of every shape."""
        return [PARTS_MODE]

    def getDefaultDisplayMode(self) -> str:
        """The display mode of a new object."""
        return "Shaded"

    def setDisplayMode(self, mode: str) -> str:
        """The mode of the scene graph for a mode of the object: the same."""
        return mode

    def getIcon(self) -> Any:
        """The icon of its kind with the mark of its state."""
        target = self.view.Object
        return icons.marked(marks.icon_name(target), marks.mark(target))

    def claimChildren(self) -> list[Any]:
        """What the tree shows below it."""
        return children(self.view.Object)

    def onChanged(self, view: Any, name: str) -> None:
        """Its parts are shown and hidden with it."""
        if name == "Visibility" and not view.Object.Document.Restoring:
            for child in children(view.Object):
                child.ViewObject.Visibility = view.Visibility

    def onDelete(self, view: Any, names: Any) -> bool:
        """Its parts go with it."""
        document = view.Object.Document
        for group in children(view.Object):
            for child in [*group.Group, group]:
                document.removeObject(child.Name)
        return True

    def doubleClicked(self, view: Any) -> bool:
        """Open the result."""
        from freecad.gomboc.panels import result

        result.show(view.Object)
        return True

    def setupContextMenu(self, view: Any, menu: Any) -> None:
        """What a right click in the tree offers."""
        from freecad.gomboc.panels import result

        target = view.Object
        menu.addAction(tr(gui_texts.SHOW_RESULT), lambda: result.show(target))
        menu.addAction(tr(gui_texts.VIEW_AT_REST), lambda: camera.view_at_rest(target))
        if any(job.is_about(target) for job in jobs.queue.jobs()):
            menu.addAction(tr(gui_texts.STOP), lambda: jobs.queue.cancel(target))

    def dumps(self) -> None:
        """What FreeCAD saves of the proxy itself: nothing."""

    def loads(self, state: None) -> None:
        """What FreeCAD restores of the proxy itself: nothing."""

    # The names of these two up to FreeCAD 0.20.
    __getstate__ = dumps
    __setstate__ = loads


def children(document_object: Any) -> list[Any]:
    """The group of parts and datums that belongs to an object, if it has one."""
    group = getattr(document_object, "Parts", None)
    return [] if group is None else [group]


def refresh_icon(document_object: Any) -> None:
    """Have the tree ask for the icon again."""
    document_object.ViewObject.signalChangeIcon()
