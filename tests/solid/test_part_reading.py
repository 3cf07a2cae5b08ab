"""Mesh files of every format are read as what they are; damaged, lying and hostile ones get one sentence."""

from __future__ import annotations

import contextlib
import io
import os
import struct
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Any

import lib3mf
import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.errors import GombocError, InspectionError
from gomboc_cad.solid.export import NamedMesh, write_3mf, write_stl
from gomboc_cad.solid.formats.content import MAX_BYTES
from gomboc_cad.solid.mesh import Mesh
from gomboc_cad.solid.part_reading import PartMesh, read_part
from tests.solid import hostile
from tests.solid.hostile import box, package, reversed_mesh, three_mf, together, write

BOX_COM_MM = (5.0, 10.0, 15.0)


def assert_is_the_box(part: PartMesh, scale: float = 1.0) -> None:
    assert part.faults == ()
    assert part.watertight
    assert part.volume_mm3 == pytest.approx(6000.0 * scale**3, rel=1e-6)
    assert part.com_mm == pytest.approx(tuple(scale * c for c in BOX_COM_MM), rel=1e-6)


def reason(path: Path, **options: Any) -> str:
    """What reading a file is refused with."""
    with pytest.raises(InspectionError) as refused:
        read_part(path, **options)
    return str(refused.value)


