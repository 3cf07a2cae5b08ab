"""The paper's oracle as an algorithm: on landscapes made by hand, and against a slow reading of its text."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from gomboc_cad.body import catalog, mass_properties
from gomboc_cad.body.mass import mesh_mass
from gomboc_cad.body.sphere import fibonacci_directions
from gomboc_cad.equilibria.drainage import (
    Axis,
    Centre,
    DirectionGraph,
    DrainageOptions,
    DrainageResult,
    drain,
    drainage_count,
    random_rotations,
    rotated_counts,
    spiral_directions,
)
from gomboc_cad.equilibria.drainage_shapes import PaperShape, paper_shape, ring_mesh
from gomboc_cad.errors import CensusError, GeometryError
from tests.equilibria.polyhedra import Array, hull_mesh, platonic

PAPER = DrainageOptions.paper()
UP = np.array([0.0, 0.0, 1.0])
GRAPH = DirectionGraph.of(spiral_directions(2000), 12)


def wells(*centres_and_depths: tuple[Array, float]) -> Array:
    """A landscape of parabolic wells, sampled on GRAPH."""
    bowls = [depth + np.sum((GRAPH.directions - centre) ** 2, axis=1) for centre, depth in centres_and_depths]
    return np.min(bowls, axis=0)


def rough_landscape(seed: int, graph: DirectionGraph = GRAPH) -> Array:
    """A sum of a few plane waves: some tens of minima of all depths."""
    rng = np.random.default_rng(seed)
    waves = rng.normal(scale=4.0, size=(6, 3))
    return np.sin(graph.directions @ waves.T + rng.uniform(0.0, 6.0, 6)).sum(axis=1)


def clusters_by_definition(graph: DirectionGraph, heights: Array, fraction: float) -> dict[int, list[int]]:
    """Lowest sink of each cluster and the directions that end there, one step and one sink at a time."""
    ends: dict[int, list[int]] = {}
    for start in range(len(heights)):
        here = start
        while (lowest := min(graph.neighbours[here].tolist(), key=lambda n: heights[n])) != here:
            if heights[lowest] >= heights[here]:
                break
            here = lowest
        ends.setdefault(here, []).append(start)
    merged: dict[int, list[int]] = {}
    for sink in sorted(ends, key=lambda n: heights[n]):
        for floor in merged:
            if heights[sink] - heights[floor] < fraction * (max(heights) - min(heights)):
                merged[floor] += ends[sink]
                break
        else:
            merged[sink] = list(ends[sink])
    return merged


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("fraction", [0.0, 0.01, 0.1])
def test_clusters_are_those_of_the_definition(seed: int, fraction: float) -> None:
    heights = rough_landscape(seed)
    expected = clusters_by_definition(GRAPH, heights, fraction)
    found = drain(GRAPH, heights, replace(PAPER, merge_fraction=fraction))
    assert found.ecs == len(expected) > 1
    assert [c.height_mm for c in found.clusters] == [heights[floor] for floor in expected]
    assert [c.share for c in found.clusters] == pytest.approx([len(d) / 2000 for d in expected.values()])
    np.testing.assert_array_equal([c.direction for c in found.clusters], -GRAPH.directions[list(expected)])


@given(seed=st.integers(0, 10**6), fractions=st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)))
@settings(max_examples=40, deadline=None)
def test_a_larger_threshold_never_leaves_more_clusters(seed: int, fractions: tuple[float, float]) -> None:
    heights = rough_landscape(seed)
    for linkage in ("lowest", "single"):
        few, many = (
            drain(GRAPH, heights, replace(PAPER, merge_fraction=f, linkage=linkage))
            for f in sorted(fractions, reverse=True)
        )
        assert 1 <= few.ecs <= many.ecs <= few.sinks == many.sinks
        assert sum(c.share for c in few.clusters) == pytest.approx(1.0)
        assert sorted(c.height_mm for c in few.clusters) == [c.height_mm for c in few.clusters]


@given(seed=st.integers(0, 10**6), scale=st.floats(0.01, 100.0), lift=st.floats(-50.0, 50.0))
@settings(max_examples=30, deadline=None)
def test_counts_do_not_depend_on_unit_or_zero_of_height(seed: int, scale: float, lift: float) -> None:
    heights = rough_landscape(seed)
    one, other = drain(GRAPH, heights, PAPER), drain(GRAPH, scale * heights + lift, PAPER)
    assert [c.share for c in one.clusters] == [c.share for c in other.clusters]
    for name in ("height_range_mm", "sre_mm", "steepness_mm_per_rad"):
        assert getattr(other, name) == pytest.approx(scale * getattr(one, name), rel=1e-9)


def test_two_equally_deep_rests_are_made_one_however_high_the_ridge() -> None:
    """What makes the oracle unfit for a verdict: here the barrier is the whole range of heights."""
    twins = wells((UP, 0.0), (-UP, 0.0))
    result = drain(GRAPH, twins, PAPER)
    assert (result.sinks, result.ecs, result.boa) == (2, 1, 1.0)
    assert drain(GRAPH, wells((UP, 0.0), (-UP, 0.1)), PAPER).ecs == 2
    assert drain(GRAPH, twins, replace(PAPER, adjacent_only=True)).ecs == 1


def test_basins_that_do_not_touch_merge_unless_they_must_touch() -> None:
    """Two wells at the poles with a valley around the equator between them."""
    valley = 0.1 + GRAPH.directions[:, 2] ** 2
    heights = np.minimum(wells((UP, 0.0), (-UP, 0.0)), valley)
    assert drain(GRAPH, heights, replace(PAPER, linkage="single")).ecs == 2
    apart = drain(GRAPH, heights, replace(PAPER, linkage="single", adjacent_only=True))
    assert apart.ecs == 3
    assert sorted(abs(c.direction[2]) for c in apart.clusters) == pytest.approx([0.0, 1.0, 1.0], abs=0.03)
    # Taken one by one from the lowest, parts of the valley meet only after they were made clusters.
    assert drain(GRAPH, heights, PAPER).ecs == 2
    assert drain(GRAPH, heights, replace(PAPER, adjacent_only=True)).ecs >= 3


def test_a_chain_of_sinks_is_one_cluster_by_single_linkage_only() -> None:
    x, y = np.eye(3)[:2]
    step = 0.006 * np.ptp(wells((UP, 0.0), (x, 0.0), (y, 0.0)))
    heights = wells((UP, 0.0), (x, step), (y, 2.0 * step))
    # The nearest direction to a centre is above its depth, by less than the gap to the thresholds.
    assert drain(GRAPH, heights, PAPER).ecs == 2
    assert drain(GRAPH, heights, replace(PAPER, linkage="single")).ecs == 1


def test_descent_to_the_lowest_neighbour_or_down_the_steepest_slope() -> None:
    angles = np.radians([0.0, 10.0, 60.0, 180.0])
    directions = np.stack([np.cos(angles), np.sin(angles), np.zeros(4)], axis=-1)
    graph = DirectionGraph(directions, np.array([[1, 2], [0, 3], [1, 3], [1, 2]]))
    heights = np.array([1.0, 0.5, 0.2, 0.9])
    lowest = drain(graph, heights, replace(PAPER, merge_fraction=0.0))
    steepest = drain(graph, heights, replace(PAPER, merge_fraction=0.0, descent="steepest"))
    # The first runs over 60° to the lowest or over 10° to the steeper; the second is a hollow only for its
    # own two neighbours.
    assert [c.share for c in lowest.clusters] == [0.75, 0.25]
    assert [c.share for c in steepest.clusters] == [0.5, 0.5]


def test_basins_touch_if_either_has_a_neighbour_in_the_other() -> None:
    directions = np.stack([np.cos([0.0, 1.0, 2.0]), np.sin([0.0, 1.0, 2.0]), np.zeros(3)], axis=-1)
    one_way = DirectionGraph(directions, np.array([[1], [2], [1]]))
    result = drain(one_way, np.array([0.0, 0.001, 1.0]), replace(PAPER, adjacent_only=True))
    assert (result.sinks, result.ecs) == (2, 1)


def test_share_of_the_largest_or_of_the_deepest_cluster() -> None:
    tilted = wells((UP, 0.0), (-UP, 0.0)) + 0.1 * (GRAPH.directions[:, 2] > 0.5)
    result = drain(GRAPH, tilted, PAPER)
    largest, deepest = result.boa, drain(GRAPH, tilted, replace(PAPER, share="deepest")).boa
    assert largest == max(c.share for c in result.clusters)
    assert deepest == result.clusters[0].share
    narrow = np.minimum(wells((-UP, 0.2)), 20.0 * np.sum((GRAPH.directions - UP) ** 2, axis=1))
    assert drain(GRAPH, narrow, PAPER).boa > 0.5 > drain(GRAPH, narrow, replace(PAPER, share="deepest")).boa


def test_a_ball_with_a_lowered_com_has_the_closed_forms() -> None:
    """`h = R − s cos a`, a from the rest: mean drop s, mean gradient π s / 4, mean secant by quadrature."""
    s = 0.2
    vertices, faces = ring_mesh(lambda u: u, 101, 200)
    result = drainage_count(vertices, faces, (0.0, 0.0, -s))
    assert (result.ecs, result.boa) == (1, 1.0)
    assert result.clusters[0].direction == pytest.approx((0.0, 0.0, -1.0), abs=0.05)
    assert result.clusters[0].height_mm == pytest.approx(1.0 - s, abs=1e-3)
    assert result.height_range_mm == pytest.approx(2.0 * s, abs=1e-3)
    assert result.sre_mm == pytest.approx(s, abs=1e-3)
    secant = quad(lambda a: s * (1.0 - np.cos(a)) / a * np.sin(a) / 2.0, 0.0, np.pi)[0]
    assert result.steepness_mm_per_rad == pytest.approx(secant, abs=1e-3)
    gradient = drainage_count(vertices, faces, (0.0, 0.0, -s), replace(PAPER, steepness="gradient"))
    # Over neighbours all around |Δh| averages 2/π of |∇h|; the twelve of the spiral are not quite even.
    assert gradient.steepness_mm_per_rad == pytest.approx(s * np.pi / 4.0 * 2.0 / np.pi, rel=0.06)


def test_heights_are_those_of_the_definition() -> None:
    """`h(d) = c·d − min v·d`, the paper's equation for the COM height, with d pointing up."""
    rng = np.random.default_rng(3)
    mesh = hull_mesh(rng.normal(size=(40, 3)))
    com = np.array(mesh_mass(*mesh).com_mm)
    result = drainage_count(*mesh, options=replace(PAPER, merge_fraction=0.0))
    d = spiral_directions(5000)
    heights = np.array([com @ row - min(mesh.vertices @ row) for row in d])
    assert result.height_range_mm == pytest.approx(np.ptp(heights), abs=1e-12)
    assert result.sre_mm == pytest.approx(np.mean(heights) - heights.min(), abs=1e-12)
    assert result.clusters[0].direction == pytest.approx(-d[np.argmin(heights)])
    for cluster in result.clusters:
        up = -np.array(cluster.direction)
        assert cluster.height_mm == pytest.approx(com @ up - min(mesh.vertices @ up), abs=1e-12)


