"""The mesh census: by definition, invariances, persistence, resolution, errors."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.stats import special_ortho_group

from gomboc_cad.body import catalog
from gomboc_cad.body.sphere import fibonacci_directions, geodesic_triangulation
from gomboc_cad.equilibria import Census, mesh_census, smooth_census
from gomboc_cad.equilibria.hull import convex_polyhedron
from gomboc_cad.errors import CensusError
from tests.equilibria.polyhedra import (
    Array,
    Counts,
    Mesh,
    equilibria_by_definition,
    hull_mesh,
    platonic,
    prism,
)


def raw(census: Census) -> Counts:
    assert census.mesh is not None
    return Counts(census.mesh.raw_stable, census.mesh.raw_saddles, census.mesh.raw_unstable)


def counts(census: Census) -> Counts:
    return Counts(census.stable, census.saddles, census.unstable)


def sphere_mesh(level: int, scale: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Mesh:
    directions, faces = geodesic_triangulation(level)
    return Mesh(directions * np.array(scale), faces)


def body_mesh(name: str, level: int) -> Mesh:
    directions, faces = geodesic_triangulation(level)
    return Mesh(catalog()[name].position_mm(directions), faces)


def gridded_cube(steps: int) -> Array:
    """Points on the faces of a cube, many in each plane and on each edge."""
    line = np.linspace(-1.0, 1.0, steps)
    u, v = (grid.ravel() for grid in np.meshgrid(line, line))
    sheets = [
        np.insert(np.stack([u, v], axis=1), axis, side, axis=1) for axis in range(3) for side in (-1, 1)
    ]
    return np.concatenate(sheets)


@given(seed=st.integers(0, 2**32 - 1), size=st.integers(4, 30), offset=st.floats(0.0, 0.9))
@settings(max_examples=80, deadline=None)
def test_counts_of_random_polytopes_agree_with_the_definition(seed: int, size: int, offset: float) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(size, 3))
    mesh = hull_mesh(points)
    weights = rng.dirichlet(np.ones(size))
    com = (1.0 - offset) * points.mean(axis=0) + offset * weights @ points
    polyhedron = convex_polyhedron(points)
    assume(polyhedron.face_count == len(mesh.faces))
    found = raw(mesh_census(*mesh, com, barrier_mm=0.0, probabilities=False))
    assert found == equilibria_by_definition(points, com)
    assert found.stable - found.saddles + found.unstable == 2


def test_every_equilibrium_counts_where_no_barrier_is_asked_for() -> None:
    points = np.random.default_rng(4).normal(size=(12, 3))
    census = mesh_census(*hull_mesh(points), points.mean(axis=0), barrier_mm=0.0)
    assert counts(census) == raw(census)


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("turned", [False, True])
def test_a_cube_has_six_faces_however_it_is_meshed(turned: bool, single: bool) -> None:
    points = gridded_cube(40)
    if turned:
        points = points @ special_ortho_group.rvs(3, random_state=3)
    if single:
        points = points.astype(np.float32).astype(float)
    census = mesh_census(*hull_mesh(points), (0.0, 0.0, 0.0))
    assert census.mesh is not None
    assert census.mesh.facets == 6
    assert raw(census) == (6, 12, 8)
    assert counts(census) == (6, 12, 8)


def test_a_foot_exactly_on_an_edge_is_said_to_be_neutral_and_counted_consistently() -> None:
    """The COM over the edge of the upper step: all ties are broken by one infinitesimal move."""
    points = platonic(6)
    census = mesh_census(*hull_mesh(points), (0.0, 0.0, 0.5), barrier_mm=0.0)
    assert census.mesh is not None
    assert census.mesh.neutral == 0
    slab = np.concatenate([points, [[3.0, 1.0, -1.0], [3.0, -1.0, -1.0]]])
    tied = mesh_census(*hull_mesh(slab), (1.0, 0.0, 0.0), barrier_mm=0.0)
    assert tied.mesh is not None
    assert tied.mesh.neutral > 0
    stable, saddles, unstable = raw(tied)
    assert stable - saddles + unstable == 2


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_rotation_scale_order_and_repeated_vertices_change_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(15, 3)) * (1.0, 1.4, 1.9)
    mesh = hull_mesh(points)
    before = mesh_census(*mesh)
    turn = special_ortho_group.rvs(3, random_state=rng)
    shift, scale = rng.normal(size=3), float(rng.uniform(0.1, 50.0))
    order = rng.permutation(15)
    moved = np.concatenate([points[order], points[order]]) @ turn.T * scale + shift
    place = np.argsort(order)
    faces = np.roll(place[mesh.faces], 1, axis=1)[rng.permutation(len(mesh.faces))]
    after = mesh_census(moved, faces)
    assert counts(after) == counts(before)
    assert raw(after) == raw(before)
    assert after.verdict == before.verdict
    assert after.height_range_mm == pytest.approx(scale * before.height_range_mm, rel=1e-9)
    assert turn @ np.array(before.rest.direction) == pytest.approx(after.rest.direction, abs=1e-9)
    old = sorted(e.barrier_mm * scale for e in before.equilibria if e.barrier_mm is not None)
    assert sorted(e.barrier_mm for e in after.equilibria if e.barrier_mm is not None) == pytest.approx(old)
    shares = sorted(e.probability for e in before.equilibria if e.probability is not None)
    assert sorted(e.probability for e in after.equilibria if e.probability is not None) == pytest.approx(
        shares, abs=2e-3
    )


def test_the_counts_that_remain_obey_poincare_hopf() -> None:
    for level in (4, 5):
        for name in ("primary", "second", "third"):
            stable, saddles, unstable = counts(mesh_census(*body_mesh(name, level), probabilities=False))
            assert stable - saddles + unstable == 2


def test_a_dent_does_not_matter_but_the_com_does() -> None:
    """The hull decides, so a vertex pushed in changes nothing about the same COM."""
    mesh = sphere_mesh(3, (1.0, 1.2, 1.5))
    com = (0.01, 0.02, -0.03)
    dented = mesh.vertices.copy()
    dented[::7] *= 0.5
    kept = np.delete(mesh.vertices, np.s_[::7], axis=0)
    found, plain = mesh_census(dented, mesh.faces, com), mesh_census(*hull_mesh(kept), com)
    assert raw(found) == raw(plain)
    for one, other in zip(found.equilibria, plain.equilibria, strict=True):
        assert one.direction == pytest.approx(other.direction, abs=1e-12)
        assert one.height_mm == pytest.approx(other.height_mm, rel=1e-12)


def test_an_ellipsoid_has_the_barriers_between_its_axes() -> None:
    """From the shortest axis a the COM rises to the middle one b; from the top c it sinks to b."""
    census = mesh_census(*sphere_mesh(6, (1.0, 1.5, 2.0)))
    assert counts(census) == (2, 2, 2)
    assert census.mesh is not None
    for pose in census.equilibria:
        if pose.kind == "stable":
            assert pose.barrier_mm == pytest.approx(0.5, abs=2.0 * census.mesh.sag_mm)
            assert pose.probability == pytest.approx(0.5, abs=5e-3)
        if pose.kind == "unstable":
            assert pose.barrier_mm == pytest.approx(0.5, abs=2.0 * census.mesh.sag_mm)


@pytest.mark.parametrize(
    ("scale", "stable", "unstable"),
    [
        ((1.0, 1.0, 2.0), "ring", "point"),
        ((2.0, 2.0, 1.0), "point", "ring"),
        ((1.0, 1.0, 1.0), "sphere", "sphere"),
    ],
)
def test_neutral_rings_and_spheres_are_named(
    scale: tuple[float, float, float], stable: str, unstable: str
) -> None:
    census = mesh_census(*sphere_mesh(5, scale))
    assert {e.extent for e in census.equilibria if e.kind == "stable"} == {stable}
    assert {e.extent for e in census.equilibria if e.kind == "unstable"} == {unstable}
    assert census.verdict == ("multistable" if stable == "point" else "undecided")
    assert stable == "point" or "neutrally" in census.reason


def test_the_resolution_decides_what_a_verdict_claims() -> None:
    """The second body of arXiv 2604.17095 has two rests that a coarse mesh cannot tell from facets."""
    coarse = mesh_census(*body_mesh("second", 4))
    fine = mesh_census(*body_mesh("second", 6), probabilities=False)
    assert (coarse.verdict, fine.verdict) == ("undecided", "multistable")
    assert "finer mesh" in coarse.reason
    assert coarse.mesh is not None
    assert fine.mesh is not None
    assert fine.mesh.sag_mm < 0.1 * coarse.mesh.sag_mm
    assert fine.mesh.lowest_counted_mm is not None
    assert fine.mesh.lowest_counted_mm > fine.mesh.barrier_mm


def test_a_basin_near_the_barrier_is_undecided() -> None:
    mesh = body_mesh("second", 6)
    plain = mesh_census(*mesh, probabilities=False)
    assert plain.mesh is not None
    assert plain.mesh.lowest_counted_mm is not None
    just_over = plain.mesh.lowest_counted_mm + 0.2 * plain.mesh.sag_mm
    assert mesh_census(*mesh, barrier_mm=just_over).verdict == "undecided"
    far_over = plain.mesh.lowest_counted_mm + 2.0 * plain.mesh.sag_mm
    assert mesh_census(*mesh, barrier_mm=far_over).verdict == "monostable"


def test_spurious_basins_are_counted_apart_and_located() -> None:
    census = mesh_census(*body_mesh("primary", 5))
    assert census.mesh is not None
    assert census.mesh.raw_stable > 1000
    assert census.mesh.highest_uncounted_mm is not None
    assert census.mesh.highest_uncounted_mm < 0.5 * census.mesh.sag_mm
    assert len(census.mesh.uncounted_directions) == 10
    assert np.linalg.norm(census.mesh.uncounted_directions, axis=1) == pytest.approx(1.0)


def test_mesh_and_smooth_census_give_the_same_record() -> None:
    body = catalog()["primary"]
    smooth, mesh = smooth_census(body), mesh_census(*body_mesh("primary", 6))
    assert type(mesh) is type(smooth)
    assert counts(mesh) == counts(smooth) == (1, 0, 1)
    assert mesh.verdict == smooth.verdict == "monostable"
    assert mesh.com_mm == pytest.approx(smooth.com_mm, abs=1e-3)
    assert mesh.height_range_mm == pytest.approx(smooth.height_range_mm, abs=2e-2)


def test_the_estimated_sag_is_that_of_the_mesh() -> None:
    """A sphere's facet of circumradius ρ has a sag of R − sqrt(R² − ρ²)."""
    mesh = sphere_mesh(5)
    centers = mesh.vertices[mesh.faces].mean(axis=1)
    true = 1.0 - np.linalg.norm(centers, axis=1).min()
    census = mesh_census(*mesh)
    assert census.mesh is not None
    assert true < census.mesh.sag_mm < 1.5 * true


