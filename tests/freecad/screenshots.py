"""Makes the pictures of docs/freecad.md anew: `python -m tests.freecad.screenshots`.

They show what stands on the page: the first use, the first housing from its form to its verdict, a drill map,
a loading zone and a check, in a real FreeCAD on a virtual screen. It takes a few minutes.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from tests.external import require_program
from tests.freecad.screen import FreeCADWindows, virtual_screen

IMAGES = Path(__file__).parents[2] / "docs" / "images"

TOOLS = """
import os

def shot(name):
    picture(os.path.join(inputs["images"], f"freecad-{name}.png"))

def settle():
    for _ in range(10):
        yield
"""

FIRST_USE = (
    TOOLS
    + """
def steps():
    App.newDocument("Unnamed")
    press("Gomboc_ImuHousing")
    yield lambda: widget("GombocSetUp")
    for label in widget("GombocSetUp").findChildren(QtGui.QLabel):
        label.setText(label.text().replace(App.getUserAppDataDir(), "/home/you/.local/share/FreeCAD/"))
    window, dialog = Gui.getMainWindow().geometry(), widget("GombocSetUp")
    dialog.move(window.center() - dialog.rect().center())
    yield from settle()
    shot("setup")
"""
)

FIRST_HOUSING = (
    TOOLS
    + """
def expand():
    for tree in Gui.getMainWindow().findChildren(QtGui.QTreeWidget):
        tree.expandToDepth(2)

def model_tab():
    for tabs in Gui.getMainWindow().findChildren(QtGui.QTabWidget):
        if tabs.count() and tabs.tabText(0) == "Model":
            tabs.setCurrentIndex(0)

def steps():
    document = App.newDocument("Housing")
    press("Gomboc_ImuHousing")
    yield lambda: widget("GombocNew")
    yield from settle()
    shot("form")
    widget("GombocOverrides").setPlainText("mesh.sag_um=50")
    accept()
    yield lambda: widget("GombocBar") and widget("GombocBar").value() >= 5
    shot("progress")
    housing = document.ImuHousing
    yield lambda: computed(housing)
    document.imu_housing_upper.ViewObject.Transparency = 75
    yield from settle()
    shot("housing")

    Gui.Control.closeDialog()
    select(housing)
    press("Gomboc_DrillMap")
    yield lambda: computed(document.getObject("DrillMap"))
    select()
    yield from settle()
    shot("drill-map")
    document.DrillMap.ViewObject.Visibility = False
    select(housing)
    press("Gomboc_LoadingZone")
    yield lambda: computed(document.getObject("LoadingZone"))
    housing.ViewObject.Visibility = True
    for part in housing.Parts.Group:
        part.ViewObject.Visibility = part.Name in ("CentreOfMass", "DownAtRest")
    select()
    yield from settle()
    shot("zone")
    document.LoadingZone.ViewObject.Visibility = False
    box = document.addObject("Part::Box", "Box")
    box.Length = box.Width = 40
    box.Height = 60
    box.Placement.Base = App.Vector(-20, 60, -20)
    box.ViewObject.Transparency = 60
    document.recompute()
    for part in housing.Parts.Group:
        part.ViewObject.Visibility = part.Name != "imu_housing_upper"
    select(box)
    press("Gomboc_Check")
    yield lambda: computed(document.getObject("Check"))
    select()
    Gui.SendMsgToActiveView("ViewFit")
    model_tab()
    expand()
    yield from settle()
    shot("tree")
"""
)


def main() -> None:
    """Write the pictures."""
    executable = require_program("freecad", package="freecad-python3")
    with tempfile.TemporaryDirectory() as folder, virtual_screen("1200x800x24") as display:
        for name, python, steps in (("first-use", "", FIRST_USE), ("housing", sys.executable, FIRST_HOUSING)):
            scratch = Path(folder) / name
            scratch.mkdir()
            freecad = FreeCADWindows(executable, display, scratch, python)
            freecad.run(steps, timeout_s=1800.0, images=IMAGES)


if __name__ == "__main__":
    main()