def figures(result: DrainageResult) -> list[float]:
    return [
        result.ecs,
        result.sinks,
        result.height_range_mm,
        result.sre_mm,
        result.steepness_mm_per_rad,
        result.boa,
    ]


@given(seed=st.integers(0, 10**6))
@settings(max_examples=15, deadline=None)
def test_directions_that_turn_with_the_body_see_the_same(seed: int) -> None:
    """And a shift of body and COM changes nothing either."""
    rng = np.random.default_rng(seed)
    mesh, shift = hull_mesh(rng.normal(size=(20, 3))), rng.normal(size=3)
    turn = random_rotations(1, seed)[0]
    one = drainage_count(*mesh)
    other = drainage_count(mesh.vertices @ turn.T + shift, mesh.faces, turn=turn)
    assert figures(other) == pytest.approx(figures(one), abs=1e-9)
    down = np.array([c.direction for c in one.clusters]) @ turn.T
    np.testing.assert_allclose([c.direction for c in other.clusters], down, atol=1e-9)


def test_rotated_counts_are_counts_with_turned_directions() -> None:
    cube = hull_mesh(platonic(6))
    counts = rotated_counts(*cube, rotations=5, seed=7)
    turns = random_rotations(5, 7)
    assert counts.tolist() == [drainage_count(*cube, turn=turn).ecs for turn in turns]
    assert counts.tolist() == [drainage_count(cube.vertices @ turn, cube.faces).ecs for turn in turns]


