"""The mesh census against closed forms, theorems and published values.

Each test names its source. Bodies with curved surfaces are meshed, so their heights and barriers hold up to
the sag of the mesh.
"""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.body import catalog, mass_properties
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.equilibria import Census, Equilibrium, mesh_census, smooth_census
from tests.equilibria.polyhedra import Array, Mesh, cone, equilibria_by_definition, hull_mesh, platonic, prism


def stable(census: Census) -> list[Equilibrium]:
    return [e for e in census.equilibria if e.kind == "stable"]


def shares(census: Census) -> list[float]:
    return [e.probability or 0.0 for e in stable(census)]


@pytest.mark.parametrize(
    ("faces", "edges", "vertices"), [(4, 6, 4), (6, 12, 8), (8, 12, 6), (12, 30, 20), (20, 30, 12)]
)
def test_platonic_solids_rest_on_each_face(faces: int, edges: int, vertices: int) -> None:
    """Every face, edge and vertex of a Platonic solid is an equilibrium, by symmetry (Euclid XIII)."""
    census = mesh_census(*hull_mesh(platonic(faces)))
    assert census.mesh is not None
    assert (census.stable, census.saddles, census.unstable) == (faces, edges, vertices)
    assert (census.mesh.raw_stable, census.mesh.raw_saddles, census.mesh.raw_unstable) == (
        faces,
        edges,
        vertices,
    )
    assert shares(census) == pytest.approx([1.0 / faces] * faces, abs=3e-4)


@given(sides=st.tuples(*[st.floats(0.2, 5.0)] * 3))
@settings(max_examples=25, deadline=None)
def test_a_box_rests_on_each_face_with_the_share_of_its_solid_angle(
    sides: tuple[float, float, float],
) -> None:
    """Quasi-static pose statistics of a box: the solid angle of each face from the centre.

    Source: Boothroyd et al., Ann. CIRP 21 (1972) 189, and Goldberg et al., IJRR 18 (1999) 1: a part that is
    released without speed ends on the face that its centre of mass is over. The face of sides b, c at the
    distance a subtends 4 arctan(b c / (a sqrt(a² + b² + c²))), all halved.
    """
    half = np.array(sides)
    census = mesh_census(*hull_mesh(platonic(6) * half))
    assert census.stable == 6
    for pose in stable(census):
        axis = int(np.argmax(np.abs(pose.direction)))
        a, (b, c) = half[axis], np.delete(half, axis)
        assert pose.height_mm == pytest.approx(a)
        assert pose.barrier_mm == pytest.approx(np.hypot(a, min(b, c)) - a)
        angle = 4.0 * np.arctan(b * c / (a * np.sqrt(half @ half)))
        assert pose.probability == pytest.approx(angle / (4.0 * np.pi), abs=3e-4)


@pytest.mark.parametrize("shape", [platonic(6) * (1.0, 1.3, 2.1), prism(5, 1.2), prism(3, 2.0), platonic(12)])
def test_pose_probabilities_agree_with_trimesh_where_every_face_is_stable(shape: Array) -> None:
    """An independent computation of the same quasi-static model, right where every face is stable."""
    mesh = hull_mesh(shape)
    census = mesh_census(*mesh)
    _, theirs = trimesh.Trimesh(*mesh).compute_stable_poses()
    assert sorted(shares(census)) == pytest.approx(sorted(theirs), abs=5e-4)


@pytest.mark.parametrize(("sides", "height"), [(3, 0.5), (5, 2.0), (7, 1.0)])
def test_prisms_rest_on_their_ends_and_sides(sides: int, height: float) -> None:
    """A regular n-gon prism of circumradius ρ: n + 2 rests; the climb over a side edge is ρ (1 − cos π/n)."""
    census = mesh_census(*hull_mesh(prism(sides, height)))
    assert (census.stable, census.saddles, census.unstable) == (sides + 2, 3 * sides, 2 * sides)
    inradius = np.cos(np.pi / sides)
    side_poses = [pose for pose in stable(census) if abs(pose.direction[2]) < 0.5]
    over_the_end = np.hypot(inradius, height / 2.0)
    for pose in side_poses:
        assert pose.barrier_mm == pytest.approx(min(1.0, over_the_end) - inradius)


