"""What all buttons share: how FreeCAD asks them, and what happens when something is not in order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable

from freecad.gomboc import door
from freecad.gomboc.panels import notices, setup
from freecad.gomboc.texts import tr
from freecad.gomboc.views import icons


@dataclass(frozen=True)
class Command:
    """A button as FreeCAD wants it.

    Attributes:
        name: By which `Gui.runCommand` knows it.
        icon: File in the folder of icons, without its ending.
        menu: Text of menu and button.
        tooltip: What it does, in a sentence.
        action: What it does.
        active: Whether it can do that now.
        needs_package: The first-use dialog opens instead where there is no package.
    """

    name: str
    icon: str
    menu: str
    tooltip: str
    action: Callable[[], object]
    active: Callable[[], bool]
    needs_package: bool = True

    def GetResources(self) -> dict[str, str]:
        """What FreeCAD shows."""
        return {"Pixmap": icons.path(self.icon), "MenuText": tr(self.menu), "ToolTip": tr(self.tooltip)}

    def IsActive(self) -> bool:
        """Whether the button can be pressed."""
        return self.active()

    def Activated(self, index: int = 0) -> None:
        """The button was pressed."""
        if self.needs_package and not setup.is_ready():
            setup.show()
        else:
            notices.guard(self.action)


def has_document() -> bool:
    """Whether a document is open."""
    return door.App.ActiveDocument is not None
