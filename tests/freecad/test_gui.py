"""The workbench as a user meets it: FreeCAD's real windows on a virtual screen, driven by its buttons."""

from __future__ import annotations

import json
import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.external import require_program
from tests.freecad.screen import FreeCADWindows, virtual_screen
from tests.freecad.test_headless import wheel

pytestmark = pytest.mark.freecad

BUTTONS = {
    *("Gomboc_Body", "Gomboc_ImuHousing", "Gomboc_SeedPod", "Gomboc_Buoy"),
    *("Gomboc_Check", "Gomboc_PlaceCom", "Gomboc_LoadingZone", "Gomboc_DrillMap", "Gomboc_ToleranceStudy"),
    *("Gomboc_OpenReport", "Gomboc_Export", "Gomboc_Stop", "Gomboc_SetUp"),
}
NEW = {"Gomboc_Body", "Gomboc_ImuHousing", "Gomboc_SeedPod", "Gomboc_Buoy"}

Windows = Callable[..., dict[str, Any]]


@pytest.fixture(scope="module")
def display() -> Iterator[str]:
    with virtual_screen() as name:
        yield name


@pytest.fixture
def windows(display: str, tmp_path: Path) -> Windows:
    """`windows(script, python=…, timeout_s=…, …)` runs steps in a FreeCAD with settings of its own."""
    return _windows(display, tmp_path)


def _windows(display: str, scratch: Path, linked: bool = True) -> Windows:
    executable = require_program("freecad", package="freecad-python3")

    def run(
        steps: str, *, python: str = sys.executable, timeout_s: float = 300.0, **inputs: Any
    ) -> dict[str, Any]:
        freecad = FreeCADWindows(executable, display, scratch, python, linked)
        return freecad.run(textwrap.dedent(steps), timeout_s=timeout_s, **inputs)

    return run


@pytest.fixture
def slow_package(tmp_path: Path, windows: Windows) -> Callable[..., str]:
    """`slow_package(seconds=…, kill=True, …)` is the path of a stand-in for a Python that has the package."""
    folder = tmp_path / "päckage 2"
    folder.mkdir()
    program = folder / "python"
    text = Path(__file__).with_name("fake_package.py").read_text()
    program.write_text(text.replace("/usr/bin/env python3", sys.executable))
    program.chmod(0o755)
    windows(
        "import Part\ndef steps():\n    Part.makeBox(1, 2, 3).exportStep(inputs['step'])\n    yield",
        step=folder / "primary.step",
    )

    def behave(**behaviour: Any) -> str:
        (folder / "behaviour.json").write_text(json.dumps(behaviour))
        return str(program)

    return behave


def test_each_button_is_drawn_and_is_grey_until_it_can_do_something(windows: Windows) -> None:
    found = windows(
        """
        def active():
            return [name for name in names if Gui.Command.get(name).isActive()]

        def steps():
            global names
            names = [name for name in Gui.listCommands() if name.startswith("Gomboc_")]
            window = Gui.getMainWindow()
            actions = {name: Gui.Command.get(name).getAction()[0] for name in names}
            bars, menu = window.findChildren(QtGui.QToolBar), window.findChildren(QtGui.QMenu)
            report(names=names, no_document=active(),
                   drawn=[name for name, action in actions.items() if not action.icon().isNull()],
                   told=[name for name, action in actions.items() if len(action.toolTip()) > 20],
                   bars=[name for name in names if any(actions[name] in bar.actions() for bar in bars)],
                   menu=[name for name in names if any(actions[name] in each.actions() for each in menu)])
            document = App.newDocument("empty")
            yield
            report(document=active())
            box, line = document.addObject("Part::Box", "Box"), document.addObject("Part::Line", "Line")
            document.recompute()
            select(line)
            yield
            report(line=active())
            select(box)
            yield
            report(box=active())
        """
    )
    assert set(found["names"]) == BUTTONS
    for where in ("drawn", "told", "bars", "menu"):
        assert set(found[where]) == BUTTONS, where
    assert found["no_document"] == ["Gomboc_SetUp"]
    assert set(found["document"]) == set(found["line"]) == {*NEW, "Gomboc_SetUp"}
    assert set(found["box"]) == {*NEW, "Gomboc_SetUp", "Gomboc_Check", "Gomboc_PlaceCom"}