def test_random_rotations_are_rotations_without_a_preferred_direction() -> None:
    turns = random_rotations(4000, 1)
    np.testing.assert_allclose(
        turns @ turns.transpose(0, 2, 1), np.broadcast_to(np.eye(3), turns.shape), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(turns), 1.0)
    # Uniform columns: mean 0 and variance 1/3, each within five standard errors.
    assert np.abs(turns.mean(axis=0)).max() < 5.0 * np.sqrt(1.0 / 3.0 / 4000)
    assert np.abs((turns**2).mean(axis=0) - 1.0 / 3.0).max() < 5.0 * np.sqrt(4.0 / 45.0 / 4000)


def test_the_spiral_of_the_paper_is_centred_in_zones_of_equal_area() -> None:
    index = np.arange(5000)
    directions = spiral_directions(PAPER.directions, PAPER.spiral_offset, PAPER.spiral_axis)
    np.testing.assert_allclose(directions[:, 2], 1.0 - (2.0 * index + 1.0) / 5000.0, atol=1e-15)
    np.testing.assert_allclose(directions, fibonacci_directions(5000), atol=1e-9)
    ends = spiral_directions(100, 0.0)[[0, -1]]
    np.testing.assert_allclose(ends, [UP, -UP], atol=1e-12)


@pytest.mark.parametrize(("axis", "index"), [("x", 0), ("y", 1), ("z", 2)])
def test_the_axis_of_the_spiral(axis: Axis, index: int) -> None:
    directions = spiral_directions(500, 0.3, axis)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    assert np.all(np.diff(directions[:, index]) < 0.0)
    frame = np.roll(np.eye(3), index + 1, axis=1)
    np.testing.assert_allclose(spiral_directions(500, 0.3), directions @ frame.T, atol=1e-12)


