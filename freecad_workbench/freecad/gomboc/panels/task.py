"""Task panels with a form and the buttons OK and Cancel."""

from __future__ import annotations

from typing import Any, Callable

from freecad.gomboc import door, gui_texts
from freecad.gomboc.errors import GombocCadError
from freecad.gomboc.texts import tr
from freecad.gomboc.views import icons

from . import result


def show(panel: Task) -> None:
    """Open a task panel in place of one of this workbench.

    Raises:
        GombocCadError: If FreeCAD is busy with another task.
    """
    result.close()
    if door.Gui.Control.activeDialog():
        raise GombocCadError(tr(gui_texts.OTHER_TASK))
    door.Gui.Control.showDialog(panel)


class Task:
    """What FreeCAD asks of a task panel.

    Args:
        name: Object name of the form, and its title.
        title: What the user sees.
        icon: File in the folder of icons, without its ending.
        layout: The content.
        accepted: Called on OK; the panel stays open, with the reason shown, if it raises GombocCadError.
    """

    def __init__(self, name: str, title: str, icon: str, layout: Any, accepted: Callable[[], Any]) -> None:
        self._accepted = accepted
        self.form = door.QtWidgets.QWidget()
        self.form.setObjectName(name)
        self.form.setWindowTitle(title)
        self.form.setWindowIcon(door.QtGui.QIcon(icons.path(icon)))
        whole = door.QtWidgets.QVBoxLayout(self.form)
        whole.addLayout(layout)
        self._problem = door.QtWidgets.QLabel()
        self._problem.setObjectName("GombocProblem")
        self._problem.setWordWrap(True)
        self._problem.setStyleSheet("color: #d5322e; font-weight: bold;")
        self._problem.hide()
        whole.addWidget(self._problem)
        whole.addStretch()

    def getStandardButtons(self) -> int:
        """OK and Cancel."""
        buttons = door.QtWidgets.QDialogButtonBox
        return door.flag(buttons.Ok) | door.flag(buttons.Cancel)

    def accept(self) -> bool:
        """OK was pressed."""
        try:
            made = self._accepted()
        except GombocCadError as error:
            self._problem.setText(str(error))
            self._problem.show()
            return False
        if made is not None:
            # FreeCAD closes this panel when the function is done; there can be no other until then.
            door.QtCore.QTimer.singleShot(0, lambda: result.show(made))
        return True

    def reject(self) -> bool:
        """Cancel was pressed."""
        door.Gui.Control.closeDialog()
        return True

    def isAllowedAlterDocument(self) -> bool:
        """The rest of FreeCAD stays usable."""
        return True

    isAllowedAlterSelection = isAllowedAlterView = isAllowedAlterDocument
