"""Written files as other programs see them, and the same bytes every time."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lib3mf
import numpy as np
import pytest
import trimesh
from build123d import Box, Compound, Location, Solid, import_step

from gomboc_cad.errors import InspectionError, OutputError
from gomboc_cad.solid.export import NamedMesh, NamedSolid, file_date, write_3mf, write_step, write_stl
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.mesh import Mesh
from gomboc_cad.solid.mesh_reading import read_3mf
from gomboc_cad.solid.step import read_step
from tests.external import PrusaSlicer, digests
from tests.solid.conftest import Halves

RunInFreeCAD = Callable[..., dict[str, Any]]


def test_bare_body_is_small(files: Path) -> None:
    assert (files / "body.step").stat().st_size < 1_000_000


def test_build123d_reads_the_assembly_with_names_and_colours(files: Path, halves: Halves) -> None:
    assembly = import_step(files / "assembly.step")
    assert isinstance(assembly, Compound)
    assert assembly.label == "hollow"
    # build123d turns blanks in names into underscores.
    assert [part.label for part in assembly.children] == ["lower_half", "upper_half"]
    assert tuple(assembly.children[0].color)[:3] == pytest.approx((0.8, 0.2, 0.1), abs=1e-6)
    for part, expected in zip(assembly.children, halves.expected, strict=True):
        assert part.is_valid
        assert solid_mass(part).volume_mm3 == pytest.approx(expected.volume_mm3, rel=1e-8)


def test_parts_of_equal_shape_keep_their_names_and_places(tmp_path: Path) -> None:
    bolt = Box(1, 2, 3).solid()
    assert isinstance(bolt, Solid)
    parts = [
        NamedSolid(f"bolt-{i}", bolt.moved(Location((10.0 * i, 0, 0), (0, 0, 30.0 * i)))) for i in range(3)
    ]
    write_step(tmp_path / "bolts.step", parts, "bolts")
    read = read_step(tmp_path / "bolts.step")
    assert [part.name for part in read] == ["bolt-0", "bolt-1", "bolt-2"]
    assert [solid_mass(part.solid).com_mm[0] for part in read] == pytest.approx([0.0, 10.0, 20.0], abs=1e-9)


@pytest.mark.parametrize("name", ["Gehäuse ø50 'neu'", "半分"])
def test_names_may_use_any_letters(tmp_path: Path, name: str) -> None:
    corner = Mesh(np.eye(4, 3), np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]))
    write_step(tmp_path / "a.step", [NamedSolid(name, Box(1, 1, 1).solid())], name)
    write_3mf(tmp_path / "a.3mf", [NamedMesh(name, corner)])
    write_stl(tmp_path / "a.stl", corner, name)
    assert [part.name for part in read_step(tmp_path / "a.step")] == [name]
    assert [found for found, _ in read_3mf(tmp_path / "a.3mf")] == [name]


def test_step_is_in_millimetres_with_a_fixed_date(files: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (files / "body.step").read_text("ascii")
    assert "SI_UNIT(.MILLI.,.METRE.)" in text
    assert "FILE_NAME('primary','1980-01-01T00:00:00'" in text
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    assert file_date().isoformat() == "2023-11-14T22:13:20+00:00"
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "yesterday")
    with pytest.raises(OutputError, match="SOURCE_DATE_EPOCH"):
        file_date()


def test_freecad_opens_every_step(files: Path, halves: Halves, run_in_freecad: RunInFreeCAD) -> None:
    script = (
        "import Part\n"
        "for name in ('body', 'assembly', 'lower'):\n"
        "    shape = Part.read(inputs['folder'] + '/' + name + '.step')\n"
        "    report(**{name: [[s.isValid(), s.Volume, *s.CenterOfMass] for s in shape.Solids]})\n"
    )
    found = run_in_freecad(script, folder=files)
    volumes = (
        [523458.313905] + [part.volume_mm3 for part in halves.expected] + [halves.expected[0].volume_mm3]
    )
    solids = found["body"] + found["assembly"] + found["lower"]
    assert all(solid[0] for solid in solids)
    # The demand is 50 ppm; divided edges make FreeCAD's integration almost exact.
    assert [solid[1] for solid in solids] == pytest.approx(volumes, rel=1e-6)
    assert found["lower"][0][2:] == pytest.approx(halves.expected[0].com_mm, abs=1e-4)


def test_freecad_keeps_the_name(files: Path, run_in_freecad: RunInFreeCAD) -> None:
    # FreeCAD 0.20 crashes when it imports an assembly without a screen, its own exports included.
    script = (
        "import FreeCAD, Import\n"
        "document = FreeCAD.newDocument()\n"
        "Import.insert(inputs['file'], document.Name)\n"
        "report(labels=[o.Label for o in document.Objects])\n"
    )
    assert run_in_freecad(script, file=files / "lower.step")["labels"] == ["lower half"]


@pytest.mark.parametrize("name", ["body.stl", "lower.stl", "halves.3mf"])
def test_prusaslicer_finds_the_meshes_manifold(files: Path, name: str, prusa_slicer: PrusaSlicer) -> None:
    info = prusa_slicer.info(files / name)
    assert info["manifold"] is True
    assert info["number_of_parts"] == 1.0
    assert "open_edges" not in info
    assert "facets_reversed" not in info


def test_stl_holds_the_facets_with_their_normals(files: Path, halves: Halves) -> None:
    data = (files / "lower.stl").read_bytes()
    assert data[:80].startswith(b"gomboc-cad, unit mm, lower half")
    read = trimesh.load_mesh(files / "lower.stl", process=False)
    corners = halves.meshes[0].vertices_mm[halves.meshes[0].faces]
    assert np.array_equal(read.triangles, corners.astype(np.float32))
    written = np.frombuffer(data[84:], dtype=np.dtype([("n", "<f4", 3), ("rest", "V38")]))["n"]
    large = read.area_faces > 1e-3
    assert np.einsum("nx,nx->n", written, read.face_normals)[large] == pytest.approx(1.0, abs=1e-4)


def test_lib3mf_finds_nothing_to_complain_of(files: Path, halves: Halves) -> None:
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(files / "halves.3mf"))
    assert reader.GetWarningCount() == 0
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
    objects = model.GetMeshObjects()
    found = []
    while objects.MoveNext():
        item = objects.GetCurrentMeshObject()
        assert item.IsManifoldAndOriented()
        found.append((item.GetName(), item.GetTriangleCount()))
    assert found == [(e.name, len(m.faces)) for e, m in zip(halves.expected, halves.meshes, strict=True)]


def test_3mf_members_carry_the_fixed_date(files: Path) -> None:
    with zipfile.ZipFile(files / "halves.3mf") as archive:
        assert {member.date_time for member in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


@pytest.mark.slow
def test_writing_an_assembly_again_in_one_process_gives_the_same_bytes(tmp_path: Path) -> None:
    parts = [NamedSolid(name, Solid.make_box(1.0, 2.0, size)) for name, size in (("a", 3.0), ("b", 4.0))]
    for name in ("one", "two"):
        write_step(tmp_path / f"{name}.step", parts, "boxes")
    assert (tmp_path / "one.step").read_bytes() == (tmp_path / "two.step").read_bytes()


def test_writing_twice_gives_the_same_bytes(tmp_path: Path, files: Path, root: Path) -> None:
    """A process of its own, with other hashes and other addresses, makes everything again."""
    script = (
        "import sys; from pathlib import Path; import gomboc_cad\n"
        "from gomboc_cad.solid.boundary import Boundary\n"
        "from gomboc_cad.solid.hollow import brep, mesh, split_brep, split_mesh\n"
        "from gomboc_cad.solid.inspect import Expected\n"
        "from tests.solid.conftest import *\n"
        "body = gomboc_cad.catalog()['primary']; hollow = reference_hollow(body)\n"
        "solids = split_brep(brep(hollow), SEAM)\n"
        "meshes = split_mesh(mesh(hollow, SAG_UM), SEAM, SAG_UM)\n"
        "expected = [Expected(n, 1.0, ORIGIN, 1.0) for n in ('lower half', 'upper half')]\n"
        "write_all(Path(sys.argv[1]), body, Halves(solids, meshes, expected))\n"
    )
    environment = {key: value for key, value in os.environ.items() if key != "SOURCE_DATE_EPOCH"}
    environment |= {"PYTHONHASHSEED": "7", "PYTHONPATH": str(root)}
    subprocess.run([sys.executable, "-B", "-c", script, str(tmp_path)], check=True, env=environment, cwd=root)
    assert digests(tmp_path) == digests(files)


def test_no_writer_leaves_anything_behind_when_the_folder_is_missing(tmp_path: Path) -> None:
    box = NamedSolid("box", Box(1, 1, 1).solid())
    mesh = Mesh(np.eye(4, 3), np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]))
    for write in (
        lambda path: write_step(path, [box], "box"),
        lambda path: write_stl(path, mesh, "corner"),
        lambda path: write_3mf(path, []),
    ):
        with pytest.raises(OutputError, match="does not exist"):
            write(tmp_path / "missing" / "file")
    assert not list(tmp_path.iterdir())


def test_what_is_no_step_file_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "a.step").write_text("solid ascii\n")
    with pytest.raises(InspectionError, match="not a whole STEP file"):
        read_step(tmp_path / "a.step")