@pytest.mark.slow
def test_first_use_installs_the_package_or_takes_a_python_that_has_it(
    windows: Windows, tmp_path: Path
) -> None:
    found = windows(
        """
        def state():
            return widget("GombocSetUpState").text()

        def steps():
            from freecad.gomboc import settings
            document = App.newDocument("first")
            press("Gomboc_ImuHousing")
            yield lambda: widget("GombocSetUp")
            report(missing=state(), objects=len(document.Objects))
            widget("GombocSetUpPython").setText("/nowhere/python")
            click("GombocSetUpUse")
            yield
            report(nowhere=state())
            widget("GombocSetUpSourceKind").setCurrentIndex(1)
            click("GombocSetUpInstall")
            yield
            report(no_source=state())
            widget("GombocSetUpSource").setText(inputs["wheel"])
            click("GombocSetUpInstall")
            yield lambda: widget("GombocSetUpInstall").isEnabled()
            report(installed=state(), output=widget("GombocSetUpOutput").toPlainText())
            widget("GombocSetUpPython").setText(inputs["real"])
            click("GombocSetUpUse")
            yield
            report(ready=state(), preference=settings.python())
            click("GombocSetUpClose")
            press("Gomboc_ImuHousing")
            yield lambda: widget("GombocNew")
            report(boards=[widget("GombocBoard").itemText(i) for i in range(widget("GombocBoard").count())])
        """,
        python="",
        wheel=wheel(tmp_path, "0.1.7"),
        real=sys.executable,
    )
    assert "gomboc-cad was not found" in found["missing"]
    assert found["objects"] == 0
    assert "/nowhere/python could not be started" in found["nowhere"]
    assert "Choose the wheel" in found["no_source"]
    assert "Successfully installed gomboc-cad-0.1.7" in found["output"]
    assert found["installed"].startswith("Ready: gomboc-cad 0.1.7")
    assert found["ready"].startswith("Ready: ")
    assert found["preference"] == sys.executable
    assert "adafruit-bno055" in found["boards"]


