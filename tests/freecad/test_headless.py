"""The workbench inside a real FreeCAD without windows, linked into Mod/, with the real package beside it."""

from __future__ import annotations

import json
import math
import shutil
import sys
import textwrap
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gomboc_cad.body import mass_properties
from gomboc_cad.body.catalogue import named_body
from gomboc_cad.equilibria import smooth_census
from gomboc_cad.equilibria.drill_map import drill_limits
from tests.external import FreeCAD
from tests.freecad.conftest import WORKBENCH

Run = Callable[..., dict[str, Any]]

# A build takes half a minute of processor time; machines that test share their processors.
TIME_LIMIT_S = 600.0

START = """\
import os, sys
import FreeCAD as App
import Part
App.ParamGet("User parameter:BaseApp/Preferences/Document").SetBool("CreateBackupFiles", False)
os.environ["GOMBOC_CAD_PYTHON"] = inputs.get("python", "")
from freecad.gomboc import api, environment, jobs


def refused(function, *arguments, **named):
    try:
        function(*arguments, **named)
    except api.GombocCadError as error:
        return str(error)
    raise AssertionError("nothing was raised")
"""


def runner(freecadcmd: str, home: Path, linked: bool) -> Run:
    """FreeCAD with a home of its own; its temporary files go to a folder with blanks and other letters."""
    (home / "Mod").mkdir(parents=True)
    if linked:
        (home / "Mod" / "gomboc-cad").symlink_to(WORKBENCH)
    freecad = FreeCAD(freecadcmd, home)

    def run(script: str, **inputs: Any) -> dict[str, Any]:
        begin = START if linked else "import FreeCAD as App\n"
        inputs = {"python": sys.executable, **inputs}
        return freecad.run(begin + textwrap.dedent(script), timeout_s=TIME_LIMIT_S, **inputs)

    return run