class TestFormats:
    """The same box in every format, by several writers."""

    @pytest.mark.parametrize("kind", hostile.WRITERS)
    def test_one_box(self, tmp_path: Path, kind: str) -> None:
        suffix, writer = hostile.WRITERS[kind]
        part = read_part(write(tmp_path, f"box{suffix}", writer(box())))
        assert_is_the_box(part)
        assert len(part.mesh.vertices_mm) == 8
        assert (part.unit, part.repairs, part.notes) == ("mm", (), ())

    @pytest.mark.parametrize(
        ("name", "options"),
        [
            ("box.stl", {}),
            ("box.stl", {"file_type": "stl_ascii"}),
            ("box.obj", {}),
            ("box.ply", {}),
            ("box.ply", {"encoding": "ascii"}),
            ("box.3mf", {}),
        ],
    )
    def test_as_trimesh_writes_it(self, tmp_path: Path, name: str, options: dict[str, str]) -> None:
        mesh = box()
        trimesh.Trimesh(mesh.vertices_mm, mesh.faces, process=False).export(tmp_path / name, **options)
        assert_is_the_box(read_part(tmp_path / name))

    def test_as_we_write_it(self, tmp_path: Path) -> None:
        write_stl(tmp_path / "box.stl", box(), "box")
        write_3mf(tmp_path / "box.3mf", [NamedMesh("box", box())])
        for name in ("box.stl", "box.3mf"):
            assert_is_the_box(read_part(tmp_path / name))

    def test_as_lib3mf_writes_components_in_inches(self, tmp_path: Path) -> None:
        wrapper = lib3mf.get_wrapper()
        model = wrapper.CreateModel()
        model.SetUnit(lib3mf.ModelUnit.Inch)
        mesh = model.AddMeshObject()
        corners = box((0.5, 2.0, 3.0))
        mesh.SetGeometry(
            [lib3mf.Position(tuple(v)) for v in corners.vertices_mm.tolist()],
            [lib3mf.Triangle(tuple(f)) for f in corners.faces.tolist()],
        )
        both = model.AddComponentsObject()
        shifted = wrapper.GetTranslationTransform(0.5, 0.0, 0.0)
        # Two boxes that share a side: not one solid, and the reader has to say so.
        both.AddComponent(mesh, wrapper.GetIdentityTransform())
        both.AddComponent(mesh, shifted)
        model.AddBuildItem(both, wrapper.GetTranslationTransform(1.0, 0.0, 0.0))
        model.QueryWriter("3mf").WriteToFile(str(tmp_path / "boxes.3mf"))
        part = read_part(tmp_path / "boxes.3mf")
        assert part.unit == "in"
        assert "25.4" in part.notes[0]
        assert part.mesh.vertices_mm.max(axis=0) == pytest.approx((50.8, 50.8, 76.2))
        assert part.mesh.vertices_mm[:, 0].min() == pytest.approx(25.4)
        assert part.volume_mm3 is None

    @pytest.mark.usefixtures("freecadcmd")
    def test_as_freecad_writes_it(self, tmp_path: Path, run_in_freecad) -> None:
        script = (
            "import Mesh, Part, MeshPart\n"
            "solid = Part.makeBox(10, 20, 30)\n"
            "mesh = MeshPart.meshFromShape(Shape=solid, LinearDeflection=0.1)\n"
            "for name in ('box.stl', 'box.obj', 'box.ply'):\n"
            "    mesh.write(inputs['folder'] + '/' + name)\n"
            "mesh.write(inputs['folder'] + '/text.stl', 'AST')\n"
            "report(done=True)\n"
        )
        run_in_freecad(script, folder=tmp_path)
        for name in ("box.stl", "box.obj", "box.ply", "text.stl"):
            assert_is_the_box(read_part(tmp_path / name))

    def test_as_prusaslicer_writes_it(self, tmp_path: Path, prusa_slicer) -> None:
        source = write(tmp_path, "box.stl", hostile.binary_stl(box()))
        for name, option in (("box.3mf", "--export-3mf"), ("box.obj", "--export-obj")):
            prusa_slicer._run(option, "--output", str(tmp_path / name), str(source), timeout_s=120)
            part = read_part(tmp_path / name)
            assert part.faults == ()
            assert part.volume_mm3 == pytest.approx(6000.0, rel=1e-6)

    def test_a_text_header_on_binary_data_and_the_reverse(self, tmp_path: Path) -> None:
        assert_is_the_box(
            read_part(write(tmp_path, "a.stl", hostile.binary_stl(box(), b"solid facet normal 0 0 0\n")))
        )
        odd = (
            hostile.text_stl(box())
            .replace(b"solid part", b"SOLID \xff\xfe binary", 1)
            .replace(b"\n", b"\r\n")
        )
        part = read_part(write(tmp_path, "b.stl", odd))
        assert part.kind == "a text STL file"
        assert_is_the_box(part)

    def test_polygons_and_negative_indices(self, tmp_path: Path) -> None:
        lines = [f"v {x} {y} {z}" for x, y, z in box().vertices_mm.tolist()]
        quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        lines += ["f " + " ".join(str(k - 8) for k in quad) for quad in quads]
        assert_is_the_box(read_part(write(tmp_path, "quads.obj", "\n".join(lines).encode())))

    def test_a_hollow_polygon_is_cut_into_triangles(self, tmp_path: Path) -> None:
        # A U-shaped prism: no corner of the U sees all of it.
        outline = [(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]
        n = len(outline)
        lines = [f"v {x} {y} {z}" for z in (0, 5) for x, y in outline]
        lines += [
            "f " + " ".join(map(str, range(n, 0, -1))),
            "f " + " ".join(map(str, range(n + 1, 2 * n + 1))),
        ]
        lines += [f"f {k + 1} {(k + 1) % n + 1} {(k + 1) % n + n + 1} {k + n + 1}" for k in range(n)]
        part = read_part(write(tmp_path, "u.obj", "\n".join(lines).encode()), unit="cm")
        assert part.faults == ()
        assert part.volume_mm3 == pytest.approx(7.0 * 5.0 * 1000.0)

    def test_ply_lists_of_different_lengths_and_other_elements(self, tmp_path: Path) -> None:
        header = (
            "ply\nformat binary_little_endian 1.0\nelement vertex 8\nproperty double x\nproperty double y\n"
            "property double z\nproperty uchar red\nelement face 7\nproperty uchar flags\n"
            "property list uint8 uint32 vertex_index\nproperty float quality\nelement edge 1\n"
            "property int vertex1\nproperty int vertex2\nend_header\n"
        )
        vertices = b"".join(struct.pack("<3dB", *v, 7) for v in box().vertices_mm.tolist())
        rows = [(0, 1, 3), (0, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        faces = b"".join(struct.pack(f"<BB{len(r)}If", 1, len(r), *r, 0.5) for r in rows)
        content = header.encode() + vertices + faces + struct.pack("<ii", 0, 1)
        assert_is_the_box(read_part(write(tmp_path, "mixed.ply", content)))

    def test_the_material_file_of_an_obj_is_never_opened(self, tmp_path: Path) -> None:
        os.mkfifo(tmp_path / "other.mtl")  # opening it for reading would wait for ever
        assert_is_the_box(read_part(write(tmp_path, "box.obj", hostile.obj(box()))))

    def test_a_name_that_is_no_utf8(self, tmp_path: Path) -> None:
        path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/b\xffx.stl"))
        path.write_bytes(hostile.binary_stl(box()))
        assert_is_the_box(read_part(path))
        path.write_bytes(hostile.binary_stl(box())[:-1])
        reason(path).encode("utf-8")


class TestUnits:
    @pytest.mark.parametrize(
        ("unit", "scale"), [("mm", 1.0), ("um", 1e-3), ("cm", 10.0), ("m", 1e3), ("in", 25.4)]
    )
    def test_scale_files_without_a_unit(self, tmp_path: Path, unit: str, scale: float) -> None:
        for name in ("box.stl", "box.obj", "box.ply"):
            writer = dict(hostile.WRITERS.values())[Path(name).suffix]
            part = read_part(write(tmp_path, name, writer(box())), unit=unit)
            assert_is_the_box(part, scale)
            assert part.unit == unit

    @pytest.mark.parametrize(
        ("unit", "scale"),
        [("micron", 1e-3), ("centimeter", 10.0), ("inch", 25.4), ("foot", 304.8), ("meter", 1e3)],
    )
    def test_of_a_3mf_are_its_own(self, tmp_path: Path, unit: str, scale: float) -> None:
        path = write(tmp_path, "box.3mf", three_mf(box(), unit=unit))
        part = read_part(path)
        assert_is_the_box(part, scale)
        assert unit in part.notes[0]
        assert read_part(path, unit=part.unit).volume_mm3 == part.volume_mm3
        assert "leave --unit out" in reason(path, unit="mm")

    def test_unknown_ones_are_refused(self, tmp_path: Path) -> None:
        path = write(tmp_path, "box.stl", hostile.binary_stl(box()))
        assert "furlong" in reason(path, unit="furlong")
        assert "parsec" in reason(write(tmp_path, "box.3mf", three_mf(box(), unit="parsec")))

    @pytest.mark.parametrize(("size", "says"), [(0.98, "24.89 mm if it is the inch"), (5000.0, "say --unit")])
    def test_a_suspicious_size_is_noted(self, tmp_path: Path, size: float, says: str) -> None:
        path = write(tmp_path, "box.stl", hostile.binary_stl(box((size, size, size))))
        (note,) = read_part(path).notes
        assert says in note
        assert read_part(path, unit="mm").notes == ()

    def test_inches_keep_the_rounding_of_32_bits(self, tmp_path: Path) -> None:
        part = read_part(write(tmp_path, "box.stl", hostile.binary_stl(box((0.3, 0.7, 1.1)))), unit="in")
        assert np.array_equal(part.mesh.vertices_mm.astype(np.float32), part.mesh.vertices_mm)


class TestRepairs:
    """What is repaired is said; what would be guessed is a fault."""

    def read(self, folder: Path, mesh: Mesh) -> PartMesh:
        return read_part(write(folder, "part.obj", hostile.obj(mesh)))

    def test_facets_that_face_inwards(self, tmp_path: Path) -> None:
        part = self.read(tmp_path, reversed_mesh(box()))
        assert_is_the_box(part)
        assert part.repairs == ("All facets faced inwards; they were turned.",)

    def test_some_facets_turned_over(self, tmp_path: Path) -> None:
        mesh = box()
        mesh.faces[[2, 7]] = mesh.faces[[2, 7], ::-1]
        part = self.read(tmp_path, mesh)
        assert_is_the_box(part)
        assert part.repairs == ("2 facets that faced the other way than their neighbours were turned.",)

    def test_repeated_and_collapsed_facets_and_loose_vertices(self, tmp_path: Path) -> None:
        mesh = box()
        faces = np.concatenate([mesh.faces, mesh.faces[3:5, [1, 2, 0]], [[1, 1, 2]]])
        part = self.read(tmp_path, Mesh(np.concatenate([mesh.vertices_mm, [[99.0, 99.0, 99.0]]]), faces))
        assert_is_the_box(part)
        assert part.mesh.vertices_mm.max() == 30.0
        assert [repair.split(maxsplit=1)[0] for repair in part.repairs] == ["1", "1", "2"]

    def test_corners_apart_by_rounding(self, tmp_path: Path) -> None:
        mesh = box()
        soup = Mesh(mesh.vertices_mm[mesh.faces].reshape(-1, 3), np.arange(36).reshape(-1, 3))
        soup.vertices_mm[::5] += 4e-6
        part = self.read(tmp_path, soup)
        assert part.faults == ()
        assert "rounding" in part.repairs[-1]
        assert part.volume_mm3 == pytest.approx(6000.0, rel=1e-5)

    def test_a_hole(self, tmp_path: Path) -> None:
        part = self.read(tmp_path, Mesh(box().vertices_mm, box().faces[1:]))
        assert not part.watertight
        assert (part.volume_mm3, part.com_mm) == (None, None)
        assert part.faults == ("it is not watertight: 3 edges belong to one facet only",)

    def test_a_fin(self, tmp_path: Path) -> None:
        mesh = box()
        mesh = Mesh(
            np.concatenate([mesh.vertices_mm, [[5.0, 10.0, 50.0]]]), np.concatenate([mesh.faces, [[1, 5, 8]]])
        )
        assert "join more than two facets" in self.read(tmp_path, mesh).faults[1]

    def test_a_cavity_is_part_of_the_solid(self, tmp_path: Path) -> None:
        inner = box((2.0, 2.0, 2.0), (4.0, 9.0, 14.0))
        part = self.read(tmp_path, together(box(), reversed_mesh(inner)))
        assert part.faults == ()
        assert part.volume_mm3 == pytest.approx(5992.0)
        again = self.read(tmp_path, reversed_mesh(together(box(), reversed_mesh(inner))))
        assert again.volume_mm3 == pytest.approx(5992.0)

    @pytest.mark.parametrize(
        ("other", "says"),
        [
            (box((2.0, 2.0, 2.0), (4.0, 9.0, 14.0)), "do not face as a solid"),
            (reversed_mesh(box((2.0, 2.0, 2.0), (40.0, 9.0, 14.0))), "do not face as a solid"),
            (box((2.0, 2.0, 2.0), (40.0, 9.0, 14.0)), "2 separate bodies"),
            (box((10.0, 20.0, 30.0), (5.0, 3.0, 4.0)), "crosses itself"),
            (box((10.0, 20.0, 30.0), (5.0, 0.0, 0.0)), "crosses itself"),
            (box((2.0, 2.0, 2.0), (4.0, 9.0, 29.0)), "crosses itself"),
            (reversed_mesh(box((2.0, 2.0, 2.0), (4.0, 9.0, 29.0))), "crosses itself"),
        ],
        ids=["within", "inside out beside", "beside", "across", "across in plane", "through", "cavity out"],
    )
    def test_two_shells_that_are_no_solid(self, tmp_path: Path, other: Mesh, says: str) -> None:
        part = self.read(tmp_path, together(box(), other))
        assert part.watertight
        assert part.volume_mm3 is None
        assert says in part.faults[0]

    def test_a_loose_body_in_a_cavity(self, tmp_path: Path) -> None:
        cavity, core = box((6.0, 6.0, 6.0), (2.0, 2.0, 2.0)), box((2.0, 2.0, 2.0), (4.0, 4.0, 4.0))
        part = self.read(tmp_path, together(box(), reversed_mesh(cavity), core))
        assert "2 separate bodies" in part.faults[0]

    @given(st.integers(0, 2**32 - 1))
    @settings(max_examples=30, deadline=None)
    def test_a_dent_through_the_other_side(self, seed: int) -> None:
        directions, faces = geodesic_triangulation(2)
        pushed = np.random.default_rng(seed).integers(len(directions))
        for depth, crosses in ((0.5, False), (-1.5, True)):
            vertices = 10.0 * directions
            vertices[pushed] *= depth
            stream = hostile.binary_stl(Mesh(vertices, faces))
            part = read_bytes(stream, ".stl")
            assert bool(part.faults) is crosses

    def test_a_knotted_tube_does_not_cross_itself_until_it_is_thick(self, tmp_path: Path) -> None:
        for radius, crosses in ((0.3, False), (0.8, True)):
            part = self.read(tmp_path, knotted_tube(radius))
            assert bool(part.faults) is crosses, part.faults

    def test_one_side_only(self, tmp_path: Path) -> None:
        # The projective plane of ten triangles: closed, but with one side.
        faces = ["012", "023", "034", "045", "051", "124", "235", "341", "452", "513"]
        corners = np.random.default_rng(5).normal(size=(6, 3)) * 10.0
        part = self.read(tmp_path, Mesh(corners, np.array([list(map(int, f)) for f in faces])))
        assert part.watertight
        assert "one side" in part.faults[0]

    def test_a_doubled_sheet_encloses_nothing(self, tmp_path: Path) -> None:
        sheet = Mesh(
            np.array([[0.0, 0, 0], [9, 0, 0], [9, 9, 1], [0, 9, 0]]), np.array([[0, 1, 2], [0, 2, 3]])
        )
        mesh = together(sheet, Mesh(sheet.vertices_mm, sheet.faces[:, ::-1]))
        part = self.read(tmp_path, mesh)
        assert part.volume_mm3 is None
        assert part.faults


def knotted_tube(radius: float) -> Mesh:
    """A tube around a trefoil knot."""
    n, m = 240, 16
    t, a = np.meshgrid(np.arange(n) * 2 * np.pi / n, np.arange(m) * 2 * np.pi / m, indexing="ij")

    def curve(t: np.ndarray) -> np.ndarray:
        knot = [np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)]
        return np.stack(knot, axis=-1)

    along = curve(t + 1e-4) - curve(t - 1e-4)
    first = np.cross(along, [0.1, 0.2, 1.0])
    second = np.cross(along, first)
    first, second = (x / np.linalg.norm(x, axis=-1, keepdims=True) for x in (first, second))
    points = curve(t) + radius * (np.cos(a)[..., None] * first + np.sin(a)[..., None] * second)
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    at = [((i + di) % n * m + (j + dj) % m).ravel() for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1))]
    faces = [np.stack([at[0], at[1], at[2]], axis=1), np.stack([at[0], at[2], at[3]], axis=1)]
    return Mesh(20.0 * points.reshape(-1, 3), np.concatenate(faces))