def test_a_given_sag_of_zero_means_that_the_facets_are_real() -> None:
    mesh = hull_mesh(prism(40, 3.0))
    assert mesh_census(*mesh).stable == 3
    real = mesh_census(*mesh, sag_mm=0.0)
    assert (real.stable, real.verdict) == (42, "multistable")


def test_poses_come_with_the_lowest_first_and_probabilities_that_sum_to_one() -> None:
    points = np.random.default_rng(8).normal(size=(14, 3))
    census = mesh_census(*hull_mesh(points))
    poses = [e for e in census.equilibria if e.kind == "stable"]
    assert [e.height_mm for e in poses] == sorted(e.height_mm for e in poses)
    assert census.rest.direction == poses[0].direction
    assert sum(e.probability for e in poses if e.probability is not None) == pytest.approx(1.0)


def test_probabilities_that_the_roughness_decides_are_not_given() -> None:
    """The rests of the second body are joined by a valley so level that its facets stop the motion."""
    poses = [e for e in mesh_census(*body_mesh("second", 6)).equilibria if e.kind == "stable"]
    assert all(pose.probability is None for pose in poses)
    assert all(pose.probability_error is not None and pose.probability_error > 0.1 for pose in poses)


@pytest.mark.parametrize(
    ("vertices", "faces", "options", "words"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3), dtype=int), {}, "no triangles"),
        (np.eye(3), np.array([[0, 1, 5]]), {"com": (0, 0, 0)}, "does not exist"),
        (np.eye(3), np.array([[0, 1, 2]]), {"com": (0, 0, 0)}, "at least four"),
        (np.eye(3), np.array([[0, 1, 2]]), {}, "not closed"),
        (np.eye(3)[:, :2], np.array([[0, 1, 2]]), {}, "shape"),
        (prism(8, 0.0), np.arange(15).reshape(5, 3), {"com": (0, 0, 0)}, "flat"),
        (np.full((4, 3), np.nan), np.array([[0, 1, 2], [1, 2, 3]]), {"com": (0, 0, 0)}, "not numbers"),
        (*hull_mesh(platonic(6)), {"com": (3.0, 0.0, 0.0)}, "outside the convex hull"),
        (*hull_mesh(platonic(6)), {"com": (np.inf, 0.0, 0.0)}, "three finite numbers"),
        (*hull_mesh(platonic(6)), {"barrier_mm": -1.0}, "zero or more"),
        (*hull_mesh(platonic(6)), {"sag_mm": np.nan}, "zero or more"),
    ],
)
def test_errors_say_what_to_do(vertices: Array, faces: Array, options: dict, words: str) -> None:
    with pytest.raises(CensusError, match=words):
        mesh_census(vertices, faces, **options)


