"""The default housing from the command line, its files opened by programs that share nothing with us."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from gomboc_cad.solid.inspect import Expected, inspect_file
from tests.external import PrusaSlicer

SAG_UM = 40.0
HALVES = ("imu-housing-lower", "imu-housing-upper")

READ_STEP = """
import Part

shape = Part.Shape()
shape.read(inputs["path"])
report(valid=shape.isValid(), volumes=[solid.Volume for solid in shape.Solids])
"""

OPEN_STEP = """
import FreeCAD, Import

document = FreeCAD.newDocument("housing")
Import.insert(inputs["path"], document.Name)
found = {}
for item in document.Objects:
    shape = getattr(item, "Shape", None)
    if item.TypeId == "Part::Feature" and shape is not None:
        found[item.Label] = {"valid": shape.isValid(), "solids": len(shape.Solids), "volume": shape.Volume}
report(parts=found)
"""


@dataclass(frozen=True)
class BuiltHousing:
    """The housing of the template on disk, its meshes coarser."""

    folder: Path
    document: dict[str, Any]


@pytest.fixture(scope="module")
def built_housing(tmp_path_factory: pytest.TempPathFactory) -> BuiltHousing:
    """The default housing, built by the command line as a user builds it.

    Its meshes are coarser, which changes nothing but the time that everything after it takes; the report is
    tested where it is made.
    """
    folder = tmp_path_factory.mktemp("housing") / "out"
    command = [sys.executable, "-m", "gomboc_cad", "build", "imu-housing", "-o", str(folder), "--json", "-q"]
    command += ["--set", f"mesh.sag_um={SAG_UM}", "--no-report"]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=300, check=False)
    assert done.returncode == 0, done.stderr + done.stdout
    assert done.stderr == ""
    return BuiltHousing(folder, json.loads(done.stdout))


def test_the_build_has_the_contracts_keys(built_housing: BuiltHousing) -> None:
    document = built_housing.document
    assert document["verdict"] == "PASS"
    assert all(file["ok"] for file in document["files"]), document["reasons"]
    assert {"name", "material", "mass_g", "volume_mm3", "watertight"} <= set(document["parts"][0])
    assert all(part["watertight"] for part in document["parts"])
    assembly = document["assembly"]
    assert assembly["com_residual_um"] <= 1.0
    assert assembly["mass_g"] == pytest.approx(sum(part["mass_g"] for part in document["parts"]))
    assert assembly["com_mm"] == pytest.approx(assembly["com_target_mm"], abs=1e-4)
    assert document["s_margin_mm"] == pytest.approx(0.3821, rel=0.01)
    assert document["reasons"]
    assert document["rest"]["tilt_deg_per_um"][0] == pytest.approx(0.129, rel=0.01)


def test_the_files_are_there_and_the_verdict_is_on_disk(built_housing: BuiltHousing) -> None:
    folder, document = built_housing.folder, built_housing.document
    on_disk = {path.name for path in folder.iterdir()}
    assert on_disk == {file["path"] for file in document["files"]} | {"verdict.json"}
    assert {"imu-housing.step", "imu-housing.3mf"} <= on_disk
    for half in ("lower", "upper"):
        assert {f"imu-housing-{half}.step", f"imu-housing-{half}.stl"} <= on_disk
    verdict = json.loads((folder / "verdict.json").read_text(encoding="utf-8"))
    assert verdict == {key: value for key, value in document.items() if key != "folder"}
    for file in document["files"]:
        assert (folder / file["path"]).stat().st_size == file["size_bytes"]


def test_freecad_opens_the_assembly(
    built_housing: BuiltHousing, run_in_freecad: Callable[..., dict[str, Any]]
) -> None:
    """Every part is one valid solid with a volume within 50 ppm of the model.

    Without a screen the Import module of FreeCAD 0.20 crashes on an assembly of any origin, two plain boxes
    included, so the assembly is read as a shape here.
    """
    found = run_in_freecad(READ_STEP, path=str(built_housing.folder / "imu-housing.step"))
    parts = built_housing.document["parts"]
    assert found["valid"]
    assert len(found["volumes"]) == len(parts)
    assert sorted(found["volumes"]) == pytest.approx(sorted(part["volume_mm3"] for part in parts), rel=50e-6)


@pytest.mark.parametrize("name", HALVES)
def test_freecad_opens_each_half(
    built_housing: BuiltHousing, run_in_freecad: Callable[..., dict[str, Any]], name: str
) -> None:
    found = run_in_freecad(OPEN_STEP, path=str(built_housing.folder / f"{name}.step"))["parts"]
    model = next(part for part in built_housing.document["parts"] if part["name"] == name)
    assert len(found) == 1
    half = found[name]
    assert half["valid"]
    assert half["solids"] == 1
    assert half["volume"] == pytest.approx(model["volume_mm3"], rel=50e-6)


@pytest.mark.parametrize("file", [f"{HALVES[0]}.stl", f"{HALVES[1]}.stl", "imu-housing.3mf"])
def test_prusa_slicer_finds_every_mesh_manifold(
    built_housing: BuiltHousing, prusa_slicer: PrusaSlicer, file: str
) -> None:
    info = prusa_slicer.info(built_housing.folder / file)
    assert info["manifold"] is True
    assert "open_edges" not in info
    assert "facets_reversed" not in info


@pytest.mark.slow
def test_prusa_slicer_slices_the_lower_half(
    built_housing: BuiltHousing, prusa_slicer: PrusaSlicer, tmp_path: Path
) -> None:
    """Turned so that the seam lies on the bed, as the user guide says, the half slices."""
    mesh = trimesh.load(built_housing.folder / f"{HALVES[0]}.stl")
    up = -np.array(built_housing.document["rest"]["direction"])
    # The seam faces upwards at rest; printing needs it below.
    mesh.apply_transform(trimesh.geometry.align_vectors(up, [0.0, 0.0, -1.0]))
    turned = tmp_path / "turned.stl"
    mesh.export(turned)
    gcode = prusa_slicer.slice(turned, tmp_path / "lower.gcode")
    assert gcode.count("\n") > 10_000
    assert "filament used [mm]" in gcode


@pytest.mark.parametrize("half", HALVES)
def test_a_mesh_with_facets_removed_is_caught(built_housing: BuiltHousing, tmp_path: Path, half: str) -> None:
    """The same file that passed no longer passes when a single facet is taken out of it."""
    model = next(part for part in built_housing.document["parts"] if part["name"] == half)
    expected = Expected(half, model["volume_mm3"], tuple(model["com_mm"]), SAG_UM)
    whole = built_housing.folder / f"{half}.stl"
    assert inspect_file(whole, [expected]).ok

    data = whole.read_bytes()
    count = int.from_bytes(data[80:84], "little")
    damaged = tmp_path / f"{half}.stl"
    damaged.write_bytes(data[:80] + (count - 1).to_bytes(4, "little") + data[84:-50])
    found = inspect_file(damaged, [expected])
    assert not found.ok
    assert any("watertight" in problem for problem in found.problems)


def test_a_third_opinion_agrees(built_housing: BuiltHousing, pymeshlab: Any) -> None:
    """PyMeshLab counts no boundary and no non-manifold edge in any half, as they are on disk."""
    for half in HALVES:
        meshes = pymeshlab.MeshSet()
        meshes.load_new_mesh(str(built_housing.folder / f"{half}.stl"))
        meshes.meshing_merge_close_vertices(threshold=pymeshlab.PureValue(0.0))
        measures = meshes.get_topological_measures()
        assert measures["boundary_edges"] == 0
        assert measures["non_two_manifold_edges"] == 0
        assert measures["connected_components_number"] == 1