@pytest.mark.parametrize(
    ("centre", "height"),
    [("volume", 3.0 / 8.0), ("surface", 1.0 / 3.0)],
)
def test_centroids_of_a_half_ball(centre: Centre, height: float) -> None:
    """3/8 R for the solid; its surface, dome at R/2 and disc of half the area at 0, at R/3."""
    radius = 2.0 ** (1.0 / 3.0)
    result = drainage_count(*paper_shape("hemisphere"), options=replace(PAPER, centre=centre))
    upright = min(result.clusters, key=lambda cluster: cluster.height_mm)
    assert upright.direction == pytest.approx((0.0, 0.0, -1.0), abs=0.04)
    assert upright.height_mm == pytest.approx(height * radius, abs=0.03)


def test_centroid_of_the_vertices() -> None:
    pyramid = hull_mesh(np.array([(1, 1, 0), (1, -1, 0), (-1, 1, 0), (-1, -1, 0), (0, 0, 5)], dtype=float))
    result = drainage_count(*pyramid, options=replace(PAPER, centre="vertices"))
    assert figures(result) == figures(drainage_count(*pyramid, (0.0, 0.0, 1.0)))
    assert figures(result) != figures(drainage_count(*pyramid))


@pytest.mark.parametrize(
    "change",
    [
        {"neighbours": 0},
        {"directions": 12},
        {"merge_fraction": -0.1},
        {"merge_fraction": float("nan")},
        {"spiral_offset": 1.5},
    ],
)
def test_options_out_of_range_are_refused(change: dict[str, float]) -> None:
    with pytest.raises(CensusError, match=r"must be between|at least one neighbour"):
        replace(PAPER, **change)


def test_meshes_without_a_centroid_are_refused() -> None:
    vertices, faces = hull_mesh(platonic(6))
    with pytest.raises(CensusError, match="inside out"):
        drainage_count(vertices, faces[:, ::-1])
    with pytest.raises(CensusError, match="flat"):
        drainage_count(vertices * (1.0, 1.0, 0.0), faces)
    with pytest.raises(CensusError, match="does not exist"):
        drainage_count(vertices, faces + 1)
    assert drainage_count(vertices, faces[:0], (0.0, 0.0, 0.0)).ecs == drainage_count(vertices, faces).ecs
    with pytest.raises(CensusError, match="three vertex indices"):
        drainage_count(vertices, np.empty((0, 3), dtype=np.int64))
    with pytest.raises(CensusError, match="finite vertices"):
        drainage_count(np.full((4, 3), np.nan), faces)
    with pytest.raises(CensusError, match="centre of mass"):
        drainage_count(vertices, faces, (0.0, np.inf, 0.0))


@pytest.mark.parametrize("name", ["sphere", "cylinder", "hemisphere", "ellipsoid", "capsule", "cube"])
@pytest.mark.parametrize("rings", [40, 101])
def test_the_papers_bodies_are_closed_and_of_one_volume(name: PaperShape, rings: int) -> None:
    vertices, faces = paper_shape(name, rings, 2 * rings)
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert set(np.unique(edges, axis=0, return_counts=True)[1]) == {2}
    assert len(vertices) - 3 * len(faces) // 2 + len(faces) == 2  # Euler
    assert mesh_mass(vertices, faces).volume_mm3 == pytest.approx(
        4.0 * np.pi / 3.0, rel=8.0 / rings**2 + 2e-3
    )


def test_a_ring_mesh_lies_on_its_body() -> None:
    body = catalog()["primary"].with_diameter(2.0)
    vertices, faces = ring_mesh(body.position_mm, 101, 200)
    assert vertices.shape == (99 * 200 + 2, 3)
    assert faces.shape == (2 * 200 * 99, 3)
    unit = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    np.testing.assert_allclose(body.position_mm(unit), vertices, atol=1e-14)
    np.testing.assert_allclose(mesh_mass(vertices, faces).com_mm, mass_properties(body).com_mm, atol=1e-5)


def test_meshes_and_bodies_that_do_not_exist_are_refused() -> None:
    with pytest.raises(GeometryError, match="at least 3 rings"):
        ring_mesh(lambda u: u, 2, 10)
    with pytest.raises(GeometryError, match="choose one of sphere"):
        paper_shape("torus")  # type: ignore[arg-type]