def test_a_mesh_that_is_inside_out_is_refused_without_a_com() -> None:
    mesh = hull_mesh(platonic(6))
    with pytest.raises(CensusError, match="inside out"):
        mesh_census(mesh.vertices, mesh.faces[:, ::-1])
    assert mesh_census(mesh.vertices, mesh.faces[:, ::-1], (0.0, 0.0, 0.0)).stable == 6


@pytest.mark.parametrize("apart", [1e-6, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-15])
def test_nearly_equal_vertices_do_not_confuse_it(apart: float) -> None:
    rng = np.random.default_rng(7)
    for points, rests in ((fibonacci_directions(1500) * (1.0, 1.5, 2.0), 2), (prism(6, 2.0), 8)):
        twice = np.concatenate([points, points + rng.uniform(-apart, apart, points.shape)]) * 37.3 + 5.0
        index = np.arange(len(twice))
        faces = np.stack([index, np.roll(index, 1), np.roll(index, 2)], axis=1)
        assert mesh_census(twice, faces, (5.0, 5.0, 5.0), probabilities=False).stable == rests


def test_a_part_with_thousands_of_coplanar_points_is_quick_work() -> None:
    """Qhull alone needs quadratic time for a face with so many corners."""
    census = mesh_census(*_capped(20_000), sag_mm=0.0, barrier_mm=1e-3)
    assert census.mesh is not None
    assert census.mesh.facets == 20_002


def _capped(sides: int) -> Mesh:
    """A prism meshed without a hull: side strips and fans from the middles of the caps."""
    ring = prism(sides, 2.0)
    points = np.concatenate([ring, [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]])
    low = np.arange(sides)
    nxt, top, bottom = np.roll(low, -1), 2 * sides + 1, 2 * sides
    quads = [[low, nxt, nxt + sides], [low, nxt + sides, low + sides]]
    caps = [[nxt, low, np.full(sides, bottom)], [low + sides, nxt + sides, np.full(sides, top)]]
    return Mesh(points, np.concatenate([np.stack(corner, axis=1) for corner in quads + caps]))
