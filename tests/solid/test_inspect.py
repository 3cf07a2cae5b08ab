"""Inspection passes what is right and names what is not, without any foreign exception."""

from __future__ import annotations

import builtins
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gomboc_cad import Body
from gomboc_cad.body.sphere import unit
from gomboc_cad.errors import GombocError, InspectionError
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.export import NamedMesh, NamedSolid, write_3mf, write_step, write_stl
from gomboc_cad.solid.hollow import Cylinder, HollowBody, Mesh, brep, mesh
from gomboc_cad.solid.inspect import Expected, FileInspection, inspect_file
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.mesh import body_mesh
from gomboc_cad.solid.offset import InsetSurface
from gomboc_cad.solid.patches import body_solid, inset_solid, interpolate_patches, patches_solid
from tests.solid.conftest import SAG_UM, Halves


@pytest.fixture
def inspect_changed(
    tmp_path: Path, primary: Body, expected_body: Expected
) -> Callable[[Callable[[Mesh], Mesh]], FileInspection]:
    """Write the body's mesh after a change as STL, and inspect it as if nothing had happened."""

    def inspect(change: Callable[[Mesh], Mesh]) -> FileInspection:
        write_stl(tmp_path / "changed.stl", change(body_mesh(primary, 100.0)), "primary")
        return inspect_file(tmp_path / "changed.stl", [replace(expected_body, distance_um=100.0)])

    return inspect


def only_problem(inspection: FileInspection) -> str:
    (problem,) = inspection.problems
    return problem


def test_step_files_are_right(files: Path, halves: Halves, expected_body: Expected) -> None:
    for name, parts in (("body.step", [expected_body]), ("assembly.step", halves.expected)):
        found = inspect_file(files / name, parts)
        assert found.problems == ()
        assert found.ok
        assert [part.name for part in found.parts] == [part.name for part in parts]
        for part, expected in zip(found.parts, parts, strict=True):
            assert part.watertight
            assert 0.0 < part.distance_um <= 0.1
            assert part.volume_mm3 == pytest.approx(expected.volume_mm3, rel=1e-6)
            assert part.facets is None


def test_mesh_files_are_right(files: Path, halves: Halves, expected_body: Expected) -> None:
    lower, upper = halves.expected_meshes()
    body = replace(expected_body, distance_um=SAG_UM)
    for name, parts in (("body.stl", [body]), ("lower.stl", [lower]), ("halves.3mf", [upper, lower])):
        found = inspect_file(files / name, parts)
        assert found.problems == ()
        assert {part.name for part in found.parts} == {part.name for part in parts}
        for part in found.parts:
            assert part.watertight
            assert 0.2 * SAG_UM < part.distance_um <= SAG_UM
            assert part.facets > 10_000


def test_record_describes_the_file(files: Path, expected_body: Expected) -> None:
    found = inspect_file(files / "body.step", [expected_body])
    assert (found.name, found.kind) == ("body.step", "step")
    assert found.size_bytes == (files / "body.step").stat().st_size
    assert len(found.sha256) == 64


@pytest.mark.usefixtures("pymeshlab")
@pytest.mark.parametrize("name", ["lower.stl", "halves.3mf"])
def test_audit_agrees(files: Path, halves: Halves, name: str) -> None:
    parts = halves.expected_meshes()
    assert inspect_file(files / name, parts[: 1 if name == "lower.stl" else 2], audit=True).problems == ()


@pytest.mark.usefixtures("pymeshlab")
def test_audit_finds_self_intersections(tmp_path: Path, primary: Body) -> None:
    def dented(found: Mesh) -> Mesh:
        vertices = found.vertices_mm.copy()
        vertices[0] *= -1.5
        return Mesh(vertices, found.faces)

    write_stl(tmp_path / "dented.stl", dented(body_mesh(primary, 1000.0)), "primary")
    found = inspect_file(tmp_path / "dented.stl", [], audit=True)
    assert any("self-intersecting facets" in problem for problem in found.problems)