@pytest.fixture(scope="module")
def housing(display: str, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """A housing made by its button, looked at while it is built and after; what was found."""
    scratch = tmp_path_factory.mktemp("housing")
    folder = scratch / "Gehäuse 1"
    folder.mkdir()
    return _windows(display, scratch)(
        """
        class Browser(QtCore.QObject):
            pages = []

            @QtCore.Slot(QtCore.QUrl)
            def opened(self, url):
                self.pages.append(url.toLocalFile())

        def plain(value):
            if isinstance(value, float):
                # A file has 16 digits after the point.
                return f"{round(value, 12) + 0.0:.12g}"
            return [plain(entry) for entry in value] if isinstance(value, App.Vector) else str(value)

        def looks(document_object):
            view = document_object.ViewObject
            return [document_object.Label, list(view.ShapeColor[:3]), view.Visibility]

        def steps():
            import os
            from freecad.gomboc.views import marks
            document = App.newDocument("Unsaved")
            press("Gomboc_ImuHousing")
            yield lambda: widget("GombocNew")
            widget("GombocDiameter").setValue(60)
            widget("GombocMark").setText("")
            widget("GombocOverrides").setPlainText("mesh.sag_um=100")
            accept()
            yield lambda: widget("GombocResult")
            housing, stages, rounds, icon = document.ImuHousing, [], 0, None
            while not computed(housing):
                rounds += 1
                stages.append((widget("GombocStage").text(), widget("GombocStatusText").text()))
                if icon is None:
                    icon = marks.mark(housing)
                yield
            yield lambda: not widget("GombocStatus")
            report(stages=list(dict.fromkeys(stages)), rounds=rounds, running=icon, mark=marks.mark(housing))
            report(status=housing.Status, message=housing.Message, verdict=housing.Verdict,
                   s_margin=housing.SMargin, mass=housing.Mass, reasons=housing.Reasons,
                   panel=[widget("GombocVerdict").text(), widget("GombocReasons").text()])
            parts = [each for each in housing.Parts.Group if each.TypeId == "Part::Feature"]
            report(parts={each.Name: looks(each) for each in parts},
                   part_masses=sum(each.Mass for each in parts),
                   claimed=[each.Name for each in housing.ViewObject.claimChildren()],
                   datums=[each.Name for each in housing.Parts.Group if each not in parts],
                   readonly=housing.getEditorMode("Verdict"))
            up = App.Vector(-1, 0, 0) * -1
            camera = Gui.activeDocument().activeView().getCameraOrientation()
            report(up_on_screen=camera.multVec(App.Vector(0, 1, 0)).dot(up))
            housing.ViewObject.Visibility = False
            yield
            report(hidden=housing.Parts.ViewObject.Visibility)
            housing.ViewObject.Visibility = True
            yield
            report(console=console())
            document.imu_housing_upper.ViewObject.Visibility = False
            select()
            yield
            picture(inputs["picture"])

            browser = Browser()
            QtGui.QDesktopServices.setUrlHandler("file", browser, "opened")
            select(document.board)
            press("Gomboc_OpenReport")
            press("Gomboc_Export")
            yield lambda: widget("GombocExport")
            target = os.path.join(inputs["folder"], "für Ω")
            widget("GombocExport").fileSelected.emit(target)
            widget("GombocExport").close()
            yield
            page = open(browser.pages[0], encoding="utf-8").read(200)
            report(pages=browser.pages, page=page, exported=sorted(os.listdir(target)))

            press("Gomboc_PlaceCom")
            yield lambda: widget("GombocPlace")
            widget("GombocTarget").setCurrentIndex(widget("GombocTarget").findData("centroid"))
            accept()
            yield lambda: housing.Status == "running" and widget("GombocStop")
            press("Gomboc_Stop")
            yield lambda: computed(housing)
            yield
            report(stopped=[housing.Status, marks.mark(housing), housing.Verdict, housing.ComTarget],
                   again=bool(widget("GombocAgain")))
            housing.ComTarget = "best"
            document.recompute()
            yield
            report(restored=[housing.Status, marks.mark(housing)])

            press("Gomboc_ToleranceStudy")
            yield lambda: widget("GombocStudy")
            widget("GombocVariants").setValue(64)
            accept()
            yield lambda: document.getObject("ToleranceStudy") and document.ToleranceStudy.Status == "running"
            click("GombocStatusStop")
            yield lambda: computed(document.ToleranceStudy)
            report(study=document.ToleranceStudy.Status)
            document.removeObject("ToleranceStudy")

            file = os.path.join(inputs["folder"], "Gehäuse Ω.FCStd")
            document.saveAs(file)
            before = {name: plain(getattr(housing, name)) for name in housing.PropertiesList}
            App.closeDocument(document.Name)
            again = App.openDocument(file).ImuHousing
            yield
            after = {name: plain(getattr(again, name)) for name in again.PropertiesList}
            ignored = ("Proxy", "ExpressionEngine", "Files", "Parts", "Shape")
            report(changed=[name for name in before if before[name] != after[name] and name not in ignored],
                   reopened=[again.Status, marks.mark(again), again.Parts.Name, again.Shape.isValid()],
                   file=file)
            again.Document.recompute()
            yield
            report(recomputed=again.Status)
        """,
        timeout_s=900.0,
        folder=folder,
        picture=scratch / "housing.png",
    ) | {"picture": str(scratch / "housing.png"), "scratch": str(scratch)}


@pytest.mark.slow
def test_a_housing_comes_out_named_coloured_and_green(housing: dict[str, Any]) -> None:
    assert (housing["status"], housing["message"], housing["verdict"]) == ("done", "", "PASS")
    assert (housing["running"], housing["mark"]) == ("running", "pass")
    assert housing["s_margin"] > 0
    assert housing["mass"] == pytest.approx(housing["part_masses"], rel=1e-9)
    colors = {name: color for name, (_, color, _) in housing["parts"].items()}
    assert {"imu_housing_lower", "imu_housing_upper", "board", "pin_1"} <= colors.keys()
    assert colors["imu_housing_lower"] != colors["imu_housing_upper"]
    green, (red, middle, blue) = colors["board"], colors["board"]
    assert middle > max(red, blue), f"a board is green: {green}"
    assert all(visible for _, _, visible in housing["parts"].values())
    assert housing["claimed"] == ["ImuHousing_Parts"]
    assert set(housing["datums"]) == {"CentreOfMass", "DownAtRest"}
    assert housing["readonly"] == ["ReadOnly"]
    assert not housing["hidden"], "its parts are hidden with it"
    assert "PASS" in housing["panel"][0]
    assert housing["reasons"][0] in housing["panel"][1]
    assert housing["up_on_screen"] > 0.5, "it is seen standing, not lying on its side"


@pytest.mark.slow
def test_progress_is_seen_and_the_windows_stay_alive(housing: dict[str, Any]) -> None:
    stages = [panel for panel, _ in housing["stages"]]
    assert sum("making the solids" in text for text in stages) == 1
    assert len([text for text in stages if text.startswith("ImuHousing: ")]) >= 5
    assert all(status == panel for panel, status in housing["stages"] if panel and status)
    assert housing["rounds"] > 50, "FreeCAD's event loop went round while the housing was built"


@pytest.mark.slow
def test_buttons_record_what_they_do(housing: dict[str, Any]) -> None:
    assert "import freecad.gomboc.api" in housing["console"]
    call = (
        "freecad.gomboc.api.create_product(App.ActiveDocument, 'imu-housing', diameter_mm=60.0, mark='', "
        "overrides=['mesh.sag_um=100'])"
    )
    assert call in housing["console"].replace("\n", "")


@pytest.mark.slow
def test_report_and_files_leave_freecad(housing: dict[str, Any]) -> None:
    (page,) = housing["pages"]
    assert page.endswith("report.html")
    assert housing["page"].lower().startswith("<!doctype html>")
    assert {"imu-housing.step", "imu-housing-plate.3mf", "verdict.json"} <= set(housing["exported"])


@pytest.mark.slow
def test_a_stopped_run_keeps_what_was_there(housing: dict[str, Any]) -> None:
    assert housing["stopped"] == ["cancelled", "outdated", "PASS", "centroid"]
    assert housing["again"], "the panel offers to try again"
    assert housing["restored"] == ["done", "pass"], "with the old values the old results hold again"
    assert housing["study"] == "cancelled"


@pytest.mark.slow
def test_a_saved_housing_opens_again_as_it_was(housing: dict[str, Any]) -> None:
    assert housing["changed"] == []
    assert housing["reopened"] == ["done", "pass", "ImuHousing_Parts", True]
    assert housing["recomputed"] == "done", "nothing is built again"


@pytest.mark.slow
def test_the_file_shows_its_shapes_without_the_workbench(
    housing: dict[str, Any], display: str, tmp_path: Path
) -> None:
    found = _windows(display, tmp_path, linked=False)(
        """
        def steps():
            document = App.openDocument(inputs["file"])
            yield
            Gui.activeDocument().activeView().viewIsometric()
            Gui.SendMsgToActiveView("ViewFit")
            yield
            picture(inputs["picture"])
            report(addon="GombocWorkbench" in Gui.listWorkbenches(),
                   shown=[each.Name for each in document.Objects
                          if each.TypeId == "Part::Feature" and each.ViewObject.Visibility],
                   solids=len(document.ImuHousing.Shape.Solids))
        """,
        file=housing["file"],
        picture=tmp_path / "plain.png",
    )
    assert not found["addon"]
    assert {"imu_housing_lower", "board"} <= set(found["shown"])
    assert found["solids"] == len(housing["parts"])
    assert _colors(tmp_path / "plain.png") > 200


@pytest.mark.slow
def test_the_picture_of_a_housing_is_not_empty(housing: dict[str, Any]) -> None:
    assert _colors(Path(housing["picture"])) > 200


@pytest.mark.slow
def test_a_body_follows_its_properties_and_carries_maps(windows: Windows) -> None:
    found = windows(
        """
        def steps():
            from freecad.gomboc.views import marks
            document = App.newDocument("bodies")
            press("Gomboc_Body")
            yield lambda: widget("GombocNew")
            widget("GombocDiameter").setValue(60)
            accept()
            yield lambda: computed(document.getObject("Body"))
            body = document.Body
            report(first=[body.Verdict, body.Mass, body.Shape.Volume, body.ViewObject.Visibility])
            body.Diameter = 40
            body.recompute()
            yield lambda: body.Status == "done"
            report(second=[body.Verdict, body.Mass, body.Shape.Volume, marks.mark(body)])

            select(body)
            press("Gomboc_DrillMap")
            yield lambda: computed(document.getObject("DrillMap"))
            drill_map = document.DrillMap
            colors = drill_map.ViewObject.DiffuseColor
            largest = drill_map.Radii.index(max(drill_map.Radii))
            smallest = drill_map.Radii.index(min(drill_map.Radii))
            report(map=[drill_map.Status, len(drill_map.Shape.Faces), len(colors), len(set(colors))],
                   bright=sum(colors[largest][:3]) - sum(colors[smallest][:3]),
                   most=drill_map.MaxRadius, legend=widget("GombocFacts").text().count("bgcolor"),
                   hidden=not body.ViewObject.Visibility)

            select(body)
            press("Gomboc_LoadingZone")
            yield lambda: computed(document.getObject("LoadingZone"))
            zone = document.LoadingZone
            size = zone.Mesh.BoundBox
            report(zone=[zone.Status, zone.Mesh.CountFacets > 100, zone.ViewObject.Transparency],
                   size=max(size.XLength, size.YLength, size.ZLength), margins=[zone.SMargin, body.SMargin])
        """,
        timeout_s=900.0,
    )
    verdict, mass_g, volume_mm3, visible = found["first"]
    assert (verdict, visible) == ("PASS", True)
    assert volume_mm3 == pytest.approx(0.998 * 4 / 3 * 3.14159265 * 30**3, rel=0.01), "nearly a ball"
    assert found["second"][0] == "PASS"
    assert found["second"][3] == "pass"
    assert found["second"][1] / mass_g == pytest.approx((40 / 60) ** 3, rel=1e-3)
    assert found["second"][2] / volume_mm3 == pytest.approx((40 / 60) ** 3, rel=1e-3)
    status, faces, colored, different = found["map"]
    assert (status, faces) == ("done", colored)
    assert different > 10
    assert found["bright"] > 0.5, "where more may be drilled the map is brighter"
    assert found["most"] == pytest.approx(0.1325 * 20, rel=0.02), "0.13 R on the flanks of the primary"
    assert found["legend"] == 5
    assert found["hidden"]
    assert found["zone"][:2] == ["done", True]
    assert 40 <= found["zone"][2] < 100, "one can see through it"
    assert found["size"] == pytest.approx(40.0, rel=0.05), "its outer shell is the body"
    assert found["margins"][0] == pytest.approx(found["margins"][1], rel=1e-6)


@pytest.mark.slow
def test_a_part_of_the_user_is_told_the_truth(windows: Windows) -> None:
    """A box with one round edge rests on six faces; a capsule whose centre of mass is low rests on one pole.

    The capsule: hemispheres of radius 10 about (0, 0, 0) and (0, 0, 20) with a cylinder between them. With
    the centre of mass on its axis beyond one of these centres, the pole of that end is its only rest.
    """
    found = windows(
        """
        def verdict(check):
            return [check.Status, check.Verdict, check.Stable, list(check.CentreOfMass), marks.mark(check)]

        def steps():
            global marks
            from freecad.gomboc.views import marks
            document = App.newDocument("parts")
            box = document.addObject("Part::Box", "Box")
            fillet = document.addObject("Part::Fillet", "Fillet")
            fillet.Base, fillet.Edges = box, [(1, 2.0, 2.0)]
            import Part
            capsule = document.addObject("Part::Feature", "Capsule")
            tube = Part.makeCylinder(10, 20)
            balls = [Part.makeSphere(10), Part.makeSphere(10, App.Vector(0, 0, 20))]
            capsule.Shape = tube.fuse(balls).removeSplitter()
            low = document.addObject("Part::Vertex", "Low")
            low.Z = -4
            inside = document.addObject("Part::Vertex", "Inside")
            inside.X = inside.Y = inside.Z = 4
            document.recompute()
            select(capsule, low)
            press("Gomboc_Check")
            yield lambda: computed(document.getObject("Check"))
            report(capsule=verdict(document.Check), poses=document.Check.Poses)
            select(fillet)
            press("Gomboc_Check")
            yield lambda: computed(document.getObject("Check001"))
            view = document.Check001.ViewObject
            report(box=verdict(document.Check001), panel=widget("GombocVerdict").text(),
                   look=[view.DisplayMode, view.LineColor[0] > view.LineColor[1]])
            select(fillet, (inside, "Vertex1"))
            press("Gomboc_Check")
            yield lambda: widget("GombocStop")
            inside.Z = 3
            document.recompute()
            yield lambda: document.Check002.Status == "done"
            report(moved=verdict(document.Check002))
            select(capsule)
            press("Gomboc_PlaceCom")
            yield lambda: widget("GombocPlace")
            report(own=[widget("GombocPoint" + axis).value() for axis in "XYZ"])
            widget("GombocPointZ").setValue(-4)
            report(way=widget("GombocWay").text())
            Gui.Control.closeDialog()
            select(box)
            press("Gomboc_PlaceCom")
            yield lambda: widget("GombocPlace")
            widget("GombocPointX").setValue(2)
            accept()
            yield lambda: document.getObject("Check003")
            report(placed=[document.Check003.Part.Name, list(document.Check003.Com)])
            press("Gomboc_Stop")
            yield lambda: computed(document.Check003)
            import Mesh, PartDesign
            mesh = document.addObject("Mesh::Feature", "Mesh")
            mesh.Mesh = Mesh.createBox(10, 10, 10)
            design = document.addObject("PartDesign::Body", "Design")
            prism = design.newObject("PartDesign::AdditiveBox", "Prism")
            document.recompute()
            select(mesh)
            press("Gomboc_Check")
            yield lambda: computed(document.getObject("Check004"))
            select(prism)
            press("Gomboc_Check")
            yield lambda: document.getObject("Check005")
            report(mesh=verdict(document.Check004), checked=document.Check005.Part.Name)
            press("Gomboc_Stop")
            yield lambda: computed(document.Check005)
            select(low)
            report(point_alone=Gui.Command.get("Gomboc_Check").isActive())
        """,
        timeout_s=600.0,
    )
    status, answer, stable, com_mm, mark = found["box"]
    assert (status, answer, stable, mark) == ("done", "multistable", 6, "fail")
    # The edge that is rounded off is (1 − π/4) r² in section, its centroid 0.223 r from the two faces.
    cut, depth = (1 - 3.14159265 / 4) * 2**2, 0.2234 * 2
    assert sorted(abs(entry - 5.0) for entry in com_mm)[1:] == pytest.approx(
        [cut * (5 - depth) / (100 - cut)] * 2, rel=1e-2
    )
    assert "Several stable poses" in found["panel"]
    assert found["look"] == ["Flat Lines", True], "its poses are drawn, in red"
    assert found["capsule"] == ["done", "monostable", 1, [0, 0, -4], "pass"]
    assert "-1.0000), height 6 mm" in found["poses"][0], "that pole is down"
    assert found["moved"] == ["done", "multistable", 6, [4, 4, 3], "fail"], "it follows the point"
    assert found["own"] == pytest.approx([0, 0, 10], abs=1e-3)
    assert "14 mm" in found["way"]
    assert found["placed"] == ["Box", [2, 5, 5]]
    assert found["mesh"] == ["done", "multistable", 6, [0, 0, 0], "fail"]
    assert found["checked"] == "Design", "a feature stands for its Part Design body"
    assert not found["point_alone"]


def test_what_goes_wrong_is_said_and_leaves_freecad_usable(
    windows: Windows, slow_package: Callable[..., str]
) -> None:
    found = windows(
        """
        import json, os, signal

        def behave(**behaviour):
            folder = os.path.dirname(os.environ["GOMBOC_CAD_PYTHON"])
            with open(os.path.join(folder, "behaviour.json"), "w") as stream:
                json.dump(behaviour, stream)

        def new_body():
            press("Gomboc_Body")
            yield lambda: widget("GombocNew")
            accept()

        def steps():
            from freecad.gomboc import jobs
            document = App.newDocument("troubles")
            yield from new_body()
            yield lambda: widget("GombocBar")
            yield from new_body()
            yield lambda: document.getObject("Body001")
            report(two=[document.Body.Status, document.Body001.Status])
            yield lambda: "waiting" in widget("GombocStatusText").text()
            document.removeObject("Body001")
            yield
            report(deleted=len(jobs.queue.jobs()))
            yield lambda: jobs.queue.running.run is not None and jobs.queue.running.progress is not None
            press("Gomboc_Stop")
            yield lambda: computed(document.Body)
            report(stopped=[document.Body.Status, document.Body.Message],
                   stop_is_grey=not Gui.Command.get("Gomboc_Stop").isActive())

            behave(kill=True)
            document.removeObject("Body")
            yield from new_body()
            yield lambda: computed(document.getObject("Body"))
            yield
            report(killed=[document.Body.Status, document.Body.Message], panel=widget("GombocStage").text())

            behave(sentence="The diameter is too odd; choose an even one.")
            Gui.Control.closeDialog()
            document.Body.Diameter = 31
            document.recompute()
            yield lambda: any("odd" in text for text in messages())
            report(refused=[text for text in messages() if "odd" in text])
            widget("GombocNotice").close()

            behave()
            document.recompute()
            yield lambda: document.Body.Status == "done"
            report(mended=[document.Body.Verdict, document.Body.SMargin, document.Body.Message])

            behave(seconds=60)
            document.Body.Diameter = 33
            document.recompute()
            yield lambda: jobs.queue.running
            App.closeDocument("troubles")
            yield lambda: not jobs.queue.jobs()
            other = App.newDocument("next")
            other.addObject("Part::Box", "Box")
            other.recompute()
            yield
            report(next=other.Box.Shape.Volume)

            hollow = other.addObject("Part::Feature", "Hollow")
            import Part
            hollow.Shape = Part.makeShell(other.Box.Shape.Faces)
            group = other.addObject("App::Part", "Empty")
            select(hollow)
            report(shell=Gui.Command.get("Gomboc_Check").isActive())
            select(group)
            press("Gomboc_Check")
            yield lambda: messages()
            report(empty=messages(),
                   objects=[each.Name for each in other.Objects if hasattr(each, "Verdict")])
        """,
        python=slow_package(seconds=60),
        timeout_s=240.0,
    )
    assert found["two"] == ["running", "queued"]
    assert found["deleted"] == 1
    assert found["stopped"][0] == "cancelled"
    assert "was stopped" in found["stopped"][1]
    assert found["stop_is_grey"]
    assert found["killed"][0] == "failed"
    assert "ended unexpectedly while making the solid" in found["killed"][1]
    assert found["panel"] == found["killed"][1]
    assert found["refused"] == ["The diameter is too odd; choose an even one."]
    assert found["mended"] == ["PASS", pytest.approx(0.031), ""]
    assert found["next"] == pytest.approx(1000.0)
    assert not found["shell"]
    assert len(found["empty"]) == 1
    assert "no solid" in found["empty"][0]
    assert found["objects"] == []


@pytest.mark.parametrize(
    ("button", "kind", "field"),
    [("Gomboc_SeedPod", "seed-pod", "Species"), ("Gomboc_Buoy", "buoy", "Battery")],
)
def test_the_other_products_begin_the_same_way(windows: Windows, button: str, kind: str, field: str) -> None:
    found = windows(
        """
        def steps():
            document = App.newDocument("products")
            press(inputs["button"])
            yield lambda: widget("GombocNew")
            choice = widget("Gomboc" + inputs["field"])
            report(choices=[choice.itemText(i) for i in range(choice.count())],
                   board=bool(widget("GombocBoard")))
            widget("GombocProcess").setCurrentText("sls")
            accept()
            made = lambda: [each for each in document.Objects if hasattr(each, "Verdict")]
            yield lambda: made() and made()[0].Status == "running" and widget("GombocStop")
            report(product=made()[0].Product, process=made()[0].Process)
            click("GombocStop")
            yield lambda: computed(made()[0])
            report(status=made()[0].Status, children=len(made()[0].OutList))
        """,
        button=button,
        field=field,
    )
    assert len(found["choices"]) >= 5
    assert not found["board"]
    assert (found["product"], found["process"]) == (kind, "sls")
    assert (found["status"], found["children"]) == ("cancelled", 0)


def _colors(picture: Path) -> int:
    """How many colours there are where the model is seen; the bare background has some 120 rows of blue."""
    from matplotlib.image import imread

    pixels = imread(picture)[300:800, 500:1100, :3]
    return len({tuple(row) for row in pixels[::4, ::4].reshape(-1, 3).tolist()})