def read_bytes(content: bytes, suffix: str) -> PartMesh:
    with tempfile.TemporaryDirectory() as folder:
        return read_part(write(Path(folder), "part" + suffix, content))


class TestRefusals:
    """Each gets one sentence that says what is wrong."""

    def test_no_file(self, tmp_path: Path) -> None:
        assert "cannot be read" in reason(tmp_path / "nothing.stl")
        assert "folder" in reason(tmp_path)
        assert "empty" in reason(write(tmp_path, "empty.stl", b""))

    def test_a_pipe(self, tmp_path: Path) -> None:
        os.mkfifo(tmp_path / "pipe.stl")
        assert "no ordinary file" in reason(tmp_path / "pipe.stl")

    def test_a_huge_file(self, tmp_path: Path) -> None:
        path = tmp_path / "huge.obj"
        with path.open("wb") as stream:
            stream.write(b"v 0 0 0\n")
            stream.truncate(3 * MAX_BYTES)
        assert "make it coarser" in reason(path)

    @pytest.mark.parametrize("kind", hostile.WRITERS)
    def test_the_wrong_suffix(self, tmp_path: Path, kind: str) -> None:
        suffix, writer = hostile.WRITERS[kind]
        wrong = ".stl" if suffix != ".stl" else ".obj"
        assert f"rename it to end with {suffix}" in reason(write(tmp_path, "box" + wrong, writer(box())))

    @pytest.mark.parametrize(
        ("content", "says"),
        [
            (b"%PDF-1.7 ...", "a PDF file"),
            (b"\x1f\x8b\x08\0\0", "a gzip archive"),
            (b"<html></html>", "a web page"),
            (b"\x00\x01\x02\x03" * 9, "unknown format"),
            (b"hello\n", "unknown format"),
        ],
    )
    def test_something_else(self, tmp_path: Path, content: bytes, says: str) -> None:
        assert says in reason(write(tmp_path, "part.stl", content))

    @pytest.mark.parametrize("facets", [0, 1, 4_000_000_000])
    def test_a_lying_count(self, tmp_path: Path, facets: int) -> None:
        says = "no facets" if facets == 0 else "its header says"
        assert says in reason(write(tmp_path, "part.stl", hostile.declared_stl(facets)))

    def test_a_true_count_of_too_many(self, tmp_path: Path) -> None:
        path = write(tmp_path, "many.stl", hostile.declared_stl(6_000_000))
        os.truncate(path, 84 + 50 * 6_000_000)
        assert "6,000,000 facets" in reason(path)

    def test_a_ply_that_declares_too_much(self, tmp_path: Path) -> None:
        content = hostile.ply_header("binary_little_endian", 10**12, 1)
        assert "1,000,000,000,000" in reason(write(tmp_path, "part.ply", content))
        content = hostile.ply_header("binary_little_endian", 10**7, 1)
        assert "cut off" in reason(write(tmp_path, "part.ply", content))

    @pytest.mark.parametrize("length", [2, 4, 255])
    @pytest.mark.parametrize("order", ["<", ">"])
    def test_a_ply_list_that_lies(self, tmp_path: Path, length: int, order: str) -> None:
        content = bytearray(hostile.binary_ply(box(), order))
        content[-13] = length
        path = write(tmp_path, "part.ply", bytes(content))
        assert "damaged" in reason(path)

    @pytest.mark.parametrize(
        ("old", "new"),
        [
            (b"element vertex 8", b"element vertex -8"),
            (b"element vertex 8", b"element vertex 9"),
            (b"property float y", b"property quaternion y"),
            (b"property float y", b"property float x"),
            (b"property float y", b"property float w"),
            (b"element face", b"element vertex"),
            (b"vertex_indices", b"something_else"),
            (b"end_header", b"no_end"),
            (b"format ascii", b"format gzip"),
            (b"3 0 1 3", b"3 0 1"),
            (b"3 0 1 3", b"-3 0 1 3"),
            (b"3 0 1 3", b"3 0 1 8"),
            (b"3 0 1 3", b"2 0 1"),
        ],
    )
    def test_a_damaged_ply(self, tmp_path: Path, old: bytes, new: bytes) -> None:
        content = hostile.text_ply(box())
        assert old in content
        assert "damaged" in reason(write(tmp_path, "part.ply", content.replace(old, new, 1)))

    @pytest.mark.parametrize("line", [b"f 1 2 99", b"f 1 2 -99", b"f 0 1 2", b"f 1 2", b"f a b c", b"v 1 2"])
    def test_a_damaged_obj(self, tmp_path: Path, line: bytes) -> None:
        assert "damaged" in reason(write(tmp_path, "part.obj", hostile.obj(box()) + line + b"\n"))

    def test_free_form_surfaces(self, tmp_path: Path) -> None:
        assert "free-form" in reason(write(tmp_path, "part.obj", b"v 0 0 0\ncstype bspline\n"))

    @pytest.mark.parametrize(
        ("kind", "value"),
        [
            (kind, value)
            for kind in hostile.WRITERS
            for value in ("nan", "inf", "1e30", "1e308")
            # Its writer packs 32-bit numbers, which end at 3e38.
            if (kind, value) != ("binary STL", "1e308")
        ],
    )
    def test_coordinates_that_are_none(self, tmp_path: Path, kind: str, value: str) -> None:
        suffix, writer = hostile.WRITERS[kind]
        mesh = box()
        mesh.vertices_mm[3, 1] = float(value)
        with np.errstate(over="ignore"):
            content = writer(mesh)
        assert write(tmp_path, "part" + suffix, content)
        assert "coordinates" in (found := reason(tmp_path / f"part{suffix}")) or "sizes" in found

    @pytest.mark.parametrize("size", [1e-5, 1e8])
    def test_sizes_that_no_part_has(self, tmp_path: Path, size: float) -> None:
        path = write(tmp_path, "part.stl", hostile.binary_stl(box((size, size, size))))
        assert "--unit" in reason(path)

    def test_flat_or_empty_bodies(self, tmp_path: Path) -> None:
        flat = box((10.0, 20.0, 0.0))
        assert "holds no body" in reason(write(tmp_path, "flat.stl", hostile.binary_stl(flat)))
        three = Mesh(box().vertices_mm, box().faces[:3])
        assert "holds no body" in reason(write(tmp_path, "three.stl", hostile.binary_stl(three)))
        header = hostile.text_ply(box()).split(b"element face")[0] + b"end_header\n"
        assert "points only" in reason(write(tmp_path, "points.ply", header + b"0 0 0\n" * 8))

    @pytest.mark.parametrize("kind", hostile.WRITERS)
    def test_every_truncation(self, tmp_path: Path, kind: str) -> None:
        suffix, writer = hostile.WRITERS[kind]
        content = writer(box())
        for length in range(0, len(content) - 2, max(1, len(content) // 60)):
            path = write(tmp_path, "part" + suffix, content[:length])
            try:
                part = read_part(path)
            except InspectionError:
                continue
            # An OBJ has no end mark: cut at a line it is a mesh with a hole, unless only its end is gone.
            assert kind == "OBJ"
            assert part.watertight is (len(content) - length < 5)


class TestThreeMf:
    def test_transforms_mirrored_ones_too(self, tmp_path: Path) -> None:
        path = write(tmp_path, "box.3mf", three_mf(box(), transform="-2 0 0 0 1 0 0 0 1 100 0 0"))
        part = read_part(path)
        assert part.repairs == ()
        assert part.volume_mm3 == pytest.approx(12000.0)
        assert part.com_mm == pytest.approx((90.0, 10.0, 15.0))

    def test_components_in_components(self, tmp_path: Path) -> None:
        nested = (
            '<object id="2" type="model"><components><component objectid="1" '
            'transform="1 0 0 0 1 0 0 0 1 1 0 0"/></components></object>'
            '<object id="3" type="model"><components><component objectid="2" '
            'transform="0 1 0 -1 0 0 0 0 1 0 0 0"/></components></object>'
        )
        model = hostile.model_xml({"box": box()}, resources=nested)
        model = model.replace(
            '<item objectid="1"/>', '<item objectid="3" transform="1 0 0 0 1 0 0 0 1 0 0 7"/>'
        )
        part = read_part(write(tmp_path, "box.3mf", package(model)))
        # First moved by x + 1, then turned by a quarter about z, then lifted by 7.
        assert part.com_mm == pytest.approx((-10.0, 6.0, 22.0))

    def test_objects_in_other_models_of_the_package(self, tmp_path: Path) -> None:
        part_model = hostile.model_xml({"box": box()})
        root = (
            f'<model xmlns="{hostile.CORE}" xmlns:p="{hostile.PRODUCTION}" requiredextensions="p"><resources>'
            '<object id="8"><components><component p:path="/3D/Objects/box.model" objectid="1"/></components>'
            '</object></resources><build><item objectid="8"/></build></model>'
        )
        content = package(root, **{"3D/Objects/box.model": part_model})
        assert_is_the_box(read_part(write(tmp_path, "box.3mf", content)))

    def test_several_parts_are_named(self, tmp_path: Path) -> None:
        model = hostile.model_xml({"left": box(), "right": box(low=(50.0, 0.0, 0.0))})
        part = read_part(write(tmp_path, "parts.3mf", package(model)))
        assert "2 parts (left, right)" in part.faults[0]
        assert part.volume_mm3 is None

    def test_supports_are_left_out(self, tmp_path: Path) -> None:
        model = hostile.model_xml({"part": box(), "post": box(low=(50.0, 0.0, 0.0))})
        model = model.replace('name="post" type="model"', 'name="post" type="support"')
        part = read_part(write(tmp_path, "parts.3mf", package(model)))
        assert_is_the_box(part)
        assert "1 build items" in part.notes[0]

    def test_an_extension_that_changes_the_geometry(self, tmp_path: Path) -> None:
        model = hostile.model_xml({"part": box()}).replace(
            "<model ", '<model xmlns:b="http://example.org/beams" requiredextensions="b" '
        )
        assert "extension 'b'" in reason(write(tmp_path, "part.3mf", package(model)))

    @pytest.mark.parametrize(
        ("make", "says"),
        [
            (hostile.zip_bomb, "zip bomb"),
            (hostile.entity_bomb, "document type"),
            (lambda: hostile.doubling_components(15), "placed objects"),
            (lambda: hostile.doubling_components(40), "levels of components"),
            (lambda: package(hostile.model_xml({"b": box()}), **{"../../evil.txt": "x"}), "../../evil.txt"),
            (lambda: package(hostile.model_xml({"b": box()}), **{"C:\\evil.txt": "x"}), "evil.txt"),
            (lambda: hostile.archive({f"{k}": "" for k in range(3000)}), "3,000 members"),
            (lambda: hostile.archive({"k" * 60000 + str(k): "" for k in range(20)}), "far too many"),
            (lambda: hostile.archive({"readme.txt": "no model"}), "lacks _rels/.rels"),
            (lambda: hostile.archive({"_rels/.rels": hostile.RELATIONSHIPS}), "lacks 3D/3dmodel.model"),
            (lambda: package(hostile.archive({"x": "nested"})), "no valid 3MF model"),
            (lambda: package("<model"), "no valid 3MF model"),
            (lambda: package(f'<model xmlns="{hostile.CORE}"/>'), "no facets"),
            (lambda: three_mf(box(), transform="1 0 0 0 1 0 0 0 0 0 0 0"), "no inverse"),
            (lambda: three_mf(box(), transform="1 0 0"), "no valid 3MF model"),
            (lambda: package(hostile.model_xml({"b": box()}).replace('v3="7"', 'v3="8"')), "damaged"),
            (lambda: package(hostile.model_xml({"b": box()}).replace('objectid="1"', 'objectid="9"')), "'9'"),
            (lambda: package(hostile.model_xml({"b": box()}).replace(' z="', ' w="')), "damaged"),
        ],
    )
    def test_damaged_and_hostile_archives(self, tmp_path: Path, make, says: str) -> None:
        assert says in reason(write(tmp_path, "part.3mf", make()))
        assert [path.name for path in tmp_path.iterdir()] == ["part.3mf"]

    def test_an_external_entity_is_not_fetched(self, tmp_path: Path) -> None:
        secret = write(tmp_path, "secret.txt", b"secret")
        assert "secret" not in reason(write(tmp_path, "part.3mf", hostile.external_entity(secret)))

    def test_encryption_and_foreign_packing(self, tmp_path: Path) -> None:
        content = bytearray(three_mf(box()))
        for mark, offset in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
            start = -1
            while (start := content.find(mark, start + 1)) >= 0:
                content[start + offset] |= 1
        assert "encrypted" in reason(write(tmp_path, "part.3mf", bytes(content)))
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w", zipfile.ZIP_LZMA) as target:
            target.writestr("_rels/.rels", hostile.RELATIONSHIPS)
        assert "not allow" in reason(write(tmp_path, "part.3mf", stream.getvalue()))

    def test_two_members_of_one_name(self, tmp_path: Path) -> None:
        content = package(hostile.model_xml({"a": box()}), **{"3D/3dmodel.modeX": "other"})
        content = content.replace(b"3D/3dmodel.modeX", b"3D/3dmodel.model")
        assert "same name" in reason(write(tmp_path, "part.3mf", content))


MEASURE = """
import resource, sys
from pathlib import Path
import gomboc_cad.solid.part_reading as reading
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
try:
    reading.read_part(Path(sys.argv[1]))
except reading.InspectionError:
    pass
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


@pytest.mark.parametrize(
    ("name", "make"),
    [
        ("part.3mf", hostile.zip_bomb),
        ("part.3mf", hostile.entity_bomb),
        ("part.3mf", lambda: hostile.doubling_components(30)),
        ("part.stl", lambda: hostile.declared_stl(4_000_000_000)),
        ("part.ply", lambda: hostile.ply_header("binary_little_endian", 10**12, 10**12)),
        ("part.stl", lambda: b"solid x\n" + b"facet " * 2_000_000),
        ("part.obj", lambda: b"v 0 0 0\n" + b"f" + b" 1" * 8_000_000),
    ],
)
def test_hostile_files_take_little_memory(tmp_path: Path, name: str, make) -> None:
    path = write(tmp_path, name, make())
    command = [sys.executable, "-c", MEASURE, str(path)]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    kilobytes = int(done.stdout) if sys.platform == "linux" else int(done.stdout) // 1024
    assert kilobytes < 200_000


@pytest.mark.parametrize("kind", hostile.WRITERS)
def test_damage_anywhere_is_an_error_or_a_record(tmp_path_factory: pytest.TempPathFactory, kind: str) -> None:
    suffix, writer = hostile.WRITERS[kind]
    content = writer(box())
    path = tmp_path_factory.mktemp("fuzz") / f"part{suffix}"

    @given(st.data())
    @settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
    def damage(data: st.DataObject) -> None:
        damaged = bytearray(content)
        places = st.integers(0, len(content) - 1)
        for place, value in data.draw(st.lists(st.tuples(places, st.integers(0, 255)), max_size=5)):
            damaged[place] = value
        del damaged[data.draw(st.integers(len(content) // 3, len(content))) :]
        path.write_bytes(bytes(damaged))
        part = None
        with contextlib.suppress(GombocError):
            part = read_part(path)
        if part is not None:
            assert np.isfinite(part.mesh.vertices_mm).all()
            assert (part.volume_mm3 is None) == bool(part.faults)
            assert part.volume_mm3 is None or part.volume_mm3 > 0.0

    damage()
