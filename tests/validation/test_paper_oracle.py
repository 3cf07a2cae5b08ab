"""The drainage oracle against the tables of its paper, and against what is true.

Source of all published figures: arXiv 2604.17095 v1, tables "ECS oracle validation", "ECS of Sloan Gömböc 2",
"Three verified bodies" and "Self-righting dynamics", sections "Threshold Robustness" and "Resolution
Independence". Where a figure does not come out, the test says what does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from gomboc_cad.body import Body, catalog, make_body
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.equilibria import CensusVerdict, convexity, hull_census, mesh_census, smooth_census
from gomboc_cad.equilibria.drainage import (
    DrainageOptions,
    DrainageResult,
    drainage_count,
    random_rotations,
    rotated_counts,
)
from gomboc_cad.equilibria.drainage_shapes import PaperShape, TriangleMesh, paper_shape, ring_mesh

PAPER = DrainageOptions.paper()
BETAS = (0.001, 0.005, 0.010, 0.020, 0.050, 0.100, 0.150)


def unit_body(name: str) -> Body:
    return catalog()[name].with_diameter(2.0)


def meshed(body: Body, rings: int = 101, segments: int = 200) -> TriangleMesh:
    return ring_mesh(body.position_mm, rings, segments)


@pytest.fixture(scope="module")
def sloan_sweep() -> list[DrainageResult]:
    return [drainage_count(*meshed(make_body("sloan2", beta, diameter_mm=2.0))) for beta in BETAS]


def rounded(result: DrainageResult) -> tuple[int, float, float, float, float]:
    """A row of the paper's table of dynamics."""
    return (
        result.ecs,
        round(result.sre_mm, 3),
        round(result.height_range_mm, 3),
        round(result.steepness_mm_per_rad, 3),
        round(result.boa, 3),
    )


def test_the_primary_gives_its_row_of_the_table_of_dynamics() -> None:
    assert rounded(drainage_count(*meshed(unit_body("primary")))) == (1, 0.028, 0.051, 0.023, 1.000)


@pytest.mark.parametrize(("name", "ecs", "boa"), [("cube", 3, 0.624), ("cylinder", 3, 0.835)])
def test_count_and_boa_of_cube_and_cylinder_to_all_digits(name: PaperShape, ecs: int, boa: float) -> None:
    result = drainage_count(*paper_shape(name))
    assert (result.ecs, round(result.boa, 3)) == (ecs, boa)


PUBLISHED: dict[PaperShape, tuple[int, float, float, float]] = {
    "ellipsoid": (1, 0.388, 0.783, 0.287),
    "capsule": (1, 0.743, 1.486, 0.577),
    "cylinder": (3, 0.542, 0.853, 0.429),
    "cube": (3, 0.390, 0.576, 0.328),
}


@pytest.mark.parametrize("name", PUBLISHED)
def test_lengths_of_the_other_rows_agree_but_for_an_unknown_size(name: PaperShape) -> None:
    """Half a percent: the paper does not give the volume that its bodies have in common.

    The h-ranges of ours are 0.47 to 0.56 % larger for the cube, the cylinder and the ellipsoid; for the
    capsule, whose length is not given either, 0.04 %. Ratios of the figures do not depend on the size; they
    agree about as well as three digits can.
    """
    result = drainage_count(*paper_shape(name))
    ecs, sre, height_range, steepness = PUBLISHED[name]
    assert result.ecs == ecs
    assert result.height_range_mm == pytest.approx(height_range, rel=0.006)
    assert result.sre_mm / result.height_range_mm == pytest.approx(sre / height_range, rel=2e-3)
    assert result.steepness_mm_per_rad / result.height_range_mm == pytest.approx(
        steepness / height_range, rel=2.5e-3
    )


@pytest.mark.parametrize(("name", "ecs"), [("hemisphere", 2), ("ellipsoid", 1), ("capsule", 1), ("cube", 3)])
def test_counts_of_the_table_of_validation(name: PaperShape, ecs: int) -> None:
    assert drainage_count(*paper_shape(name)).ecs == ecs


def test_counts_of_the_table_of_validation_that_do_not_come_out() -> None:
    """The cylinder is 2 there and 3 in the table of dynamics; the sphere is 41, at an h-range of 0.001.

    What a sphere reads is a property of its mesh: 41 on 1,280 geodesic facets, but with an h-range of 0.004.
    """
    assert drainage_count(*paper_shape("cylinder")).ecs == 3
    readings = [drainage_count(*geodesic_triangulation(level)) for level in (3, 4)]
    assert [(r.ecs, round(r.height_range_mm, 3)) for r in readings] == [(41, 0.004), (42, 0.001)]
    assert drainage_count(*paper_shape("sphere")).ecs == 50


def test_counts_of_the_sweep_of_beta(sloan_sweep: list[DrainageResult]) -> None:
    """[38, 7, 4, 3, 2, 7, 11] in the paper: four of seven come out, the others within a fifth and 1 and 1."""
    assert [result.ecs for result in sloan_sweep] == [46, 7, 5, 3, 2, 7, 12]


def test_height_ranges_of_the_sweep_of_beta(sloan_sweep: list[DrainageResult]) -> None:
    """To all digits where the mesh is nearly convex; 0.6 and 0.9 % less than published beyond."""
    found = [result.height_range_mm for result in sloan_sweep]
    assert [round(value, 3) for value in found[:5]] == [0.002, 0.010, 0.020, 0.040, 0.097]
    assert found[5:] == pytest.approx([0.174, 0.237], rel=0.01)


