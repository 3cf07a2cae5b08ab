"""From any part file to its verdict: closed forms, our own bodies, and files that have to be refused."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from pathlib import Path

import build123d as bd
import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import gomboc_cad
from gomboc_cad.body.sphere import fibonacci_directions
from gomboc_cad.errors import CensusError, GombocError, InspectionError
from gomboc_cad.solid.check import PartCheck, check_part
from gomboc_cad.solid.export import NamedMesh, NamedSolid, write_3mf, write_step, write_stl
from gomboc_cad.solid.mesh import Mesh, body_mesh
from gomboc_cad.solid.patches import body_solid
from gomboc_cad.solid.step_census import load_step_part, sampler_of
from tests.solid import hostile
from tests.solid.hostile import box, together, write


def step(folder: Path, *solids: bd.Shape, name: str = "part.step") -> Path:
    parts = [NamedSolid(f"part {k + 1}", solid) for k, solid in enumerate(solids)]
    write_step(folder / name, parts, "test")
    return folder / name


@pytest.fixture
def untried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the trial in another process, which takes seconds to load; these files are OCCT's own."""
    monkeypatch.setattr("gomboc_cad.solid.step_census.try_step", lambda _path, _name: None)


def stable(found: PartCheck) -> list[tuple[float, float | None]]:
    """Heights and barriers of the stable poses."""
    return sorted((e.height_mm, e.barrier_mm) for e in found.census.equilibria if e.kind == "stable")


def assert_rests_like_the_box(found: PartCheck) -> None:
    """A box a < b < c rests on six faces; the way over the edge to the lower neighbour is the barrier."""
    a, b, c = 5.0, 10.0, 15.0
    over_ab, over_ac = math.hypot(a, b), math.hypot(a, c)
    expected = [(a, over_ab - a)] * 2 + [(b, over_ab - b)] * 2 + [(c, over_ac - c)] * 2
    assert found.census.verdict == "multistable"
    assert found.volume_mm3 == pytest.approx(6000.0, rel=1e-6)
    assert found.com_mm == pytest.approx((a, b, c), rel=1e-6)
    assert np.array(stable(found)) == pytest.approx(np.array(expected), rel=1e-5)
    assert sum(e.probability or 0.0 for e in found.census.equilibria) == pytest.approx(1.0)


@pytest.mark.parametrize("kind", hostile.WRITERS)
def test_a_box_in_every_mesh_format(tmp_path: Path, kind: str) -> None:
    suffix, writer = hostile.WRITERS[kind]
    found = check_part(write(tmp_path, f"box{suffix}", writer(box())))
    assert_rests_like_the_box(found)
    assert (found.watertight, found.facets, found.com_given) == (True, 12, False)
    assert found.size_mm == pytest.approx((10.0, 20.0, 30.0))


def test_a_box_in_step(tmp_path: Path) -> None:
    found = check_part(step(tmp_path, bd.Solid.make_box(10, 20, 30)))
    assert_rests_like_the_box(found)
    assert found.census.mesh.sag_mm == 0.0
    assert (found.unit, found.facets, found.notes) == ("mm", None, ())


def test_turning_a_part_changes_nothing(tmp_path: Path) -> None:
    turned = Mesh(box().vertices_mm @ Rotation.random(rng=7).as_matrix().T, box().faces)
    found = check_part(write(tmp_path, "box.obj", hostile.obj(turned)))
    straight = check_part(write(tmp_path, "box.ply", hostile.text_ply(box())))
    assert np.array(stable(found)) == pytest.approx(np.array(stable(straight)))


