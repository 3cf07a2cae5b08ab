"""The seed pod and the buoy as a user builds them, opened by programs that share nothing with us."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from gomboc_cad.products.build import build_product
from tests.acceptance.test_housing import READ_STEP
from tests.external import PrusaSlicer, digests
from tests.report.walker import untraced

pytestmark = pytest.mark.slow

COARSER = {
    "seed-pod": ("plate.copies=3", "mesh.sag_um=50.0"),
    "buoy": ("mesh.sag_um=400.0",),
}
"""What is changed in the templates: fewer pods on the plate, meshes that are quicker to look at."""


SMALL_HOUSING = """
product = "imu-housing"
[body]
name = "primary"
diameter_mm = 60.0
[board]
type = "{board}"
{more}
[com]
target = "centroid"
[mark]
text = ""
[mesh]
sag_um = 200.0
"""
"""Without what takes time and has nothing to do with the question: the search for the best place, a mark."""


@dataclass(frozen=True)
class Built:
    """A product on disk."""

    name: str
    folder: Path
    document: dict[str, Any]


@pytest.fixture(scope="module", params=["seed-pod", "buoy"])
def built(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Built:
    folder = tmp_path_factory.mktemp(request.param) / "out"
    # The page of the buoy has all that another one has, and how it floats besides.
    document = build_product(
        request.param, folder, changes=COARSER[request.param], report=request.param == "buoy"
    )
    return Built(request.param, folder, document)


def test_it_passes_with_every_file_in_order(built: Built) -> None:
    document = built.document
    assert document["verdict"] == "PASS", document["reasons"]
    assert document["hull"]["verdict"] == "monostable"
    assert document["assembly"]["com_residual_um"] <= 1.0
    assert all(file["ok"] for file in document["files"])
    there = {path.name for path in built.folder.iterdir()}
    report = {"report.json", "report.html", "figures"} if built.name == "buoy" else set()
    assert {file["path"] for file in document["files"]} | {"verdict.json"} | report == there
    made = [part["name"] for part in document["parts"] if part["made"]]
    assert {f"{name}.{kind}" for name in made for kind in ("step", "stl", "3mf")} <= there
    on_disk = json.loads((built.folder / "verdict.json").read_text(encoding="utf-8"))
    assert on_disk == {key: value for key, value in document.items() if key != "folder"}


def test_every_number_of_the_page_stands_in_its_files(built: Built) -> None:
    if built.name != "buoy":
        assert not (built.folder / "report.html").exists()
        return
    assert untraced(built.folder) == []


def test_the_bill_of_materials_weighs_as_much_as_the_assembly(built: Built) -> None:
    with (built.folder / "bill-of-materials.csv").open(encoding="utf-8", newline="") as stream:
        lines = list(csv.DictReader(stream))
    assert {"part", "material", "quantity", "standard", "mass_g"} <= set(lines[0])
    total = sum(float(line["mass_g"]) for line in lines)
    assert total == pytest.approx(built.document["assembly"]["mass_g"], abs=1e-3 * len(lines))
    assert sum(int(line["quantity"]) for line in lines) == len(built.document["parts"])


def test_freecad_opens_the_assembly(built: Built, run_in_freecad: Callable[..., dict[str, Any]]) -> None:
    found = run_in_freecad(READ_STEP, path=str(built.folder / f"{built.name}.step"))
    volumes = sorted(part["volume_mm3"] for part in built.document["parts"])
    assert found["valid"]
    assert sorted(found["volumes"]) == pytest.approx(volumes, rel=50e-6)


def test_prusa_slicer_finds_the_made_parts_and_the_plate_manifold(
    built: Built, prusa_slicer: PrusaSlicer
) -> None:
    made = [part["name"] for part in built.document["parts"] if part["made"]]
    for file in (*(f"{name}.stl" for name in made), f"{built.name}-plate.3mf"):
        info = prusa_slicer.info(built.folder / file)
        assert info["manifold"] is True, file
        assert "open_edges" not in info


def test_the_two_verdicts_of_a_buoy_stand_side_by_side(built: Built) -> None:
    if built.name != "buoy":
        assert "floating" not in built.document
        assert not (built.folder / "hydrostatics.json").exists()
        return
    afloat = json.loads((built.folder / "hydrostatics.json").read_text(encoding="utf-8"))
    displaced_g = afloat["upright"]["displaced_volume_mm3"] * 1e-3 * afloat["water"]["density_g_cm3"]
    assert displaced_g == pytest.approx(built.document["assembly"]["mass_g"], rel=1e-6)
    assert built.document["floating"]["stable"] == afloat["floating"]["stable"] == 1


@pytest.fixture(scope="module")
def forced(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """A small housing with its cable port at the top, the unstable point."""
    folder = tmp_path_factory.mktemp("forced")
    port = '[cable]\nthread = "M6x1"\ndirection = [1.0, 0.0, 0.1]'
    spec = folder / "mine.toml"
    spec.write_text(SMALL_HOUSING.format(board="adafruit-bno055", more=port), encoding="utf-8")
    return Built("imu-housing", folder / "out", build_product(str(spec), folder / "out", report=False))


def test_a_forced_port_fails_on_the_real_hull(forced: Built) -> None:
    """There any open hole is a second rest; the verdict names it."""
    document = forced.document
    assert document["verdict"] == "FAIL"
    assert document["hull"]["verdict"] == "multistable"
    assert document["hull"]["stable"] == 2
    assert document["stable"] == 1
    assert any("also rests on the rim of" in reason and "cable" in reason for reason in document["reasons"])


def test_another_board_after_it_gives_the_same_bytes_as_from_scratch(forced: Built, tmp_path: Path) -> None:
    """What one build keeps for the next is never used wrongly."""
    spec = tmp_path / "mine.toml"
    spec.write_text(SMALL_HOUSING.format(board="adafruit-mpu6050", more=""), encoding="utf-8")
    build_product(str(spec), tmp_path / "after", report=False)
    command = [sys.executable, "-m", "gomboc_cad", "build", str(spec), "--no-report", "-q"]
    subprocess.run([*command, "-o", str(tmp_path / "alone")], check=True, timeout=300)
    alone = digests(tmp_path / "alone")
    assert alone == digests(tmp_path / "after")
    assert alone["imu-housing.step"] != digests(forced.folder)["imu-housing.step"]