@pytest.mark.parametrize("axes", [(1.0, 1.1, 1.2), (1.0, 2.0, 3.0), (1.0, 1.02, 1.5)])
def test_a_triaxial_ellipsoid_has_two_of_each(axes: tuple[float, float, float]) -> None:
    """(2, 2, 2) by Archimedes' argument in each principal plane; the source paper reads 1 and 3."""
    directions, faces = geodesic_triangulation(5)
    census = mesh_census(directions * axes, faces, probabilities=False)
    assert (census.stable, census.saddles, census.unstable) == (2, 2, 2)
    assert census.verdict == "multistable"


def test_a_cone_rests_on_its_base_and_in_a_ring_on_its_side() -> None:
    """COM at a quarter of the height h; the side lies at 3 h r / (4 s), s the slant; the rim is the pass."""
    radius, height = 1.0, 2.0
    slant, rim = np.hypot(radius, height), np.hypot(radius, height / 4.0)
    census = mesh_census(*hull_mesh(cone(200, radius, height)), probabilities=False)
    side, base = sorted(stable(census), key=lambda pose: pose.extent == "point")
    assert (side.extent, base.extent) == ("ring", "point")
    assert base.height_mm == pytest.approx(height / 4.0, rel=1e-3)
    assert base.barrier_mm == pytest.approx(rim - height / 4.0, rel=2e-3)
    assert side.height_mm == pytest.approx(0.75 * height * radius / slant, rel=1e-3)
    assert side.barrier_mm == pytest.approx(rim - 0.75 * height * radius / slant, rel=2e-2)


def test_a_half_ball_rests_on_its_dome_and_on_its_face() -> None:
    """COM at 3/8 R from the face; heights 5/8 R and 3/8 R, the rim at sqrt(1 + 9/64) R between them."""
    directions, _ = geodesic_triangulation(5)
    circle = prism(160, 0.0)[:160]
    census = mesh_census(*hull_mesh(np.concatenate([directions[directions[:, 2] < -1e-9], circle])))
    face, dome = stable(census)
    rim = np.sqrt(1.0 + 9.0 / 64.0)
    assert (face.height_mm, dome.height_mm) == pytest.approx((3.0 / 8.0, 5.0 / 8.0), abs=2e-3)
    assert (face.barrier_mm, dome.barrier_mm) == pytest.approx((rim - 3.0 / 8.0, rim - 5.0 / 8.0), abs=2e-3)
    assert {e.extent for e in census.equilibria if e.kind == "unstable"} == {"ring"}


@pytest.mark.parametrize("lowered", [0.05, 0.1, 0.5])
def test_a_loaded_sphere_is_monostable(lowered: float) -> None:
    """A ball with its COM lowered by s rests there, its height varying by 2 s."""
    directions, faces = geodesic_triangulation(5)
    census = mesh_census(directions, faces, (0.0, 0.0, -lowered))
    assert (census.verdict, census.stable, census.unstable) == ("monostable", 1, 1)
    assert census.rest.direction == pytest.approx((0.0, 0.0, -1.0), abs=0.05)
    assert census.height_range_mm == pytest.approx(2.0 * lowered, abs=1e-3)
    assert [e.barrier_mm for e in census.equilibria] == [census.height_range_mm] * 2


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=150, deadline=None)
def test_no_homogeneous_tetrahedron_is_monostatic(seed: int) -> None:
    """Theorem of Conway: Dawson, Amer. Math. Monthly 92 (1985) 541."""
    points = np.random.default_rng(seed).normal(size=(4, 3))
    census = mesh_census(*hull_mesh(points), barrier_mm=0.0, probabilities=False)
    assert census.mesh is not None
    assert census.mesh.raw_stable >= 2