@pytest.mark.parametrize("unit", ["INCH", "CENTI"])
def test_step_files_in_other_units(tmp_path: Path, unit: str) -> None:
    path = step(tmp_path, bd.Solid.make_box(10, 20, 30))
    text = path.read_text(encoding="ascii")
    millimetre = "SI_UNIT(.MILLI.,.METRE.)"
    assert text.count(millimetre) == 1
    if unit == "CENTI":
        text, scale, short = text.replace(millimetre, "SI_UNIT(.CENTI.,.METRE.)"), 10.0, "cm"
    else:
        number, _, rest = text[: text.index(millimetre)].rpartition("#")[2].partition("=")
        assert "LENGTH_UNIT" in rest
        line = text[text.rindex("#" + number, 0, text.index(millimetre)) :].split(";")[0]
        inch = (
            f"#{number.strip()} = ( CONVERSION_BASED_UNIT('INCH',#90001) LENGTH_UNIT() "
            "NAMED_UNIT(#90003) );\n#90001 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#90002);\n"
            f"#90002 = ( LENGTH_UNIT() NAMED_UNIT(*) {millimetre} );\n"
            "#90003 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)"
        )
        text, scale, short = text.replace(line, inch), 25.4, "in"
    path.write_text(text, encoding="ascii")
    found = load_step_part(path)
    assert found.extent_mm == pytest.approx((10.0 * scale, 20.0 * scale, 30.0 * scale))
    assert found.mass.volume_mm3 == pytest.approx(6000.0 * scale**3)
    assert found.unit == short
    assert short in found.notes[0]
    with pytest.raises(InspectionError, match="leave --unit out"):
        load_step_part(path, unit="mm")
    assert load_step_part(path, unit=short).mass == found.mass


@pytest.mark.usefixtures("untried")
def test_a_hemisphere_rests_on_its_flat_and_on_its_pole(tmp_path: Path) -> None:
    # Radius r, COM 3/8 r from the flat: heights 3/8 r and 5/8 r; the pass is over the rim.
    over_rim = math.hypot(20.0, 7.5)
    ball = bd.Solid.make_sphere(20.0, angle1=0)
    found = check_part(step(tmp_path, ball))
    assert found.census.verdict == "multistable"
    assert found.com_mm == pytest.approx((0.0, 0.0, 7.5), abs=1e-6)
    sag = found.census.mesh.sag_mm
    assert stable(found)[0][0] == pytest.approx(7.5, abs=1e-6)
    assert np.array(stable(found)) == pytest.approx(
        np.array([(7.5, over_rim - 7.5), (12.5, over_rim - 12.5)]), abs=2 * sag
    )


@pytest.mark.usefixtures("untried")
@pytest.mark.slow
def test_a_sphere_rests_everywhere_until_it_is_ballasted(tmp_path: Path) -> None:
    path = step(tmp_path, bd.Solid.make_sphere(25.0))
    assert check_part(path).census.verdict == "undecided"
    found = check_part(path, com_mm=(0.0, 0.0, -2.0))
    assert found.census.verdict == "monostable"
    assert found.com_given
    assert found.centroid_mm == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    assert found.census.rest.height_mm == pytest.approx(23.0, abs=2 * found.census.mesh.sag_mm)
    assert found.census.rest.direction[2] < -0.99


def test_our_body_in_step_and_stl_is_monostable(tmp_path: Path) -> None:
    body = gomboc_cad.catalog()["primary"]
    write_stl(tmp_path / "body.stl", body_mesh(body, 5.0), "primary")
    for path in (step(tmp_path, body_solid(body)), tmp_path / "body.stl"):
        found = check_part(path)
        assert found.census.verdict == "monostable"
        assert found.com_mm == pytest.approx((-0.134778, 0.0, 0.0), abs=2e-4)
        # The rest turns by 3.3 degrees for 10 µm, so a mesh knows it to some degrees only.
        assert found.census.rest.direction[0] < -0.99


@pytest.mark.usefixtures("untried")
@pytest.mark.slow
@pytest.mark.parametrize(("name", "rests"), [("second", 2), ("third", 4)])
def test_the_dented_bodies_of_the_paper_are_multistable(tmp_path: Path, name: str, rests: int) -> None:
    path = step(tmp_path, body_solid(gomboc_cad.catalog()[name]))
    found = check_part(path)
    assert found.census.verdict == "multistable"
    assert found.census.stable == rests
    barriers = [barrier for _, barrier in stable(found)]
    # Half-turn symmetry pairs them; each is some hundredths of a millimetre on 100 mm.
    assert 0.02 < min(barriers) <= max(barriers) < 0.06


@pytest.mark.usefixtures("untried")
@pytest.mark.slow
def test_a_dented_body_has_one_rest_for_whom_its_barriers_do_not_count(tmp_path: Path) -> None:
    path = step(tmp_path, body_solid(gomboc_cad.catalog()["second"]))
    found = check_part(path, barrier_um=200.0)
    assert found.census.verdict == "monostable"
    assert 0.02 < found.census.mesh.highest_uncounted_mm < 0.06


