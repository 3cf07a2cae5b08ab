"""Runs inside FreeCAD: takes a script of steps, one at a time between two rounds of the event loop.

The script finds `App`, `Gui`, `QtCore`, `QtGui`, `inputs`, `report(name=value, ...)`, and the functions of
this module that `OFFERED` names.
"""

import json
import os
import time
import traceback

import FreeCAD as App  # noqa: F401  (for the script)
import FreeCADGui as Gui
from PySide import QtCore, QtGui

INTERVAL_MS = 50

with open(os.environ["GUI_JOB"], encoding="utf-8") as stream:
    job = json.load(stream)
values = {}


def report(**named):
    values.update(named)


def widget(name):
    """The visible widget of that object name, or None."""
    found = [
        child
        for top in QtGui.QApplication.topLevelWidgets()
        for child in top.findChildren(QtGui.QWidget, name)
    ]
    found += [top for top in QtGui.QApplication.topLevelWidgets() if top.objectName() == name]
    return next((each for each in found if each.isVisible()), None)


def click(name):
    button = widget(name)
    assert button is not None, f"no widget {name} is shown"
    assert button.isEnabled(), f"the widget {name} is disabled"
    button.click()


def press(command):
    """Press a button as a user does: one that is grey does nothing."""
    assert Gui.Command.get(command).isActive(), f"the button {command} is grey"
    Gui.runCommand(command)


def accept():
    """Press OK in the task panel."""
    boxes = [each for each in QtGui.QApplication.allWidgets() if isinstance(each, QtGui.QDialogButtonBox)]
    panel = next(box for box in boxes if box.isVisible() and box.button(QtGui.QDialogButtonBox.Ok))
    panel.button(QtGui.QDialogButtonBox.Ok).click()


def computed(document_object):
    """Whether the object is there and nothing runs for it any more."""
    return document_object is not None and document_object.Status in ("done", "failed", "cancelled")


def select(*documents_objects):
    """Select objects, or (object, name of a sub-element)."""
    Gui.Selection.clearSelection()
    for each in documents_objects:
        Gui.Selection.addSelection(*(each if isinstance(each, tuple) else (each,)))


def console():
    """What the Python console shows: all that a macro would record."""
    shown = [each for each in QtGui.QApplication.allWidgets() if isinstance(each, QtGui.QPlainTextEdit)]
    return "\n".join(each.toPlainText() for each in shown if each.toPlainText().startswith("Python "))


def messages():
    boxes = [top for top in QtGui.QApplication.topLevelWidgets() if isinstance(top, QtGui.QMessageBox)]
    return [box.text() for box in boxes if box.isVisible()]


def picture(path):
    """Photograph the main window with what lies over it."""
    QtGui.QApplication.processEvents()
    screen = QtGui.QApplication.primaryScreen()
    image = screen.grabWindow(0)
    assert image.save(path), f"no picture was written to {path}"


def finish(outcome):
    name = os.environ["GUI_OUTCOME"]
    with open(name + ".part", "w", encoding="utf-8") as stream:
        json.dump(outcome, stream)
    os.replace(name + ".part", name)
    # A regular end would ask whether to save, and wait for an answer.
    os._exit(0)


class Driver(QtCore.QObject):
    """Advances the script whenever the condition that it waits for holds."""

    def __init__(self):
        super().__init__()
        scope = {"__name__": "steps", **{name: globals()[name] for name in OFFERED}, "inputs": job["inputs"]}
        exec(compile(job["script"], "<steps in FreeCAD>", "exec"), scope)
        self.steps = scope["steps"]()
        self.condition = lambda: True
        self.ends = time.monotonic() + job["timeout_s"]
        self.busy = False
        self.timer = QtCore.QTimer(self)
        self.timer.timeout.connect(self.advance)
        self.timer.start(INTERVAL_MS)

    def advance(self):
        if self.busy:
            # A step is inside an event loop of its own, as in a modal dialog.
            if time.monotonic() > self.ends:
                self.fail("time ran out inside a modal dialog: " + "; ".join(messages()))
            return
        self.busy = True
        try:
            if self.condition():
                self.condition = next(self.steps) or (lambda: True)
            elif time.monotonic() > self.ends:
                raise AssertionError("time ran out while waiting at " + self.place())
        except StopIteration:
            finish({"values": values})
        except BaseException:
            self.fail(traceback.format_exc())
        self.busy = False

    def place(self):
        frame = self.steps.gi_frame
        line = job["script"].splitlines()[frame.f_lineno - 1].strip()
        return f"line {frame.f_lineno}: {line}; open messages: {messages()}"

    def fail(self, text):
        picture(os.environ["GUI_OUTCOME"] + ".png")
        finish({"error": text})


OFFERED = (
    *("App", "Gui", "QtCore", "QtGui", "report", "widget", "click", "press", "accept", "computed", "select"),
    *("console", "messages", "picture"),
)


def begin():
    global driver
    try:
        Gui.getMainWindow().showMaximized()
        for dock in Gui.getMainWindow().findChildren(QtGui.QDockWidget):
            dock.setVisible(dock.objectName() == "Combo View")
        if "GombocWorkbench" in Gui.listWorkbenches():
            Gui.activateWorkbench("GombocWorkbench")
        driver = Driver()
    except BaseException:
        finish({"error": traceback.format_exc()})


QtCore.QTimer.singleShot(300, begin)
