"""The one door to FreeCAD: no other module of the workbench imports FreeCAD, its modules or Qt.

Outside FreeCAD each of them is None, so that what needs no FreeCAD can be used and tested without it.
"""

from __future__ import annotations

import importlib
import tempfile
from pathlib import Path
from typing import Any


def _optional(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


App: Any = _optional("FreeCAD")
Part: Any = App and _optional("Part")
Mesh: Any = App and _optional("Mesh")
QtCore: Any = App and _optional("PySide.QtCore")


def gui_up() -> bool:
    """Whether FreeCAD shows windows."""
    return bool(App is not None and App.GuiUp)


def __getattr__(name: str) -> Any:
    """Modules that only a FreeCAD with windows should load: Gui, QtGui, QtWidgets, coin."""
    if name == "Gui":
        return _optional("FreeCADGui") if gui_up() else None
    if name == "QtGui":
        return _optional("PySide.QtGui") if gui_up() else None
    if name == "QtWidgets":
        # FreeCAD's shim puts the widgets into QtGui; only newer ones have QtWidgets too.
        return (_optional("PySide.QtWidgets") or _optional("PySide.QtGui")) if gui_up() else None
    if name == "coin":
        return _optional("pivy.coin") if gui_up() else None
    raise AttributeError(name)


def translate(context: str, text: str) -> str:
    """The text in the language of the user, as far as FreeCAD knows it."""
    qt = getattr(App, "Qt", None)
    return qt.translate(context, text) if qt is not None else text


def say(text: str) -> None:
    """A message in the report view, or on the terminal."""
    if App is not None:
        App.Console.PrintMessage(f"gomboc-cad: {text}\n")


def warn(text: str) -> None:
    """A warning in the report view, or on the terminal."""
    if App is not None:
        App.Console.PrintWarning(f"gomboc-cad: {text}\n")


def complain(text: str) -> None:
    """An error in the report view, or on the terminal."""
    if App is not None:
        App.Console.PrintError(f"gomboc-cad: {text}\n")


def preferences() -> Any:
    """The workbench's group of FreeCAD's parameters; None without FreeCAD."""
    return None if App is None else App.ParamGet("User parameter:BaseApp/Preferences/Mod/Gomboc")


def user_data_folder() -> Path:
    """Where FreeCAD keeps what belongs to the user; a temporary folder without FreeCAD."""
    return Path(App.getUserAppDataDir() if App is not None else tempfile.gettempdir())


def read_solids(step: Path) -> list[Any]:
    """The solids of a STEP file, in the order of the file.

    `Import.insert` would also read names and colours, but FreeCAD 0.20 crashes on it without windows.
    """
    return list(Part.read(str(step)).Solids)


def attach_view(document_object: Any) -> None:
    """Give an object its view provider, where there are windows."""
    if gui_up():
        _views().attach(document_object)


def refresh_view(document_object: Any) -> None:
    """Tell the view provider that the state of its object changed, where there are windows."""
    if gui_up():
        _views().refresh(document_object)


def paint(document_object: Any, color: tuple[float, float, float], transparency: int = 0) -> None:
    """Colour an object (RGB in 0…1, transparency in percent), where there are windows."""
    view = getattr(document_object, "ViewObject", None)
    if not gui_up() or view is None:
        return
    appearance = getattr(view, "ShapeAppearance", None)
    if appearance:
        # From FreeCAD 1.0 on; the property gives copies of its materials.
        material = appearance[0]
        material.DiffuseColor = tuple(color)
        view.ShapeAppearance = (material,)
    else:
        view.ShapeColor = tuple(color)
    view.Transparency = transparency


def mark(document_object: Any, color: tuple[float, float, float]) -> None:
    """Make a point or a line easy to see, where there are windows."""
    view = getattr(document_object, "ViewObject", None)
    if gui_up() and view is not None:
        view.PointColor = view.LineColor = tuple(color)
        view.PointSize, view.LineWidth = 9.0, 2.0


def flag(value: Any) -> int:
    """A flag of Qt as a number: the enumerations of Qt 6 are no integers."""
    return int(getattr(value, "value", value))


def keep_screen_alive() -> None:
    """Let windows redraw and timers run, without taking the user's clicks and keys."""
    if gui_up():
        QtCore.QCoreApplication.processEvents(QtCore.QEventLoop.ExcludeUserInputEvents)


def _views() -> Any:
    return importlib.import_module("freecad.gomboc.views")