@pytest.fixture
def scratch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for temporary files; whatever the workbench puts there it has to remove."""
    folder = tmp_path / "Ordner für Ω 1"
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(folder))
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.delenv("GOMBOC_CAD_PYTHON", raising=False)
    return folder


@pytest.fixture
def run(freecadcmd: str, tmp_path: Path, scratch: Path) -> Run:
    """Run a script in a FreeCAD that has the workbench."""
    return runner(freecadcmd, tmp_path / "home", linked=True)


@pytest.fixture
def run_plain(freecadcmd: str, tmp_path: Path, scratch: Path) -> Run:
    """Run a script in a FreeCAD that does not have it."""
    return runner(freecadcmd, tmp_path / "plain", linked=False)


@pytest.fixture
def package(tmp_path: Path, run_plain: Run) -> Callable[..., str]:
    """`package(version=…, kill=True, …)` is the path of a stand-in for a Python that has the package."""
    folder = tmp_path / "päckage 1"
    folder.mkdir()
    program = folder / "python"
    program.write_text(
        Path(__file__)
        .with_name("fake_package.py")
        .read_text()
        .replace("/usr/bin/env python3", sys.executable)
    )
    program.chmod(0o755)
    run_plain("import Part; Part.makeBox(1, 2, 3).exportStep(inputs['step'])", step=folder / "primary.step")

    def behave(**behaviour: Any) -> str:
        (folder / "behaviour.json").write_text(json.dumps(behaviour))
        return str(program)

    return behave


def test_a_body_is_what_the_package_says(run: Run, run_plain: Run, scratch: Path) -> None:
    file = scratch / "Körper 1.FCStd"
    found = run(
        """
        doc = App.newDocument("bodies")
        body = api.create_body(doc, "primary", diameter_mm=60, material="aluminium")
        first = dict(
            verdict=body.Verdict, good=body.Good, margin=body.SMargin, mass=body.Mass, reasons=body.Reasons,
            volume=body.Shape.Volume, com=list(body.CentreOfMass), state=body.State, status=body.Status,
            types={name: body.getTypeIdOfProperty(name) for name in ("Diameter", "Body", "Material")},
            read_only=[name for name in body.PropertiesList if "ReadOnly" in body.getEditorMode(name)],
            point=[doc.CentreOfMass.X.Value, doc.CentreOfMass.Y.Value, doc.CentreOfMass.Z.Value],
            line=[list(vertex.Point) for vertex in doc.DownAtRest.Shape.Vertexes],
        )
        asked = []
        jobs.queue.subscribe(lambda job: asked.append((job.state, job.progress and job.progress.text)))
        doc.recompute()
        doc.recompute(None, True)
        unasked = list(asked)
        drill = api.create_drill_map(doc, body, sites=500)
        shell = Part.makeShell(drill.Shape.Faces)
        largest = list(drill.Shape.Faces[drill.Radii.index(max(drill.Radii))].CenterOfMass)
        body.Diameter = "0.1 mm"
        doc.recompute()
        failed = [body.Status, body.Message, body.Shape.Volume, body.isValid(), drill.MaxRadius]
        del asked[:]
        body.Diameter = "60 mm"
        doc.recompute()
        taken_back = [body.Status, body.Message, body.isValid(), list(asked)]
        body.Diameter = "5 cm"
        body.Placement.Base = App.Vector(10, 20, 30)
        doc.recompute([body])
        report(
            **first, unasked=unasked, asked=asked, failed=failed, taken_back=taken_back,
            valid=body.isValid(), status_again=body.Status,
            small=[body.Shape.Volume, body.SMargin, body.Message], center=list(body.Shape.CenterOfMass),
            moved=list(body.Parts.Placement.Base),
            drill=[drill.MaxRadius, list(drill.MaxDirection), len(drill.Radii), min(drill.Radii), largest,
                   len(shell.Faces), shell.isClosed()],
        )
        doc.saveAs(inputs["file"])
        """,
        file=file,
    )
    model, census = named_body("primary", 60.0), smooth_census(named_body("primary", 60.0))
    truth = mass_properties(model)
    assert (found["verdict"], found["good"], found["status"]) == ("PASS", True, "done")
    assert found["state"] == ["Up-to-date"]
    assert found["margin"] == pytest.approx(census.margin.s_margin_mm, rel=1e-6)
    assert found["volume"] == pytest.approx(truth.volume_mm3, rel=1e-3)
    assert found["mass"] == pytest.approx(2.7e-3 * truth.volume_mm3, rel=0.01)
    assert found["com"] == pytest.approx(truth.com_mm, abs=1e-6)
    assert found["point"] == pytest.approx(found["com"])
    begin, end = found["line"]
    assert begin == pytest.approx(found["com"], abs=1e-6)
    assert math.dist(begin, end) > census.rest.height_mm, "the line reaches the floor"
    down = [(b - a) / math.dist(begin, end) for a, b in zip(begin, end, strict=True)]
    assert down == pytest.approx(census.rest.direction, abs=1e-6)
    assert found["types"] == {
        "Diameter": "App::PropertyLength",
        "Body": "App::PropertyEnumeration",
        "Material": "App::PropertyEnumeration",
    }
    results = {"Verdict", "Good", "SMargin", "Mass", "Reasons", "Message", "CentreOfMass", "RestDirection"}
    assert results <= set(found["read_only"])
    assert not {"Diameter", "Body", "Material", "Placement"} & set(found["read_only"])

    assert found["unasked"] == [], "nothing changed, so nothing is computed"
    status, message, volume, valid, old_radius = found["failed"]
    assert (status, valid) == ("failed", False)
    assert "--diameter-mm 0.1 is not allowed" in message
    assert volume == pytest.approx(found["volume"], rel=1e-12)
    assert found["taken_back"] == ["done", "", True, []], "what is there is of these values already"
    assert found["small"] == [
        pytest.approx((5 / 6) ** 3 * volume),
        pytest.approx(5 / 6 * found["margin"]),
        "",
    ]
    assert (found["valid"], found["status_again"]) == (True, "done")
    assert ["running", "making the solid"] in found["asked"]
    assert found["moved"] == [10.0, 20.0, 30.0]
    shifted = [a + 5 / 6 * b for a, b in zip((10.0, 20.0, 30.0), truth.com_mm, strict=True)]
    assert found["center"] == pytest.approx(shifted, abs=5e-3)

    most, direction, count, least, place, faces, closed = found["drill"]
    assert old_radius == most, "a subject that failed leaves the map as it was"
    assert count == faces == 2 * 500 - 4
    assert closed
    assert 0.0 <= least < most
    best = drill_limits(model, np.array([direction]), census.com_mm)
    assert best.radius_mm[0] == pytest.approx(most, rel=1e-6)
    assert math.dist(best.positions_mm[0], place) < 5.0, "it is on the face that shows it, 5 mm wide"

    assert [path for path in scratch.iterdir() if path.name.startswith("gomboc-")] == []
    reopened = run(
        """
        doc = App.openDocument(inputs["file"])
        body = doc.Body
        asked = []
        jobs.queue.subscribe(lambda job: asked.append(job.state))
        body.touch()
        doc.recompute([body])
        report(kind=body.Proxy.kind, volume=body.Shape.Volume, verdict=body.Verdict, margin=body.SMargin,
               diameter=body.Diameter.Value, choices=body.getEnumerationsOfProperty("Material"), asked=asked,
               radii=len(doc.DrillMap.Radii), read_only="ReadOnly" in body.getEditorMode("Mass"))
        """,
        file=file,
    )
    assert reopened["volume"] == pytest.approx(found["small"][0])
    assert reopened["margin"] == pytest.approx(found["small"][1], rel=1e-12)
    assert (reopened["kind"], reopened["verdict"], reopened["diameter"]) == ("body", "PASS", 50.0)
    assert reopened["radii"] == 996
    assert "aluminium" in reopened["choices"]
    assert reopened["read_only"]
    assert reopened["asked"] == []
    plain = run_plain(
        """
        doc = App.openDocument(inputs["file"])
        report(volumes={o.Name: o.Shape.Volume for o in doc.Objects if hasattr(o, "Shape")})
        """,
        file=file,
    )
    assert plain["volumes"]["Body"] == pytest.approx(found["small"][0])


def test_a_housing_has_its_parts_and_its_files(run: Run, run_plain: Run, scratch: Path) -> None:
    file, folder = scratch / "Gehäuse.FCStd", scratch / "Ausgabe Ω"
    found = run(
        """
        doc = App.newDocument()
        housing = api.create_product(
            doc, "imu-housing", diameter_mm=60, mark="", overrides=["mesh.sag_um=200", " plate.copies = 2"]
        )
        doc.saveAs(inputs["file"])
        parts = [part for part in housing.Parts.Group if part.TypeId == "Part::Feature"]
        report(
            verdict=housing.Verdict, margin=housing.SMargin, mass=housing.Mass, reasons=housing.Reasons,
            com=list(housing.CentreOfMass), product=housing.Product, board=housing.Board,
            group=[housing.Parts.TypeId, [child.TypeId for child in housing.Parts.Group]],
            parts=[[p.Label, p.Material, p.Mass, list(p.Colour)[:3], p.Shape.Volume, p.Shape.isValid()]
                   for p in parts],
            solids=len(housing.Shape.Solids), volume=housing.Shape.Volume,
            wrong=[refused(api.create_product, doc, "teapot"),
                   refused(api.create_product, doc, "imu-housing", board="none at all"),
                   refused(api.create_product, doc, "imu-housing", overrides=["sag"]),
                   refused(api.place_com, housing, "somewhere"),
                   refused(api.place_com, housing, trim="magic"),
                   refused(api.place_com, parts[0]),
                   refused(api.create_zone, doc, parts[0])],
            objects=len(doc.Objects),
        )
        """,
        file=file,
    )
    again = run(
        """
        doc = App.openDocument(inputs["file"])
        housing = doc.ImuHousing
        doc.recompute(None, True)
        written = api.export(housing, inputs["folder"])

        # The assembly beside a verdict that is not its own.
        import json, pathlib, shutil
        answer = pathlib.Path(inputs["file"]).parent / "answer"
        shutil.copytree(inputs["folder"], answer / "files")

        def doctored(change):
            told = json.loads((answer / "files" / "verdict.json").read_text(encoding="utf-8"))
            change(told["parts"])
            return refused(housing.Proxy.read, housing, told, answer)

        def swap(parts):
            parts[0]["name"], parts[1]["name"] = parts[1]["name"], parts[0]["name"]

        doctored = [doctored(swap), doctored(list.pop),
                    doctored(lambda parts: parts[2].update(volume_mm3=1.002 * parts[2]["volume_mm3"]))]
        report(doctored=doctored)
        report(written=written, refused=refused(api.export, housing, inputs["folder"]),
               page=open(api.report_page(housing), encoding="utf-8").read(15), status=housing.Status,
               overrides=housing.Overrides, objects=len(doc.Objects), solids=len(housing.Shape.Solids),
               labels=[part.Label for part in housing.Parts.Group])
        """,
        file=file,
        folder=folder,
    )
    verdict = json.loads((folder / "verdict.json").read_text(encoding="utf-8"))
    assert (found["verdict"], found["margin"]) == (verdict["verdict"], verdict["s_margin_mm"])
    assert found["reasons"] == verdict["reasons"]
    assert found["mass"] == verdict["assembly"]["mass_g"]
    assert found["com"] == pytest.approx(verdict["assembly"]["com_mm"])
    assert verdict["spec"]["mesh"]["sag_um"] == 200.0
    assert verdict["spec"]["plate"]["copies"] == 2
    assert (found["product"], found["board"]) == ("imu-housing", "adafruit-bno055")
    assert found["group"] == [
        "App::Part",
        [*["Part::Feature"] * len(verdict["parts"]), "Part::Vertex", "Part::Line"],
    ]
    for (label, material, mass, color, volume, valid), told in zip(
        found["parts"], verdict["parts"], strict=True
    ):
        assert (label, material, mass) == (told["name"], told["material"], told["mass_g"])
        assert color == pytest.approx(told["color"], abs=1e-6)
        assert volume == pytest.approx(told["volume_mm3"], rel=1e-3)
        assert valid
    assert len({tuple(color) for *_, color, _, _ in found["parts"]}) > 3
    assert found["solids"] == again["solids"] == len(verdict["parts"])
    for sentence, wanted in zip(
        found["wrong"],
        (
            "imu-housing",
            "adafruit-bno055",
            "KEY=VALUE",
            "com_target",
            "set-screws",
            "not a body",
            "not a body",
        ),
        strict=True,
    ):
        assert wanted in sentence
    assert found["objects"] == again["objects"], "what failed left nothing behind"
    assert again["status"] == "done"
    assert again["overrides"] == ["mesh.sag_um=200", "plate.copies=2"]
    assert sorted(again["written"]) == sorted(str(path) for path in folder.rglob("*") if path.is_file())
    assert "is there already" in again["refused"]
    assert all("do not fit the verdict" in sentence for sentence in again["doctored"])
    assert again["page"].lower() == "<!doctype html>"

    plain = run_plain(
        """
        doc = App.openDocument(inputs["file"])
        report(volumes={o.Label: o.Shape.Volume for o in doc.Objects if o.TypeId.startswith("Part::Feature")})
        """,
        file=file,
    )
    assert plain["volumes"].pop("ImuHousing") == pytest.approx(found["volume"])
    assert plain["volumes"] == {part[0]: pytest.approx(part[4]) for part in found["parts"]}


def test_a_part_that_someone_modelled_is_told_the_truth(run: Run) -> None:
    found = run(
        """
        import Mesh, MeshPart
        doc = App.newDocument("parts")
        slab = doc.addObject("Part::Box", "Slab")
        slab.Length, slab.Width, slab.Height = 40, 20, 4
        group = doc.addObject("App::Part", "Group")
        group.Placement = App.Placement(App.Vector(100, 0, 0), App.Rotation())
        fillet = doc.addObject("Part::Fillet", "Fillet")
        fillet.Base = slab
        group.addObject(slab)
        group.addObject(fillet)
        far = App.Vector(40, 10, 4)
        at = [edge.CenterOfMass.distanceToPoint(far) < 1e-9 for edge in slab.Shape.Edges]
        fillet.Edges = [(at.index(True) + 1, 3.0, 3.0)]

        cylinder = Part.makeCylinder(10, 30, App.Vector(-15, 0, 0), App.Vector(1, 0, 0))
        ends = [Part.makeSphere(10, App.Vector(x, 0, 0)) for x in (-15, 15)]
        capsule = doc.addObject("Part::Feature", "Capsule")
        capsule.Shape = cylinder.fuse(ends).removeSplitter()
        lead = doc.addObject("Part::Vertex", "Lead")
        lead.Z = -3
        coarse = doc.addObject("Mesh::Feature", "Coarse")
        coarse.Mesh = MeshPart.meshFromShape(Shape=capsule.Shape, LinearDeflection=0.1)
        coarse.Placement.Base = App.Vector(0, 50, 0)
        plane = doc.addObject("Part::Plane", "Plane")
        doc.recompute()
        before = [o.Name for o in doc.Objects]
        slab_found = api.check(fillet)
        mesh_found = api.check(coarse)
        refusals = [refused(api.check, plane), refused(api.create_check, doc, plane),
                    refused(api.create_check, doc, capsule, point=(slab, "Edge1")),
                    refused(api.check, capsule, com_mm=(1, 2))]
        left = [o.Name for o in doc.Objects]
        loaded = api.create_check(doc, capsule, point=(lead, "Vertex1"))
        report(slab=slab_found, mesh=mesh_found, refusals=refusals, before=before, left=left,
               loaded=[loaded.Verdict, loaded.Good, loaded.Stable, loaded.Unstable, loaded.Saddles],
               com=list(loaded.CentreOfMass), line=loaded.Shape.Edges[0].Length, poses=loaded.Poses)
        """
    )
    slab = found["slab"]
    # The centroid of the cross-section: a rectangle less what is between the round and the corner.
    width, height, radius = 40.0, 4.0, 3.0
    cut = (1.0 - math.pi / 4.0) * radius**2
    inset = radius * (10.0 - 3.0 * math.pi) / (12.0 - 3.0 * math.pi)  # its centroid, from the corner
    area = width * height - cut
    com = [
        (width * height * width / 2.0 - cut * (width - inset)) / area,
        10.0,
        (width * height * height / 2.0 - cut * (height - inset)) / area,
    ]
    assert slab["com_mm"] == pytest.approx([100.0 + com[0], com[1], com[2]], abs=1e-6)
    # The end that is left, 1 mm high, is below the centre of mass's foot: of six faces five are rests.
    assert com[2] > height - radius
    assert (slab["stable"], slab["verdict"]) == (5, "multistable")
    assert not any(pose["direction"][0] > 0.5 for pose in slab["poses"])
    # Homogeneous, a capsule rolls: a ring of poses round its axis.
    mesh = found["mesh"]
    assert [pose["extent"] for pose in mesh["poses"]] == ["ring"]
    assert mesh["verdict"] == "undecided"
    assert mesh["com_mm"] == pytest.approx([0.0, 50.0, 0.0], abs=0.05)
    # Loaded, it lies with the load below: one rest, both tips up as maxima, load up as a saddle.
    assert found["loaded"] == ["monostable", True, 1, 2, 1]
    assert found["com"] == [0.0, 0.0, -3.0]
    assert found["line"] == pytest.approx(1.25 * 7.0, abs=1e-3)
    assert len(found["poses"]) == 1
    plane, as_object, edge, two_numbers = found["refusals"]
    assert "Plane has no solid" in plane == as_object
    assert "no single point" in edge
    assert "three numbers" in two_numbers
    assert found["left"] == found["before"]


def test_what_goes_wrong_outside_leaves_the_document_as_it_was(
    run: Run, package: Callable[..., str], scratch: Path
) -> None:
    python = Path(package())
    behaviours = {
        "killed": {"kill": True},
        "garbage": {"output": "no JSON"},
        "sentence": {"sentence": "The disc is full."},
        "incomplete": {"without": "s_margin_mm"},
        "step": {"step": "calls"},
    }
    found = run(
        """
        import json, pathlib
        doc = App.newDocument("faults")
        body = api.create_body(doc, "primary", diameter_mm=60)
        before = [body.Shape.Volume, body.SMargin, len(doc.Objects)]
        said = {}
        for name, behaviour in inputs["behaviours"].items():
            pathlib.Path(inputs["python"]).with_name("behaviour.json").write_text(json.dumps(behaviour))
            body.Diameter = body.Diameter.Value + 1
            doc.recompute()
            said[name] = [body.Status, body.Message, body.isValid(), body.Shape.Volume, body.SMargin]
            said[name].append(refused(api.create_body, doc, "primary"))
        after = [body.Shape.Volume, body.SMargin, len(doc.Objects)]
        pathlib.Path(inputs["python"]).with_name("behaviour.json").write_text("{}")
        doc.recompute()
        report(before=before, after=after, said=said, well=[body.Status, body.Message, body.SMargin])
        environment.forget()
        os.environ["GOMBOC_CAD_PYTHON"] = "/nowhere/python"
        absent = [refused(api.create_body, doc), refused(api.check, body)]
        os.environ["GOMBOC_CAD_PYTHON"] = ""
        environment.forget()
        none = refused(api.create_body, doc)
        os.environ["GOMBOC_CAD_PYTHON"] = inputs["python"]
        pathlib.Path(inputs["python"]).with_name("behaviour.json").write_text('{"version": "9.9.0"}')
        environment.forget()
        wrong = refused(api.create_body, doc)
        os.environ["GOMBOC_CAD_PYTHON"] = inputs["bare"]
        environment.forget()
        bare = refused(api.create_body, doc)
        report(absent=absent, none=none, wrong=wrong, bare=bare, count=len(doc.Objects))
        """,
        python=python,
        behaviours=behaviours,
        bare=shutil.which("true"),
    )
    assert found["before"] == found["after"]
    for status, message, valid, volume, margin, raised in found["said"].values():
        assert (status, valid, volume, margin) == ("failed", False, *found["before"][:2])
        assert message
        assert raised.split(" while ")[0] == message.split(" while ")[0]
    said = {name: values[1] for name, values in found["said"].items()}
    assert said["killed"].startswith("gomboc-cad ended unexpectedly while making the solid")
    assert said["sentence"] == "The disc is full."
    assert "cannot be read" in said["garbage"]
    assert "s_margin_mm" in said["incomplete"]
    assert "cannot be read" in said["step"]
    assert found["well"] == ["done", "", pytest.approx(1e-3 * 65.0)]
    assert all("/nowhere/python could not be started" in sentence for sentence in found["absent"])
    assert "was not found" in found["none"]
    assert "gomboc-cad 9.9.0" in found["wrong"]
    assert "update the package" in found["wrong"]
    assert "does not have a gomboc-cad" in found["bare"]
    assert found["count"] == found["before"][2]
    assert [path for path in scratch.iterdir() if path.name.startswith("gomboc-")] == []


def test_jobs_wait_are_stopped_and_give_way(run: Run, package: Callable[..., str], scratch: Path) -> None:
    found = run(
        """
        import json, pathlib, time
        from freecad.gomboc import process
        process._POLITE_S = 0.3
        beside = pathlib.Path(inputs["python"]).parent
        doc = App.newDocument("jobs")
        one, two = api.create_body(doc, "primary"), api.create_body(doc, "primary")
        (beside / "calls").unlink()
        (beside / "behaviour.json").write_text('{"seconds": 0.4}')
        queue, heard = jobs.queue, []
        queue.subscribe(lambda job: heard.append([job.object_name, job.state]))

        def begun(job):
            while job.progress is None:
                job.run.poll()

        # Two at once: the second waits, asked for twice it still runs once.
        one.Diameter, two.Diameter = 41, 42
        first, second = queue.request(one), queue.request(two)
        queue.request(two)
        both = [first.state, second.state, [job.object_name for job in queue.jobs()]]
        api.wait(timeout_s=20)
        done = [one.SMargin, two.SMargin, one.Status, two.Status]
        calls = len((beside / "calls").read_text().splitlines())

        # A value that changes in mid-run: the run of the old value is given up without a word.
        one.Diameter = 43
        old = queue.request(one)
        begun(old)
        one.Diameter = 44
        queue.request(one)
        api.wait(one, timeout_s=20)
        changed = [one.SMargin, one.Status, one.Message, old.state]

        # A value that is put back in mid-run: what is there is right already.
        two.Diameter = 48
        begun(queue.request(two))
        two.Diameter = 42
        doc.recompute()
        put_back = [two.Status, two.Message]
        api.wait(timeout_s=20)
        put_back += [two.Status, two.SMargin]

        # No place for temporary files: that job fails, the queue goes on.
        def full(**named):
            raise OSError("no space left")

        make_folder, jobs.tempfile.mkdtemp = jobs.tempfile.mkdtemp, full
        two.Diameter = 49
        no_place = queue.request(two).message
        jobs.tempfile.mkdtemp = make_folder
        queue.request(two)
        api.wait(timeout_s=20)
        then = [two.Status, two.SMargin]

        # Cancel, of a program that does not listen.
        (beside / "behaviour.json").write_text('{"seconds": 30, "deaf": true}')
        one.Diameter = 45
        stopped = queue.request(one)
        begun(stopped)
        waiting = queue.request(two)
        late = refused(api.wait, one, timeout_s=0.1)
        queue.cancel(two)
        queue.cancel(one)
        begin = time.monotonic()
        api.wait(timeout_s=20)
        cancelled = [one.Status, one.SMargin, one.Message, "Touched" in one.State, two.Status, waiting.state]
        pid = int((beside / "pid").read_text())
        gone = not os.path.exists(f"/proc/{pid}")

        # An object that is deleted, a document that is closed, in mid-run.
        (beside / "behaviour.json").write_text('{"seconds": 0.4}')
        one.Diameter = 46
        begun(queue.request(one))
        doc.removeObject("Body")
        api.wait(timeout_s=20)
        two.Diameter = 47
        begun(queue.request(two))
        App.closeDocument("jobs")
        api.wait(timeout_s=20)
        report(put_back=put_back, no_place=no_place, then=then)
        report(both=both, done=done, calls=calls, changed=changed, cancelled=cancelled, gone=gone, late=late,
               heard=heard, idle=queue.jobs() == [], documents=list(App.listDocuments()))
        """,
        python=package(),
    )
    assert found["both"] == ["running", "queued", ["Body", "Body001"]]
    assert found["done"] == [pytest.approx(0.041), pytest.approx(0.042), "done", "done"]
    assert found["calls"] == 2
    assert found["changed"] == [pytest.approx(0.044), "done", "", "cancelled"]
    assert found["put_back"] == ["done", "", "done", pytest.approx(0.042)]
    assert found["no_place"] == "no space left"
    assert found["then"] == ["done", pytest.approx(0.049)]
    status, margin, message, touched, other, waiting = found["cancelled"]
    assert (status, other, waiting) == ("cancelled", "cancelled", "cancelled")
    assert margin == pytest.approx(0.044)
    assert "was stopped" in message
    assert touched, "a recompute tries again"
    assert found["gone"]
    assert "within 0.1 s" in found["late"]
    assert found["idle"]
    assert found["documents"] == []
    assert ["Body", "running"] in found["heard"]
    assert [path for path in scratch.iterdir() if path.name.startswith("gomboc-")] == []


def wheel(folder: Path, version: str) -> Path:
    """A wheel named like the package, whose only wisdom is its version."""
    path = folder / f"gomboc_cad-{version}-py3-none-any.whl"
    information = f"gomboc_cad-{version}.dist-info"
    contents = {
        "gomboc_cad/__init__.py": "",
        "gomboc_cad/__main__.py": f"print('gomboc-cad {version}')\n",
        f"{information}/METADATA": f"Metadata-Version: 2.1\nName: gomboc-cad\nVersion: {version}\n",
        f"{information}/WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    contents[f"{information}/RECORD"] = (
        "".join(f"{name},,\n" for name in contents) + f"{information}/RECORD,,\n"
    )
    with zipfile.ZipFile(path, "w") as packed:
        for name, text in contents.items():
            packed.writestr(name, text)
    return path


def test_the_package_is_installed_into_an_environment_of_its_own(run: Run, tmp_path: Path) -> None:
    good, newer = wheel(tmp_path, "0.1.5"), wheel(tmp_path, "9.9.0")
    found = run(
        """
        from freecad.gomboc import settings
        missing = type(environment.state()).__name__
        lines, ends = [], []
        installation = environment.install(inputs["good"], lines.append, ends.append)
        installation.wait()
        state = environment.state()
        report(missing=missing, lines=lines, ends=ends,
               state=[type(state).__name__, state.version, state.python],
               preference=settings.python(), folder=str(settings.private_environment()))
        newer = environment.install(inputs["newer"], on_end=ends.append)
        wrong = refused(newer.wait)
        stopped = environment.install(inputs["good"])
        stopped.cancel()
        report(wrong=wrong, stopped=refused(stopped.wait), ends=ends, last=type(environment.state()).__name__,
               absent=refused(environment.install, "/nowhere/x.whl"),
               use=refused(environment.use, "/nowhere/python"),
               kept=settings.python())
        """,
        python="",
        good=good,
        newer=newer,
    )
    assert found["missing"] == "Missing"
    assert any("Successfully installed gomboc-cad-0.1.5" in line for line in found["lines"])
    name, version, python = found["state"]
    assert (name, version) == ("Ready", "0.1.5")
    assert python == found["preference"] == found["kept"]
    assert Path(python).is_relative_to(found["folder"])
    assert Path(found["folder"]).is_relative_to(tmp_path / "home"), "nothing outside FreeCAD's own folder"
    assert "9.9.0" in found["wrong"]
    assert "stopped" in found["stopped"]
    assert found["ends"] == [None, found["wrong"]]
    assert found["last"] == "WrongVersion"
    assert "neither a wheel" in found["absent"]
    assert "/nowhere/python could not be started" in found["use"]
