"""What FreeCAD loads when it starts with windows: the workbench with its toolbars and menu."""

from __future__ import annotations

from . import door, gui_texts
from .texts import tr
from .views import icons


class GombocWorkbench(door.Gui.Workbench):
    """Self-righting products behind buttons."""

    MenuText = tr(gui_texts.WORKBENCH)
    ToolTip = tr(gui_texts.WORKBENCH_TIP)
    Icon = icons.path("gomboc-workbench")

    def Initialize(self) -> None:
        """Make buttons, toolbars and the menu; called when the workbench is chosen for the first time."""
        from . import commands

        commands.register()
        menu = []
        for title, members in commands.TOOLBARS:
            names = [command.name for command in members]
            self.appendToolbar(tr(title), names)
            menu += [*names, "Separator"]
        self.appendMenu(tr(gui_texts.MENU), menu[:-1])

    def Activated(self) -> None:
        """Show in the status bar what is computed from now on."""
        from .panels import status

        status.watch()

    def GetClassName(self) -> str:
        """The kind of workbench that is written in Python."""
        return "Gui::PythonWorkbench"


door.Gui.addWorkbench(GombocWorkbench())