@pytest.mark.parametrize(("name", "height_range"), [("primary", 0.051), ("second", 0.064), ("third", 0.099)])
def test_the_three_instances_read_one(name: str, height_range: float) -> None:
    result = drainage_count(*meshed(unit_body(name)))
    assert (result.ecs, result.boa) == (1, 1.0)
    assert round(result.height_range_mm, 3) == height_range


def test_the_second_and_the_third_instance_read_one_but_rest_in_several_ways() -> None:
    """Refuted by the amendment, arXiv 2604.17120 v2, and by our census: 2 and 4 rests of their hulls."""
    for name, rests in (("second", 2), ("third", 4)):
        body = unit_body(name)
        assert not convexity(body).strictly_convex
        assert hull_census(body).stable == rests


@pytest.mark.parametrize(("fraction", "ecs"), [(0.0, 3), (0.001, 2), (0.005, 1), (0.01, 1), (0.10, 1)])
def test_thresholds_of_the_primary(fraction: float, ecs: int) -> None:
    """One from 0.5 to 10 %, two at 0.1 %, three basins before merging."""
    options = replace(PAPER, merge_fraction=fraction)
    assert drainage_count(*meshed(unit_body("primary")), options=options).ecs == ecs


def test_resolutions_of_the_primary() -> None:
    """More than one on the 40 × 80 mesh, one from 80 × 160 on, h-range 0.051 ± 0.001."""
    primary = unit_body("primary")
    results = [drainage_count(*meshed(primary, n + 1, 2 * n)) for n in (40, 80, 100, 200)]
    assert [result.ecs for result in results] == [2, 1, 1, 1]
    assert [result.height_range_mm for result in results] == pytest.approx([0.051] * 4, abs=1e-3)


def test_one_ring_of_the_mesh_decides_what_the_primary_reads() -> None:
    primary = unit_body("primary")
    assert drainage_count(*meshed(primary, 100, 200)).ecs == 2
    assert drainage_count(*meshed(primary, 101, 200)).ecs == 1


def test_no_threshold_makes_the_ellipsoid_three() -> None:
    """ "At 0.1 % threshold, ECS = 3", says the paper; it has two rests, and no more than two basins."""
    ellipsoid = paper_shape("ellipsoid")
    assert drainage_count(*ellipsoid).ecs == 1
    for fraction in (0.0, 0.001):
        assert drainage_count(*ellipsoid, options=replace(PAPER, merge_fraction=fraction)).ecs <= 2
    census = mesh_census(*ellipsoid, probabilities=False)
    assert (census.stable, census.saddles, census.unstable) == (2, 2, 2)


def test_the_text_of_the_paper_does_not_give_its_tables() -> None:
    """Only adjacent basins merged, it would read 6 or 8 for the cube and 8 or 1 for the capsule."""
    text = replace(PAPER, adjacent_only=True)
    chained = replace(text, linkage="single")
    cube, capsule = paper_shape("cube"), paper_shape("capsule")
    assert [drainage_count(*cube, options=o).ecs for o in (text, chained)] == [8, 6]
    assert [drainage_count(*capsule, options=o).ecs for o in (text, chained)] == [8, 1]


@pytest.mark.parametrize(
    ("make", "stable", "verdict"),
    [
        (lambda: paper_shape("cube"), 6, "multistable"),
        (lambda: meshed(unit_body("primary")), 1, "monostable"),
    ],
    ids=["cube", "primary"],
)
def test_the_count_scatters_over_rotations_of_the_directions_and_the_census_does_not(
    make: Callable[[], TriangleMesh], stable: int, verdict: CensusVerdict
) -> None:
    """Thirty random rotations: the count of the oracle is a property of its directions.

    The census, which is exact, is turned ten times; thirty times by the paper's table of rotations.
    """
    mesh = make()
    counts = rotated_counts(*mesh, rotations=30, seed=0)
    assert counts.min() < counts.max()
    assert np.mean(counts == stable) < 0.5
    for turn in random_rotations(10, 0):
        census = mesh_census(mesh.vertices @ turn, mesh.faces, probabilities=False)
        assert (census.stable, census.verdict) == (stable, verdict)


def test_sloans_body_reads_several_and_has_one(sloan_sweep: list[DrainageResult]) -> None:
    """The paper's "parameterization gap" is its oracle's: retracted by its amendment, arXiv 2604.17120 v2."""
    for beta, result in zip(BETAS[1:4], sloan_sweep[1:4], strict=True):
        assert result.ecs > 1
        census = smooth_census(make_body("sloan2", beta, diameter_mm=2.0), margins=False)
        assert (census.stable, census.saddles, census.unstable) == (1, 0, 1)


def test_the_ellipsoid_reads_one_from_wherever_it_is_looked_at() -> None:
    """Not noise but a fault of the merging: two rests of one depth; the ridge is 3/8 of the h-range high."""
    ellipsoid = paper_shape("ellipsoid", 61, 120)
    assert set(rotated_counts(*ellipsoid, rotations=30, seed=0).tolist()) == {1}
    census = mesh_census(*ellipsoid, probabilities=False)
    assert census.stable == 2
    barriers = [pose.barrier_mm for pose in census.equilibria if pose.kind == "stable"]
    assert barriers == pytest.approx([3.0 / 8.0 * census.height_range_mm] * 2, rel=0.01)