@pytest.mark.usefixtures("untried")
def test_a_cavity_and_a_hole_move_the_com_of_a_step_part(tmp_path: Path) -> None:
    solid = (bd.Solid.make_box(40, 40, 40) - bd.Pos(20, 20, 30) * bd.Solid.make_sphere(8)).solids()[0]
    found = check_part(step(tmp_path, solid))
    missing = 4.0 / 3.0 * math.pi * 8.0**3
    volume = 40.0**3 - missing
    assert found.volume_mm3 == pytest.approx(volume, rel=1e-6)
    assert found.com_mm[2] == pytest.approx((20.0 * 40.0**3 - 30.0 * missing) / volume, rel=1e-6)
    assert found.census.mass_properties.volume_mm3 == found.volume_mm3
    assert found.census.stable == 6


@pytest.mark.parametrize("sag_over_size", [2e-3, 5e-4])
def test_sampled_points_keep_their_sag(tmp_path: Path, sag_over_size: float) -> None:
    directions = fibonacci_directions(5000)
    around, up = np.linalg.norm(directions[:, :2], axis=1), directions[:, 2]
    # Support functions of a torus, of a cone cut off, and of a ball with a well at its top.
    rim = np.where(up > 0.8, 12.0 * around + 16.0 * up, 20.0)
    for solid, support in (
        (bd.Solid.make_torus(30.0, 10.0), 30.0 * around + 10.0),
        (bd.Solid.make_cone(20.0, 5.0, 40.0), np.maximum(20.0 * around, 5.0 * around + 40.0 * up)),
        ((bd.Solid.make_sphere(20.0) - bd.Solid.make_cylinder(12.0, 30.0)).solids()[0], rim),
    ):
        sampler = sampler_of(load_step_part(step(tmp_path, solid)))
        points = sampler.sample(sag_over_size * sampler.size_mm)
        assert 0.0 < points.sag_mm <= sag_over_size * sampler.size_mm
        short = support - (points.points_mm @ directions.T).max(axis=0)
        assert short.max() <= points.sag_mm
        assert short.min() >= -1e-6


@pytest.mark.parametrize("given", [(1.0, 2.0), (1.0, 2.0, math.nan), ()])
def test_a_com_that_is_no_point_is_refused(tmp_path: Path, given: Sequence[float]) -> None:
    path = write(tmp_path, "box.stl", hostile.binary_stl(box()))
    with pytest.raises(InspectionError, match="three numbers"):
        check_part(path, com_mm=given)


@pytest.mark.parametrize("barrier", [-1.0, math.inf, math.nan])
def test_a_barrier_that_is_no_length_is_refused(tmp_path: Path, barrier: float) -> None:
    path = write(tmp_path, "box.stl", hostile.binary_stl(box()))
    with pytest.raises(InspectionError, match="barrier"):
        check_part(path, barrier_um=barrier)


def test_a_barrier_decides_which_poses_count(tmp_path: Path) -> None:
    path = write(tmp_path, "box.stl", hostile.binary_stl(box()))
    assert [check_part(path, barrier_um=b).census.stable for b in (500.0, 1000.0, 2000.0)] == [6, 4, 2]


@pytest.mark.usefixtures("untried")
def test_a_com_outside_is_refused(tmp_path: Path) -> None:
    for path in (
        write(tmp_path, "box.stl", hostile.binary_stl(box())),
        step(tmp_path, bd.Solid.make_box(10, 20, 30)),
    ):
        with pytest.raises(CensusError, match="outside"):
            check_part(path, com_mm=(5.0, 10.0, 31.0))


@pytest.mark.parametrize(
    ("mesh", "says"),
    [
        (Mesh(box().vertices_mm, box().faces[1:]), "not watertight: 3 edges"),
        (together(box(), box(low=(3.0, 3.0, 3.0))), "crosses itself"),
        (together(box(), box(low=(50.0, 0.0, 0.0))), "2 separate bodies"),
    ],
)
def test_no_solid_no_com_but_a_given_one_helps(tmp_path: Path, mesh: Mesh, says: str) -> None:
    path = write(tmp_path, "part.obj", hostile.obj(mesh))
    with pytest.raises(InspectionError, match=f"{says}.*give --com-mm"):
        check_part(path)
    found = check_part(path, com_mm=(6.0, 11.0, 15.0))
    assert found.volume_mm3 is None
    assert found.centroid_mm is None
    assert found.census.mass_properties is None
    assert any(says in note for note in found.notes)
    hull = ConvexHull(mesh.vertices_mm)
    low = -np.max(hull.equations[:, :3] @ (6.0, 11.0, 15.0) + hull.equations[:, 3])
    assert found.census.rest.height_mm == pytest.approx(low)


