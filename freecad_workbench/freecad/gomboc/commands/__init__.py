"""The buttons of the workbench, in the order of its toolbars."""

from __future__ import annotations

from freecad.gomboc import door, gui_texts

from . import control, create, judge, output, place

TOOLBARS = (
    (gui_texts.TOOLBAR_CREATE, create.COMMANDS),
    (gui_texts.TOOLBAR_JUDGE, (*judge.COMMANDS[:1], *place.COMMANDS, *judge.COMMANDS[1:])),
    (gui_texts.TOOLBAR_OUTPUT, (*output.COMMANDS, *control.COMMANDS)),
)


def register() -> None:
    """Make the buttons known to FreeCAD."""
    for _, commands in TOOLBARS:
        for command in commands:
            door.Gui.addCommand(command.name, command)
