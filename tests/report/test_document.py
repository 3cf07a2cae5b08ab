"""The JSON twin: bodies that can be had again, build and study in one folder, no kernel for the report."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gomboc_cad.body import catalog
from gomboc_cad.body.sphere import fibonacci_directions
from gomboc_cad.errors import InspectionError, OutputError, StudyError
from gomboc_cad.report.document import body_document, body_of, cone_95_deg, merged
from gomboc_cad.report.folder import REPORT, Results, read_results
from gomboc_cad.tolerance.whole_study import Question, study_tolerances
from tests.report.conftest import DATA, MakeResults, copied, write_page

COM_MM = np.array([0.1, -0.2, 0.3])


@pytest.mark.parametrize("name", sorted(catalog()))
def test_a_body_comes_back_from_its_document(name: str) -> None:
    body = catalog()[name].with_diameter(73.0)
    document = json.loads(json.dumps(body_document(body, COM_MM)))
    found = body_of(Results({REPORT: {"body": document}}, {}))
    assert found is not None
    again, com_mm = found
    directions = fibonacci_directions(200)
    assert np.array_equal(again.position_mm(directions), body.position_mm(directions))
    assert np.array_equal(com_mm, COM_MM)


@pytest.mark.parametrize("diameter", [0.0, 1e9, "100"])
def test_a_body_that_cannot_be_is_refused(diameter: object) -> None:
    document = {**body_document(catalog()["primary"], COM_MM), "diameter_mm": diameter}
    with pytest.raises(InspectionError, match=r"report\.json: body\.diameter_mm"):
        body_of(Results({REPORT: {"body": document}}, {}))


def test_what_another_run_put_in_stays_if_it_is_of_the_same_design() -> None:
    before = {"body": {"name": "a"}, "zone": 1, "surface": 2}
    assert merged(before, {"body": {"name": "a"}, "surface": 3}) == merged({}, before) | {"surface": 3}
    assert "zone" not in merged(before, {"body": {"name": "b"}})


def test_the_cone_of_the_study_is_taken_before_that_of_the_calibration(tmp_path: Path) -> None:
    spec_only = read_results(copied(tmp_path / "one", "housing"))
    assert cone_95_deg(spec_only).address == "calibration.json#/cone_95_deg"
    both = read_results(copied(tmp_path / "two", "housing", "study"))
    assert cone_95_deg(both).address == "tolerance.json#/tilt_deg/p95"


def test_a_document_of_another_product_left_there_is_not_shown(tmp_path: Path) -> None:
    folder = copied(tmp_path / "out", "housing")
    shutil.copy(DATA / "buoy" / "hydrostatics.json", folder)
    assert not read_results(folder).value("hydrostatics.json")


def test_what_is_damaged_beside_a_new_build_does_not_stop_it(tmp_path: Path) -> None:
    new, old = copied(tmp_path / "new", "housing"), tmp_path / "old"
    old.mkdir()
    (old / "tolerance.json").write_text("{", encoding="utf-8")
    assert not read_results(new, old).value("tolerance.json")
    shutil.copy(DATA / "study" / "tolerance.json", old)
    assert read_results(new, old).value("tolerance.json")


WITHOUT_KERNEL = """
import sys
from gomboc_cad.cli import main
try:
    main()
finally:
    assert not {"OCP", "build123d", "manifold3d"} & set(sys.modules)
"""


def test_the_command_gives_its_files_without_a_kernel_or_one_sentence(tmp_path: Path) -> None:
    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", WITHOUT_KERNEL, "report", *arguments]
        return subprocess.run(command, capture_output=True, encoding="utf-8", timeout=120, check=False)

    folder = copied(tmp_path / "out", "study")
    done = run(str(folder), "--json")
    assert done.returncode == 0, done.stderr
    files = json.loads(done.stdout)["files"]
    assert {"report.html", "report.json", "figures/yields.svg", "figures/yields.png"} <= set(files)
    assert all((folder / file).stat().st_size > 0 for file in files)
    wrong = run(str(tmp_path / "nowhere"), "-q")
    assert wrong.returncode == 2
    assert wrong.stderr.startswith("gomboc-cad: There is no folder")
    assert wrong.stderr.count("\n") == 1


SMALLEST = Question(process="cnc-5axis", variants=1, samples=2, rebuilt=0, answers=False)


def test_a_study_goes_into_the_folder_of_its_own_build_only(changed: MakeResults) -> None:
    """Of the bare primary, about its centroid."""
    centroid = [-0.13477847732458295, 0.0, 0.0]
    folder = changed("verdict.json", lambda verdict: verdict["assembly"].update(com_mm=centroid), "housing")
    study_tolerances("primary", folder, SMALLEST, executor="local:1", report=False)
    write_page(folder)
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "5-axis milling" in page
    assert "of another design" not in page
    other = changed(
        "verdict.json", lambda verdict: verdict["assembly"].update(com_mm=[1.0, 0.0, 0.0]), "housing"
    )
    (other / "tolerance.json").unlink(missing_ok=True)
    with pytest.raises(StudyError, match="holds the build of another design"):
        study_tolerances("primary", other, SMALLEST, executor="local:1", report=False)


def test_a_study_does_not_go_among_other_files(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("x", encoding="utf-8")
    with pytest.raises(OutputError, match="is not empty"):
        study_tolerances("primary", tmp_path, SMALLEST, executor="local:1", report=False)
