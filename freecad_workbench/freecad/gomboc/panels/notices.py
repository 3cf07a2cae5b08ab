"""Messages that wait for no answer: FreeCAD stays usable, scripts go on."""

from __future__ import annotations

from typing import Any, Callable

from freecad.gomboc import door, gui_texts
from freecad.gomboc.errors import GombocCadError
from freecad.gomboc.texts import tr

_open: list[Any] = []


def tell(text: str) -> None:
    """Show a sentence that the user has to see."""
    box = door.QtWidgets.QMessageBox(door.Gui.getMainWindow())
    box.setObjectName("GombocNotice")
    box.setWindowTitle(tr(gui_texts.WORKBENCH))
    box.setIcon(door.QtWidgets.QMessageBox.Warning)
    box.setText(text)
    box.setAttribute(door.QtCore.Qt.WA_DeleteOnClose)
    box.setModal(False)
    box.finished.connect(lambda *_: _open.remove(box))
    _open.append(box)
    box.show()


def guard(action: Callable[[], object]) -> bool:
    """Do something; if it is refused, show the sentence that says why, and return False."""
    try:
        action()
    except GombocCadError as error:
        door.complain(str(error))
        tell(str(error))
        return False
    return True