def test_holes_do_not_change_the_poses_about_a_given_com(tmp_path: Path) -> None:
    com = (4.0, 11.0, 12.0)
    whole = check_part(write(tmp_path, "whole.obj", hostile.obj(box())), com_mm=com)
    holed = check_part(
        write(tmp_path, "holed.obj", hostile.obj(Mesh(box().vertices_mm, box().faces[1:]))), com_mm=com
    )
    assert whole.watertight
    assert not holed.watertight
    assert stable(whole) == stable(holed)


@pytest.mark.usefixtures("untried")
def test_several_solids_of_a_step_file_are_named(tmp_path: Path) -> None:
    path = step(tmp_path, bd.Solid.make_box(10, 20, 30), bd.Pos(50, 0, 0) * bd.Solid.make_box(1, 1, 1))
    with pytest.raises(InspectionError, match=r"2 solids \(part 1, part 2\).*give --com-mm"):
        check_part(path)
    assert check_part(path, com_mm=(9.0, 8.0, 9.0)).size_mm[0] == pytest.approx(51.0)


def test_a_surface_is_no_solid(tmp_path: Path) -> None:
    with pytest.raises(InspectionError, match="holds no solid"):
        check_part(step(tmp_path, bd.Face.make_rect(10, 10)))


def test_several_parts_of_a_3mf_are_named(tmp_path: Path) -> None:
    write_3mf(tmp_path / "two.3mf", [NamedMesh("left", box()), NamedMesh("right", box(low=(50.0, 0.0, 0.0)))])
    with pytest.raises(InspectionError, match=r"2 parts \(left, right\)"):
        check_part(tmp_path / "two.3mf")


def test_damaged_step_files_are_refused(tmp_path: Path) -> None:
    content = step(tmp_path, bd.Solid.make_box(10, 20, 30)).read_bytes()
    for damaged, says in (
        (content[: len(content) // 2], "not a whole STEP file"),
        (content.replace(b"CARTESIAN_POINT", b"CARTESIAN_POTATO", 3), "damaged|no solid"),
        (content.replace(b"MANIFOLD_SOLID_BREP", b"MANIFOLD_SOLID_BREW"), "damaged|no solid"),
        (content[:400] + b"\0\0\0" + content[403:], "damaged"),
    ):
        with pytest.raises(InspectionError, match=says):
            load_step_part(write(tmp_path, "damaged.step", damaged))
    with pytest.raises(InspectionError, match="rename it"):
        check_part(write(tmp_path, "part.stl", content))


def test_damage_anywhere_in_a_step_file(tmp_path: Path) -> None:
    content = step(tmp_path, bd.Solid.make_box(10, 20, 30)).read_bytes()
    random = np.random.default_rng(3)
    start = content.index(b"DATA;")
    for number in range(2):
        damaged = bytearray(content)
        for place in random.integers(start, len(content), size=2):
            damaged[place] = random.integers(32, 127)
        path = write(tmp_path, f"{number}.step", bytes(damaged))
        try:
            found = check_part(path)
        except GombocError:
            continue
        assert found.volume_mm3 is not None
        assert found.volume_mm3 > 0.0


def test_a_crash_of_the_kernel_is_an_error_in_words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = step(tmp_path, bd.Solid.make_box(10, 20, 30))
    crashing = tmp_path / "python"
    crashing.write_text("#!/bin/sh\nkill -SEGV $$\n", encoding="ascii")
    crashing.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(crashing))
    with pytest.raises(InspectionError, match="crashes on it"):
        check_part(path)


def test_progress_is_told(tmp_path: Path) -> None:
    said: list[str] = []
    check_part(write(tmp_path, "box.stl", hostile.binary_stl(box())), progress=said.append)
    assert said[0] == "reading the file"
    assert said[-1] == "census of the convex hull"