def test_a_loaded_tetrahedron_can_be_monostatic() -> None:
    """With an uneven mass it can: Almádi, Dawson, Domokos, arXiv 2506.19244. This one was found by trying."""
    points = np.array(
        [(-0.041, -1.221, -0.559), (-0.017, 0.151, 2.583), (0.163, -0.29, 0.078), (-0.358, 0.163, 0.967)]
    )
    com = np.array((-0.3005, -0.0168, 0.7569))
    census = mesh_census(*hull_mesh(points), com)
    assert (census.verdict, census.stable) == ("monostable", 1)
    assert equilibria_by_definition(points, com).stable == 1
    assert mesh_census(*hull_mesh(points)).stable > 1


@pytest.mark.parametrize("level", [4, 5, 6, 7])
def test_sloan_2_is_monostable_on_every_mesh_while_the_raw_count_runs_into_thousands(level: int) -> None:
    """Meshes of 5k, 20k, 80k and 330k facets; the spurious barriers fall with the facets' sag."""
    directions, faces = geodesic_triangulation(level)
    census = mesh_census(catalog()["sloan2-0.030"].position_mm(directions), faces)
    assert census.mesh is not None
    assert (census.verdict, census.stable, census.unstable) == ("monostable", 1, 1)
    assert census.mesh.raw_stable > 1000
    assert census.mesh.highest_uncounted_mm is not None
    assert census.mesh.highest_uncounted_mm < 0.05 * 4.0 ** (4 - level)


@pytest.mark.parametrize(("name", "rests", "barrier"), [("second", 2, 0.00085), ("third", 4, 0.00058)])
def test_the_papers_second_and_third_bodies_are_multistable_on_their_hulls(
    name: str, rests: int, barrier: float
) -> None:
    """arXiv 2604.17095 calls them mono-monostatic; its amendment 2604.17120 v2 retracts it.

    The barriers are about one percent of the range of heights, and the two rests of each pair are equally
    deep, as the half-turn symmetry wants it.
    """
    body = catalog()[name].with_diameter(2.0)
    directions, faces = geodesic_triangulation(6)
    census = mesh_census(
        body.position_mm(directions), faces, mass_properties(body).com_mm, probabilities=False
    )
    assert (census.verdict, census.stable) == ("multistable", rests)
    assert census.mesh is not None
    assert census.mesh.lowest_counted_mm == pytest.approx(barrier, rel=0.05)
    assert 0.003 < census.mesh.lowest_counted_mm / census.height_range_mm < 0.03
    heights = [pose.height_mm for pose in stable(census)]
    assert heights[0::2] == pytest.approx(heights[1::2], abs=1e-6)


def test_the_verdict_does_not_depend_on_the_orientation_of_the_samples() -> None:
    """The source paper's own count of the primary reads 3 to 7 when the same directions are turned."""
    body = catalog()["primary"]
    directions, _ = geodesic_triangulation(4)
    for seed in range(8):
        turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
        census = mesh_census(*hull_mesh(body.position_mm(directions @ turn)), mass_properties(body).com_mm)
        assert (census.verdict, census.stable, census.unstable) == ("monostable", 1, 1)


def test_a_com_inside_the_margin_keeps_the_mesh_census_and_one_beyond_it_changes_it() -> None:
    """Towards the nearest point of the focal surface, where a second rest is born."""
    body = catalog()["primary"]
    smooth = smooth_census(body)
    assert smooth.margin is not None
    com, witness = np.array(smooth.com_mm), np.array(smooth.margin.s_witness_mm)
    directions, faces = geodesic_triangulation(6)
    mesh = Mesh(body.position_mm(directions), faces)
    assert mesh_census(*mesh, com + 0.9 * (witness - com)).verdict == "monostable"
    beyond = mesh_census(*mesh, com + 2.0 * (witness - com), probabilities=False)
    assert (beyond.verdict, beyond.stable) == ("multistable", 2)
