"""All figures of a report, from its documents alone."""

from __future__ import annotations

import copy
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gomboc_cad.body import catalog
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.errors import InspectionError
from gomboc_cad.hydrostatics import righting_curve
from gomboc_cad.products.process import load_process
from gomboc_cad.report.build_records import study_records
from gomboc_cad.report.figure_list import report_figures
from gomboc_cad.report.style import figure_bytes
from gomboc_cad.tolerance.judging import COM_ERROR, ROW
from gomboc_cad.tolerance.product_study import body_study
from gomboc_cad.tolerance.requirement import Requirement
from gomboc_cad.tolerance.study import concluded

DATA = Path(__file__).parent / "data"
DEVIATIONS_UM = (60.0, 100.0, 30.0)


def stored(name: str) -> dict[str, Any]:
    return json.loads((DATA / name).read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def report() -> dict[str, Any]:
    """The records of a study, as `report.json` holds them; its rows are made up."""
    model = body_study(catalog()["primary"], load_process("cnc-5axis"), com_mm=(-0.411, 0.0, 0.0))
    rng, rows = np.random.default_rng(0), np.zeros(200, ROW)
    for name, deviation_um in zip(COM_ERROR, DEVIATIONS_UM, strict=True):
        rows[name] = rng.normal(scale=deviation_um, size=len(rows))
    rows["tilt_deg"] = rng.exponential(size=len(rows))
    result = concluded((), 0, Requirement(1.0), rows)
    return json.loads(json.dumps(study_records(model, result)))


@pytest.fixture(scope="module")
def documents() -> dict[str, Any]:
    """A housing, a study, and a buoy with its righting arms."""
    hydrostatics = stored("buoy/hydrostatics.json")
    directions, faces = geodesic_triangulation(3)
    corners = catalog()["primary"].with_diameter(300.0).position_mm(directions)
    mass_g, com, up = (hydrostatics[key] for key in ("mass_g", "com_mm", "upright"))
    curve = righting_curve(corners, faces, mass_g, com, up["up"], step_deg=30.0)
    interval = {"estimate": 0.8, "low": 0.7, "high": 0.9, "confidence": 0.95}
    tolerance = {
        "process": "cnc-5axis",
        "good_share": 0.95,
        "max_tilt_deg": 1.0,
        "tilt_deg": {"p95": 2.0},
        "sources": [{"name": "form_error", "text": "form error"}],
        "yield_monostable": interval,
        "yield_tilt": interval,
        "processes": [{"process": "sla", "yield_monostable": interval, "yield_tilt": interval}],
        "sobol": [{"source": "form_error", "first": interval, "total": interval}],
        "form_error": {
            "good_share": 0.95,
            "degrees": [
                {"degree": n, "guaranteed_um": 1.0 / n, "allowed_um": 2.0 / n, "process_um": 1.0}
                for n in (2, 4)
            ],
        },
    }
    return {
        "verdict": stored("housing/verdict.json"),
        "calibration": stored("housing/calibration.json"),
        "hydrostatics": {**hydrostatics, "righting": curve.document()},
        "tolerance": tolerance,
    }


def test_every_figure_is_drawn_and_has_its_own_name(
    report: dict[str, Any], documents: dict[str, Any]
) -> None:
    found = report_figures(report, **documents)
    assert [named.name for named in found] == [
        *("surface", "curvature", "drill", "landscape", "zone", "tilt"),
        *("tilts", "yields", "sobol", "form-error", "righting", "floating"),
    ]
    assert len({named.title for named in found}) == len(found)
    assert all(named.figure.axes for named in found)


def test_records_stay_small(report: dict[str, Any]) -> None:
    assert len(json.dumps(report)) < 1_500_000


@pytest.mark.parametrize(
    ("keys", "names"),
    [
        ((), []),
        (("verdict",), ["tilt"]),
        (("calibration",), []),
        (("tolerance",), ["yields", "sobol", "form-error"]),
        (("hydrostatics",), ["righting"]),
    ],
)
def test_what_has_no_data_is_left_out(
    documents: dict[str, Any], keys: tuple[str, ...], names: list[str]
) -> None:
    found = report_figures({}, **{key: documents[key] for key in keys})
    assert [named.name for named in found] == names


def test_a_study_without_answers_is_drawn(report: dict[str, Any], documents: dict[str, Any]) -> None:
    bare = {key: documents["tolerance"][key] for key in ("process", "yield_monostable", "yield_tilt")}
    found = [named.name for named in report_figures(report, tolerance=bare)]
    assert {"tilts", "yields", "tilt"} <= set(found)
    assert "sobol" not in found


@pytest.mark.parametrize("key", ["surface", "landscape", "zone_section", "tilt_histogram"])
@pytest.mark.parametrize("damage", [None, 7, [], {}, {"base64": 1}])
def test_a_damaged_record_is_told(key: str, damage: Any) -> None:
    with pytest.raises(InspectionError, match="damaged"):
        report_figures({key: damage})


@pytest.mark.parametrize(
    ("document", "key", "damage"),
    [
        ("tolerance", "sobol", [{"source": "x"}]),
        ("tolerance", "processes", [{"process": "x"}]),
        ("tolerance", "form_error", {"degrees": 3}),
        ("tolerance", "yield_tilt", {"estimate": "much"}),
        ("verdict", "rest", {"tilt_deg_per_um": [1.0]}),
        ("hydrostatics", "righting", {"axes": []}),
        ("hydrostatics", "upright", None),
    ],
)
def test_a_damaged_document_is_told(
    report: dict[str, Any], documents: dict[str, Any], document: str, key: str, damage: Any
) -> None:
    damaged = copy.deepcopy(documents)
    damaged[document][key] = damage
    if key == "yield_tilt":
        del damaged[document]["processes"]
    with pytest.raises(InspectionError, match="damaged"):
        report_figures({"surface": report["surface"]}, **damaged)


def test_the_same_documents_give_the_same_bytes(report: dict[str, Any]) -> None:
    kept = {key: report[key] for key in ("landscape", "zone_section", "tilt_histogram")}
    once, again = (report_figures(copy.deepcopy(kept)) for _ in range(2))
    assert len(once) == 3
    for first, second in zip(once, again, strict=True):
        for kind in ("svg", "png"):
            assert figure_bytes(first.figure, kind) == figure_bytes(second.figure, kind)


def test_drawing_loads_no_kernel_and_no_screen(report: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "report.json").write_text(json.dumps(report), encoding="utf-8")
    code = (
        "import json, sys\n"
        "from gomboc_cad.report.figure_list import report_figures\n"
        "assert len(report_figures(json.load(open('report.json')))) == 7\n"
        "unwanted = {'OCP', 'build123d', 'manifold3d', 'trimesh', 'matplotlib.pyplot'}\n"
        "print(sorted(unwanted & set(sys.modules)))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, encoding="utf-8", check=False
    )
    assert done.stdout.strip() == "[]", done.stderr


def test_the_spread_of_a_study_is_that_of_its_rows(report: dict[str, Any]) -> None:
    """In the plane of the section, about the nominal centre of mass."""
    section = report["zone_section"]
    found = np.sqrt(np.diag(section["com_covariance_mm2"]))
    expected = 1e-3 * np.sqrt(np.array(section["axes"]) ** 2 @ np.square(DEVIATIONS_UM))
    np.testing.assert_allclose(found, expected, rtol=0.15)
