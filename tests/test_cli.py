"""The command line for scripts: JSON keys, exit codes, one sentence for a mistake, whole files or none."""

from __future__ import annotations

import hashlib
import json
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import trimesh

from gomboc_cad import catalog
from gomboc_cad.cli import main
from gomboc_cad.equilibria import com_margin
from gomboc_cad.resources import template_folder
from tests.equilibria.polyhedra import hull_mesh, prism
from tests.solid import hostile

UNVERIFIED = (
    ('"primary"', '"second"'),
    ("= 100.0 ", "= 60.0 "),
    ('text = "A1" ', 'text = "" '),
    ("sag_um = 10.0", "sag_um = 400.0"),
)
"""What is changed in the housing's template for a body that is refuted, without a mark and coarse."""

Run = Callable[..., subprocess.CompletedProcess[str]]
Answer = Callable[..., dict[str, Any]]


def run_apart(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run the command line in a process of its own, which takes seconds to load."""
    command = [sys.executable, "-m", "gomboc_cad", *arguments]
    return subprocess.run(command, capture_output=True, encoding="utf-8", timeout=240, check=False, **options)


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Run:
    """Run the command line in this process, where the libraries are loaded already.

    What libraries in C write to the process's own stdout and stderr is captured too.
    """

    def call(*arguments: str) -> subprocess.CompletedProcess[str]:
        monkeypatch.setattr(sys, "argv", ["gomboc-cad", *arguments])
        monkeypatch.setattr(signal, "signal", lambda *_: None)
        with pytest.raises(SystemExit) as left:
            main()
        said = capfd.readouterr()
        return subprocess.CompletedProcess(list(arguments), int(left.value.code or 0), said.out, said.err)

    return call


@pytest.fixture
def json_of(run: Run) -> Answer:
    """Run with --json."""
    return lambda *arguments, code=0: the_json(run(*arguments, "--json", "--quiet"), code)


def the_json(done: subprocess.CompletedProcess[str], code: int = 0) -> dict[str, Any]:
    """Check that stdout is one JSON object and nothing else, and give it."""
    assert done.returncode == code, done.stderr
    assert done.stderr == ""
    document = json.loads(done.stdout)
    assert isinstance(document, dict)
    return document


def assert_one_sentence(done: subprocess.CompletedProcess[str], said: str) -> None:
    """Exit code 2, and one line on stderr that says it."""
    assert done.returncode == 2, done.stdout + done.stderr
    assert done.stdout == ""
    assert said in done.stderr
    assert done.stderr.startswith("gomboc-cad: ")
    assert done.stderr.count("\n") == 1
    assert "Traceback" not in done.stderr


def test_a_designed_body_is_a_body_for_the_other_commands(run: Run, json_of: Answer, tmp_path: Path) -> None:
    file = tmp_path / "new.toml"
    wanted = ["--family", "extended", "--min-curvature", "0.2", "--min-margin", "0.0005", "--steps", "1"]
    made = json_of("design", *wanted, "-o", str(file))
    assert (made["verdict"], made["status"]) == ("PASS", "proven")
    assert made["goal"] == {"objective": "s-margin", "min_curvature": 0.2, "min_margin": 0.0005}
    census = json_of("census", str(file))
    assert (census["body"], census["diameter_mm"]) == ("new.toml", 100.0)
    assert census["s_margin_mm"] == pytest.approx(50.0 * made["s_margin"])
    assert json_of("census", str(file), "--diameter-mm", "60")["s_margin_mm"] == pytest.approx(
        30.0 * made["s_margin"]
    )
    proven = json_of("certify", str(file))
    assert (proven["beta"], proven["coefficients"]) == (made["beta"], made["coefficients"])
    assert json_of("drillmap", str(file), "--sites", "20")["body"] == "new.toml"
    assert_one_sentence(run("design", *wanted, "-o", str(file)), "new.toml is there already")


def test_a_design_that_misses_a_constraint_is_written_and_fails(json_of: Answer, tmp_path: Path) -> None:
    file = tmp_path / "new.toml"
    wanted = ["--family", "harmonic", "--min-curvature", "0.1", "--min-margin", "0.02", "--steps", "1"]
    made = json_of("design", *wanted, "-o", str(file), code=1)
    assert made["verdict"] == "FAIL"
    assert made["reasons"][-1] == "The search ended with a body that misses the smallest margin."
    assert made["reasons"][-1] in file.read_text(encoding="utf-8").replace("\n# ", " ")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--family", "sloan2", "-o", "new.toml"], "no search in the family 'sloan2'"),
        (["--family", "harmonic", "-o", "new.json"], "new.json must end in .toml"),
        (["--family", "harmonic", "-o", "nowhere/new.toml"], "folder of nowhere/new.toml does not exist"),
        (["--family", "harmonic", "--objective", "u", "-o", "new.toml"], "no objective 'u'"),
        (["--family", "harmonic", "--min-curvature", "2", "-o", "new.toml"], "from 0.001 to 0.95"),
    ],
)
def test_a_wrong_design_is_refused_before_the_search(
    run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, arguments: list[str], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert_one_sentence(run("design", *arguments), said)
    assert list(tmp_path.iterdir()) == []


def test_a_spec_of_a_product_is_no_body(run: Run) -> None:
    spec = template_folder() / "imu-housing.toml"
    assert_one_sentence(run("census", str(spec)), "is the spec of a product, and a body is needed")


def test_the_catalogue_has_the_contracts_keys() -> None:
    """In a process of its own, whose stdout a script reads."""
    document = the_json(run_apart("catalog", "--json", "--quiet"))
    bodies = {body["name"]: body for body in document["bodies"]}
    assert {"primary", "sloan2-0.020", "sloan2-0.030", "sloan2-0.035", "second", "third"} <= set(bodies)
    keys = {"name", "family", "beta", "coefficients", "status", "reason", "s_margin"}
    assert all(keys <= set(body) for body in bodies.values())
    assert bodies["second"]["status"] == bodies["third"]["status"] == "refuted"
    assert bodies["second"]["s_margin"] is None
    assert bodies["primary"]["s_margin"] == pytest.approx(0.00339, rel=0.01)


def test_the_census_has_the_contracts_keys_and_the_reference_values(json_of: Answer) -> None:
    """Reference values of the primary with R₀ = 50 mm: volume and COM to 1e-9, margins to 1 %."""
    census = json_of("census", "primary")
    assert (census["stable"], census["saddles"], census["unstable"]) == (1, 0, 1)
    assert census["strictly_convex"] is True
    assert census["volume_mm3"] == pytest.approx(523458.313905, rel=1e-9)
    assert census["com_mm"] == pytest.approx([-0.134778477, 0.0, 0.0], abs=1e-9)
    assert census["margin_mm"] == pytest.approx(0.00330 * 50, rel=0.01)
    assert census["s_margin_mm"] == pytest.approx(0.00339 * 50, rel=0.01)
    assert census["height_range_mm"] == pytest.approx(0.0518 * 50, rel=0.01)
    assert census["min_curvature_per_mm"] == pytest.approx(0.0885 / 50, rel=0.01)
    assert {"direction", "stiffness_mm", "tilt_deg_per_um"} <= set(census["rest"])
    assert {"kind", "direction", "height_mm"} <= set(census["equilibria"][0])
    assert census["u_margin_mm"] > 0.0


def test_a_family_gives_the_same_census_as_its_name(json_of: Answer) -> None:
    named = json_of("census", "primary", "--diameter-mm", "60")
    family = json_of(
        "census", "--family", "extended", "--beta", "0.023149", "--coef", "1=0.234433", "--diameter-mm", "60"
    )
    assert family["body"] == "extended(beta=0.023149, 1=0.234433)"
    for key in ("volume_mm3", "com_mm", "margin_mm", "equilibria"):
        assert family[key] == named[key]


def test_a_harmonic_body_is_described_by_its_terms(json_of: Answer) -> None:
    census = json_of("census", "--family", "harmonic", "--coef", "2,0=0.01", "--coef", "2,2=0.02", code=1)
    assert census["verdict"] == "multistable"
    assert (census["stable"], census["saddles"], census["unstable"]) == (2, 2, 2)


def test_a_centre_of_mass_outside_the_zone_is_a_fail(json_of: Answer) -> None:
    census = json_of("census", "primary", "--com-mm", "0.5,0,0", code=1)
    assert census["stable"] > 1
    assert census["com_mm"] == [0.5, 0.0, 0.0]
    assert json_of("census", "primary", "--com-mm", "-1,0,0")["stable"] == 1


def test_a_dented_body_is_censused_on_its_hull(json_of: Answer) -> None:
    census = json_of("census", "second", code=1)
    assert census["strictly_convex"] is False
    assert (census["stable"], census["verdict"]) == (2, "multistable")
    assert census["stable"] - census["saddles"] + census["unstable"] == 2
    assert census["raw"]["stable"] > 1000
    assert all(
        pose["barrier_um"] > census["barrier_um"] for pose in census["equilibria"] if pose["kind"] == "stable"
    )
    assert census["margin_mm"] is None
    assert "Not strictly convex" in census["reason"]


def test_a_part_of_any_format_is_checked_with_the_contracts_keys(json_of: Answer, tmp_path: Path) -> None:
    writers = {
        "stl": hostile.binary_stl,
        "obj": hostile.obj,
        "ply": hostile.binary_ply,
        "3mf": hostile.three_mf,
    }
    for kind, writer in writers.items():
        path = hostile.write(tmp_path, f"box.{kind}", writer(hostile.box()))
        found = json_of("check", str(path), code=1)
        assert found["watertight"] is True
        assert found["volume_mm3"] == pytest.approx(6000.0)
        assert found["com_mm"] == pytest.approx([5.0, 10.0, 15.0])
        assert found["facets"] == 12
        assert found["raw"] == {"stable": 6, "unstable": 8, "saddles": 12}
        assert (found["stable"], found["verdict"]) == (6, "multistable")
        assert found["barrier_um"] > 0.0
        assert {"direction", "height_mm", "barrier_um", "probability"} <= set(found["poses"][0])
        assert sum(pose["probability"] for pose in found["poses"]) == pytest.approx(1.0)


def test_check_takes_a_unit_a_com_and_a_barrier(json_of: Answer, tmp_path: Path) -> None:
    path = hostile.write(tmp_path, "box.stl", hostile.binary_stl(hostile.box()))
    inches = json_of("check", str(path), "--unit", "in", code=1)
    assert inches["volume_mm3"] == pytest.approx(6000.0 * 25.4**3)
    low = json_of("check", str(path), "--com-mm", "5,10,1", code=1)
    assert low["poses"][0]["height_mm"] == pytest.approx(1.0)
    assert json_of("check", str(path), "--com-mm", "5,10,1", "--barrier-um", "600")["stable"] == 1
    ring = hostile.binary_stl(hostile.Mesh(*hull_mesh(prism(40, 100.0, radius=20.0))))
    path = hostile.write(tmp_path, "rod.stl", ring)
    assert json_of("check", str(path), code=1)["poses"][0]["extent"] == "ring"
    assert json_of("check", str(path), "--faceted", code=1)["stable"] == 42


def test_a_part_that_cannot_be_judged_is_one_sentence(run: Run, json_of: Answer, tmp_path: Path) -> None:
    box = hostile.box()
    open_box = hostile.Mesh(box.vertices_mm, box.faces[:-1])
    path = hostile.write(tmp_path, "open.stl", hostile.binary_stl(open_box))
    assert_one_sentence(run("check", str(path)), "--com-mm")
    assert json_of("check", str(path), "--com-mm", "5,10,15", code=1)["watertight"] is False
    assert_one_sentence(run("check", str(tmp_path / "none.stl")), "none.stl")
    assert_one_sentence(run("check", str(path), "--com-mm", "500,0,0"), "outside")


def test_the_zone_is_written_as_a_closed_mesh_with_a_figure(json_of: Answer, tmp_path: Path) -> None:
    """About a COM far below the centroid, where the cells need not be small; validation has the other."""
    path, com = tmp_path / "zone.stl", (-15.0, 0.0, 0.0)
    zone = json_of("zone", "primary", "--com-mm", "-15,0,0", "-o", str(path))
    margin = com_margin(catalog()["primary"], com).s_margin_mm
    assert zone["com_mm"] == list(com)
    assert zone["s_margin_mm"] == zone["equivalent_ballast_mm"] == pytest.approx(margin, rel=1e-9)
    assert zone["best_s_margin_mm"] >= zone["nearest_best_s_margin_mm"] > margin
    assert len(zone["best_com_mm"]) == 3
    mesh = trimesh.load_mesh(path)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(zone["zone_volume_mm3"], rel=1e-4)
    assert (tmp_path / "zone.png").read_bytes().startswith(b"\x89PNG")


def test_a_com_outside_the_zone_has_none_to_show(run: Run, json_of: Answer) -> None:
    assert_one_sentence(run("zone", "primary", "--com-mm", "0.5,0,0"), "rest")
    # Where none is given it is the centroid, as it is for the census.
    oblong = ("--family", "harmonic", "--coef", "2,0=0.01", "--coef", "2,2=0.02")
    x, y, z = json_of("census", *oblong, code=1)["com_mm"]
    about = f"2 stable rests about the centre of mass ({x:g}, {y:g}, {z:g}) mm"
    assert_one_sentence(run("zone", *oblong), about)


def test_the_drill_map_is_written_as_a_table_with_a_figure(run: Run, json_of: Answer, tmp_path: Path) -> None:
    path = tmp_path / "drill.csv"
    found = json_of("drillmap", "primary", "-o", str(path), "--sites", "100")
    assert len(found["sites"]) == 100
    assert {"direction", "radius_mm"} <= set(found["sites"][0])
    assert found["max_radius_mm"] == pytest.approx(0.13 * 50.0, rel=0.05)
    assert all(site["radius_mm"] <= found["max_radius_mm"] for site in found["sites"])
    lines = path.read_text(encoding="utf-8").splitlines()
    assert len(lines) == 1 + len(found["best"]) + 100
    assert (tmp_path / "drill.png").read_bytes().startswith(b"\x89PNG")
    assert_one_sentence(run("drillmap", "primary", "-o", str(path)), "--force")
    assert_one_sentence(run("drillmap", "primary", "-o", str(tmp_path / "map.txt")), ".csv")


def test_a_table_of_the_paper_has_the_contracts_keys(run: Run, json_of: Answer, tmp_path: Path) -> None:
    document = json_of("paper", "-o", str(tmp_path / "out"), "--only", "thresholds")
    assert [made["name"] for made in document["tables"]] == ["thresholds"]
    keys = {"label", "paper", "reproduced", "truth", "verdict", "why"}
    assert all(keys <= set(row) for row in document["tables"][0]["rows"])
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"paper.json", "paper.md"}
    done = run("paper", "-o", str(tmp_path / "other"), "--only", "threshold")
    assert_one_sentence(done, "thresholds")


def test_a_certificate_is_written_and_checked(run: Run, json_of: Answer, tmp_path: Path) -> None:
    path = tmp_path / "primary.json"
    made = json_of("certify", "primary", "-o", str(path))
    assert (made["status"], made["strictly_convex"], made["stable"], made["unstable"]) == (
        "proven",
        True,
        1,
        1,
    )
    assert float(made["com_enclosure"][0][0]) == pytest.approx(-0.0026955695)
    assert made["seconds"] > 0.0
    checked = json_of("certify", "--verify", str(path))
    assert (checked["status"], checked["accepted"], checked["stable"]) == ("proven", True, 1)
    assert json_of("certify", "third", code=1)["status"] == "refuted"
    assert_one_sentence(run("certify", "primary", "-o", str(path)), "--force")
    assert_one_sentence(run("certify", "primary", "--verify", str(path)), "nothing else")
    assert_one_sentence(run("certify", "--family", "sloan1", "--beta", "0.01"), "sloan2 and extended")


def test_a_certificate_that_was_changed_is_rejected(run: Run, json_of: Answer, tmp_path: Path) -> None:
    path = tmp_path / "body.json"
    json_of("certify", "--family", "sloan2", "--beta", "0.03", "-o", str(path))
    document = json.loads(path.read_text(encoding="utf-8"))
    document["beta"] = "0.05"
    path.write_text(json.dumps(document), encoding="utf-8")
    assert_one_sentence(run("certify", "--verify", str(path)), "digest")
    del document["sha256"]
    canonical = json.dumps(document, sort_keys=True, separators=(",", ":"))
    document["sha256"] = hashlib.sha256(canonical.encode()).hexdigest()
    path.write_text(json.dumps(document), encoding="utf-8")
    rejected = json_of("certify", "--verify", str(path), code=1)
    assert (rejected["accepted"], rejected["status"], rejected["stable"]) == (False, "undecided", None)


def test_what_a_user_has_is_not_overwritten(run: Run, json_of: Answer, tmp_path: Path) -> None:
    kept = tmp_path / "mine"
    kept.mkdir()
    (kept / "notes.txt").write_text("mine", encoding="utf-8")
    assert_one_sentence(run("build", "imu-housing", "-o", str(kept), "-q"), "--force")
    assert_one_sentence(run("body", "primary", "-o", str(kept), "-q"), "--force")
    assert [path.name for path in kept.iterdir()] == ["notes.txt"]
    json_of("body", "primary", "-o", str(kept), "--force", "--formats", "stl", "--sag-um", "200")
    assert sorted(path.name for path in kept.iterdir()) == ["notes.txt", "primary.stl"]
    assert (kept / "notes.txt").read_text(encoding="utf-8") == "mine"


def test_the_bare_body_has_the_contracts_keys(json_of: Answer, tmp_path: Path) -> None:
    folder = tmp_path / "deep" / "body"
    document = json_of("body", "primary", "-o", str(folder), "--sag-um", "200")
    assert document["verdict"] == "PASS"
    assert document["max_deviation_um"] <= 0.1
    assert document["volume_mm3"] == pytest.approx(523458.313905, rel=1e-6)
    assert document["com_mm"] == pytest.approx([-0.134778477, 0.0, 0.0], abs=1e-4)
    assert sorted(path.name for path in folder.iterdir()) == ["primary.3mf", "primary.step", "primary.stl"]
    assert (folder / "primary.step").stat().st_size < 1_000_000


def test_a_refuted_body_is_written_with_the_verdict_fail(json_of: Answer, tmp_path: Path) -> None:
    document = json_of(
        "body", "second", "-o", str(tmp_path / "out"), "--formats", "stl", "--sag-um", "100", code=1
    )
    assert document["verdict"] == "FAIL"
    assert "Gaussian curvature" in document["reasons"][0]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["census"], "Give either the name of a body"),
        (["census", "primary", "--family", "sloan2"], "Give either the name of a body"),
        (["census", "primry"], "did you mean primary"),
        (["census", "primary", "--beta", "0.02"], "go with --family"),
        (["census", "--family", "sloan2"], "needs beta"),
        (["census", "--family", "sloan2", "--beta", "nan"], "beta = nan"),
        (["census", "--family", "sloan2", "--beta", "0.3"], "outside 0 ≤ beta < 0.25"),
        (["census", "--family", "sloan2", "--beta", "x"], "valid number"),
        (["census", "--family", "extended", "--beta", "0.02", "--coef", "1"], "--coef needs K=A"),
        (["census", "--family", "extended", "--beta", "0.02", "--coef", "a=1"], "must be an integer k"),
        (["census", "--family", "sloan2", "--beta", "0"], "move the centre of mass"),
        (["census", "primary", "--com-mm", "1,2"], "three numbers"),
        (["census", "primary", "--com-mm", "nan,0,0"], "three finite numbers"),
        (["census", "primary", "--com-mm", "99,0,0"], "outside the body"),
        (["census", "primary", "--diameter-mm", "0"], "--diameter-mm 0 is not allowed"),
        (["census", "primary", "--diameter-mm", "nan"], "--diameter-mm nan is not allowed"),
        (["census", "primary", "--diameter-mm", "1e300"], "is not allowed"),
        (["build", "teapot", "-o", "out"], "no product 'teapot'"),
        (["build", "absent.toml", "-o", "out"], "There is no file absent.toml"),
        (["build", "imu-housing"], "Missing option"),
        (["body", "primary", "-o", "out", "--formats", "iges"], "choose any of step, stl, 3mf"),
        (["body", "primary", "-o", "out", "--sag-um", "-1"], "sag"),
        (["body", "primary", "-o", "out", "--sag-um", "nan"], "sag"),
        (["body", "primary", "-o", "out", "--sag-um", "1e-6"], "sag"),
        (["body", "primary", "-o", "/proc/nowhere/out", "--sag-um", "500"], "/proc/nowhere/out"),
        (["frobnicate"], "No such command"),
        (["catalog", "--frobnicate"], "No such option"),
    ],
)
def test_a_mistake_is_one_sentence_with_exit_code_2(
    run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, arguments: list[str], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert_one_sentence(run(*arguments), said)
    assert list(tmp_path.iterdir()) == []


def test_mistakes_in_a_spec_are_one_sentence_and_write_nothing(run: Run, tmp_path: Path) -> None:
    spec = tmp_path / "spec.toml"
    text = (template_folder() / "imu-housing.toml").read_text(encoding="utf-8")
    spec.write_text(text.replace("wall_mm = 3.0 ", "wall_mm = -3.0 "), encoding="utf-8")
    assert_one_sentence(run("build", str(spec), "-o", str(tmp_path / "out"), "-q"), "shell.wall_mm = -3.0")
    spec.write_text(text.replace("wall_mm = 3.0 ", "wall_mm = 30.0 "), encoding="utf-8")
    assert_one_sentence(run("build", str(spec), "-o", str(tmp_path / "out"), "-q"), "smallest inner radius")
    assert [path.name for path in tmp_path.iterdir()] == ["spec.toml"]


def test_a_refuted_body_is_refused_for_a_product(run: Run, tmp_path: Path) -> None:
    spec = tmp_path / "spec.toml"
    text = (template_folder() / "imu-housing.toml").read_text(encoding="utf-8")
    spec.write_text(text.replace('name = "primary"', 'name = "third"'), encoding="utf-8")
    assert_one_sentence(run("build", str(spec), "-o", str(tmp_path / "out"), "-q"), "--allow-unverified")


@pytest.mark.slow
def test_an_unverified_body_is_built_on_demand_and_fails(json_of: Answer, tmp_path: Path) -> None:
    spec = tmp_path / "spec.toml"
    text = (template_folder() / "imu-housing.toml").read_text(encoding="utf-8")
    for old, new in UNVERIFIED:
        assert text.count(old) == 1
        text = text.replace(old, new)
    spec.write_text(text, encoding="utf-8")
    document = json_of(
        "build", str(spec), "-o", str(tmp_path / "out"), "--allow-unverified", "--no-report", code=1
    )
    assert document["verdict"] == "FAIL"
    assert document["s_margin_mm"] is None
    assert any("not strictly convex" in reason for reason in document["reasons"])


@pytest.mark.slow
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_leaves_nothing_behind(tmp_path: Path, sent: signal.Signals) -> None:
    child = subprocess.Popen(
        [sys.executable, "-m", "gomboc_cad", "build", "imu-housing", "-o", str(tmp_path / "out"), "-q"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8",
    )  # fmt: skip
    deadline = time.monotonic() + 120
    # The output folder is staged beside its place, so its appearance shows that the work is under way.
    while not list(tmp_path.iterdir()) and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(1.0)
    child.send_signal(sent)
    output, errors = child.communicate(timeout=120)
    assert child.returncode == 130, errors
    assert output == ""
    assert "interrupted" in errors
    assert "Traceback" not in errors
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_disk_that_takes_no_more_leaves_nothing_behind(tmp_path: Path) -> None:
    """The limit on file sizes is a real refusal of the operating system in the midst of writing."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))

    done = run_apart("body", "primary", "-o", str(tmp_path / "out"), "-q", preexec_fn=limit)
    assert_one_sentence(done, "could not be written")
    assert list(tmp_path.iterdir()) == []


def test_the_terminal_shows_a_table_and_progress_goes_to_stderr(run: Run, tmp_path: Path) -> None:
    shown = run_apart("census", "primary", env=os.environ | {"COLUMNS": "120"})
    assert shown.returncode == 0
    assert "mono-monostatic" in shown.stdout
    assert "S, U" in shown.stdout
    assert run("census", "primary", "-q").stdout == ""
    loud = run_apart(
        "body", "primary", "-o", str(tmp_path / "out"), "--formats", "stl", "--sag-um", "500", "--json"
    )
    assert json.loads(loud.stdout)["verdict"] == "PASS"


def test_markup_in_a_name_stays_text(run: Run, tmp_path: Path) -> None:
    done = run("census", "[red]nobody[/red]")
    assert_one_sentence(done, "[red]nobody[/red]")


def test_help_and_version(run: Run) -> None:
    assert "census" in run("--help").stdout
    assert run_apart("--version").stdout.startswith("gomboc-cad 0.")


def test_an_audit_without_its_program_is_refused_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """None in sys.modules is how Python says that a module cannot be imported."""
    monkeypatch.setitem(sys.modules, "pymeshlab", None)
    monkeypatch.setattr(
        sys, "argv", ["gomboc-cad", "build", "imu-housing", "-o", str(tmp_path / "out"), "--audit"]
    )
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    assert "gomboc-cad[audit]" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_an_audit_finds_nothing(json_of: Answer, tmp_path: Path, pymeshlab: ModuleType) -> None:
    document = json_of("body", "primary", "-o", str(tmp_path / "out"), "--sag-um", "200", "--audit")
    assert all(file["ok"] for file in document["files"])