def test_audit_without_pymeshlab_names_the_extra(
    files: Path, expected_body: Expected, monkeypatch: pytest.MonkeyPatch
) -> None:
    real_import = builtins.__import__

    def refuse(name: str, *args, **kwargs):
        if name == "pymeshlab":
            raise ImportError(name)
        return real_import(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(GombocError, match=r"gomboc-cad\[audit\]"):
        inspect_file(files / "body.stl", [expected_body], audit=True)


def test_removed_facets_are_found(inspect_changed) -> None:
    found = inspect_changed(lambda m: Mesh(m.vertices_mm, m.faces[5:]))
    assert "not watertight" in found.problems[0]
    assert not found.parts[0].watertight
    assert found.parts[0].volume_mm3 is None


def test_one_turned_facet_is_found(inspect_changed) -> None:
    def turn(found: Mesh) -> Mesh:
        faces = found.faces.copy()
        faces[7] = faces[7, ::-1]
        return Mesh(found.vertices_mm, faces)

    found = inspect_changed(turn)
    assert "turned over" in found.problems[0]
    assert "manifold3d" in found.problems[1]


def test_a_mesh_turned_inside_out_is_found(inspect_changed) -> None:
    assert "inside out" in inspect_changed(lambda m: Mesh(m.vertices_mm, m.faces[:, ::-1])).problems[0]


@pytest.mark.parametrize("factor", [25.4, 1 / 25.4])
def test_inches_are_recognised(inspect_changed, factor: float) -> None:
    found = inspect_changed(lambda m: Mesh(m.vertices_mm * factor, m.faces))
    assert any("as if inches and millimetres were mixed up" in problem for problem in found.problems)


def test_a_small_scale_error_is_found(inspect_changed) -> None:
    # 20 ppm: 1 µm at the surface, far below the sag.
    found = inspect_changed(lambda m: Mesh(m.vertices_mm * (1 + 2e-5), m.faces))
    assert "its vertices lie 1 µm off the model" in only_problem(found)


def test_a_small_shift_is_found(inspect_changed) -> None:
    shift = np.array([0.005, 0.0, 0.0])
    found = inspect_changed(lambda m: Mesh(m.vertices_mm + shift, m.faces))
    assert "displaced or of another size" in only_problem(found)


def test_a_pulled_vertex_is_found(inspect_changed) -> None:
    def pull(found: Mesh) -> Mesh:
        vertices = found.vertices_mm.copy()
        vertices[100] += 0.3 * unit(vertices[100])
        return Mesh(vertices, found.faces)

    problem = next(p for p in inspect_changed(pull).problems if "surface" in p)
    assert "300 µm away from the model's surface; 100 µm are promised" in problem


def test_a_coarser_mesh_than_promised_is_found(
    tmp_path: Path, primary: Body, expected_body: Expected
) -> None:
    write_stl(tmp_path / "coarse.stl", body_mesh(primary, 100.0), "primary")
    found = inspect_file(tmp_path / "coarse.stl", [replace(expected_body, distance_um=50.0)])
    assert any("50 µm are promised" in problem for problem in found.problems)


def test_a_forgotten_hole_is_found(tmp_path: Path, primary: Body) -> None:
    """Its volume is 0.02 % of the shell's, less than the sag takes away."""
    boss = Cylinder((-60.0, 0.0, 0.0), (1.0, 0.0, 0.0), 4.0, 30.0)
    hole = Cylinder((-36.0, 0.0, 0.0), (1.0, 0.0, 0.0), 1.0, 6.0)
    drilled = HollowBody(primary, 3.0, bosses=(boss,), holes=(hole,))
    mass = solid_mass(brep(drilled))
    expected = Expected("part", mass.volume_mm3, mass.com_mm, 50.0, Boundary.of_hollow(drilled))
    write_stl(tmp_path / "good.stl", mesh(drilled, 50.0), "part")
    assert inspect_file(tmp_path / "good.stl", [expected]).problems == ()
    write_stl(tmp_path / "bad.stl", mesh(HollowBody(primary, 3.0, bosses=(boss,)), 50.0), "part")
    assert "has a volume of" in inspect_file(tmp_path / "bad.stl", [expected]).problems[0]


def test_a_step_file_of_another_wall_is_found(tmp_path: Path, primary: Body, expected_body: Expected) -> None:
    thin = inset_solid(InsetSurface(primary, 0.001))
    write_step(tmp_path / "thin.step", [NamedSolid("primary", thin)], "primary")
    found = inspect_file(tmp_path / "thin.step", [expected_body])
    assert "has a volume of" in found.problems[0]
    assert "1 µm away from the model's surface" in found.problems[-1]


def test_a_coarse_fit_in_a_step_file_is_found(tmp_path: Path, primary: Body, expected_body: Expected) -> None:
    coarse = patches_solid(interpolate_patches(primary.position_mm, 9))
    write_step(tmp_path / "coarse.step", [NamedSolid("primary", coarse)], "primary")
    found = inspect_file(tmp_path / "coarse.step", [expected_body])
    assert any("0.02 µm are promised" in problem for problem in found.problems)


def test_missing_unknown_and_double_parts_are_named(
    tmp_path: Path, primary: Body, expected_body: Expected
) -> None:
    found = body_mesh(primary, 1000.0)
    write_3mf(tmp_path / "a.3mf", [NamedMesh("stranger", found)])
    problems = inspect_file(tmp_path / "a.3mf", [expected_body]).problems
    assert problems == ("a.3mf lacks the part 'primary'.", "a.3mf holds an unknown part 'stranger'.")
    solid = body_solid(primary)
    write_step(tmp_path / "a.step", [NamedSolid("primary", solid), NamedSolid("primary", solid)], "twice")
    assert inspect_file(tmp_path / "a.step", [expected_body]).problems == (
        "a.step holds 'primary' more than once.",
    )


@pytest.mark.parametrize("name", ["body.step", "body.stl", "halves.3mf"])
def test_truncated_files_are_found(
    files: Path, tmp_path: Path, expected_body: Expected, halves: Halves, name: str
) -> None:
    data = (files / name).read_bytes()
    parts = halves.expected_meshes() if name == "halves.3mf" else [expected_body]
    for share in (0.0, 0.3, 0.999):
        (tmp_path / name).write_bytes(data[: int(share * len(data))])
        found = inspect_file(tmp_path / name, parts)
        assert not found.ok
        assert found.parts == ()


def test_step_files_with_chopped_bytes_are_found(
    files: Path, tmp_path: Path, expected_body: Expected
) -> None:
    """Bytes that matter: brackets, references, leading digits. Nothing crashes, nothing leaks."""
    data = (files / "body.step").read_bytes()
    at = data.index(b"B_SPLINE_SURFACE_WITH_KNOTS")
    point = data.index(b"CARTESIAN_POINT", at)
    places = {
        "header": 3,
        "keyword": at + 2,
        "reference": data.index(b"#", at) + 1,
        "hash": data.index(b"#", at),
        "bracket": data.index(b")", at),
        "digit": data.index(b"(", data.index(b"(", point) + 1) + 2,
        "end": len(data) - 5,
    }
    for what, place in places.items():
        (tmp_path / "a.step").write_bytes(data[:place] + data[place + 1 :])
        assert not inspect_file(tmp_path / "a.step", [expected_body]).ok, what


def test_binary_rubbish_in_every_format_is_a_problem(tmp_path: Path, expected_body: Expected) -> None:
    rubbish = np.random.default_rng(3).bytes(5000)
    for suffix in ("step", "stl", "3mf"):
        (tmp_path / f"a.{suffix}").write_bytes(rubbish)
        assert not inspect_file(tmp_path / f"a.{suffix}", [expected_body]).ok


def test_wrong_use_is_an_error_and_no_problem_of_the_file(tmp_path: Path) -> None:
    with pytest.raises(InspectionError, match="none of step, stl, 3mf"):
        inspect_file(tmp_path / "a.obj", [])
    with pytest.raises(InspectionError, match="cannot be read: No such file"):
        inspect_file(tmp_path / "a.stl", [])
