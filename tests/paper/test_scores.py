"""The two scores of our own definition, against closed forms and invariances."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from gomboc_cad.equilibria.drainage import random_rotations
from gomboc_cad.equilibria.drainage_shapes import PaperShape, TriangleMesh, paper_shape
from gomboc_cad.paper.scores import CONTACT_DEPTH, Rolling, contact_score, surface_sample, thermal_score

BALL = 4.0 * np.pi / 3.0


def coarse(name: PaperShape) -> TriangleMesh:
    return paper_shape(name, 31, 60)


@pytest.mark.parametrize(
    ("name", "area"),
    [
        ("sphere", 4.0 * np.pi),
        ("cube", 6.0 * BALL ** (2.0 / 3.0)),
        ("cylinder", 10.0 * np.pi * (1.0 / 3.0) ** (2.0 / 3.0)),
    ],
)
def test_the_sample_has_the_area_of_the_body(name: PaperShape, area: float) -> None:
    sample = surface_sample(coarse(name))
    assert sample.areas.sum() == pytest.approx(area, rel=4e-3)
    assert sample.areas.min() > 0.0


def test_a_ball_touches_evenly_in_all_orientations() -> None:
    assert contact_score(paper_shape("sphere", 41, 80), "all") < 0.01


def test_a_ball_that_rolls_straight_touches_along_a_band_of_known_profile() -> None:
    """A point at latitude b from the plane of rolling touches while `cos b cos a > 1 − ε`."""
    edge = np.arccos(1.0 - CONTACT_DEPTH)

    def moment(power: int) -> float:
        def time(b: float) -> float:
            return float(np.arccos(np.minimum(1.0, (1.0 - CONTACT_DEPTH) / np.cos(b))) ** power * np.cos(b))

        return quad(time, 0.0, edge)[0]

    expected = moment(2) / moment(1) ** 2 - 1.0
    assert contact_score(paper_shape("sphere", 61, 120), "straight") == pytest.approx(expected, rel=0.05)


def test_a_cylinder_that_rolls_straight_misses_its_ends_only() -> None:
    """Evenly over its side, four fifths of the surface: `0.8 (1/0.8 − 1)² + 0.2 = 0.25`."""
    assert contact_score(paper_shape("cylinder"), "straight") == pytest.approx(0.25, rel=0.05)


def test_thermal_scores_of_cube_and_cylinder_have_closed_forms() -> None:
    """Shadows `a² (|x| + |y| + |z|)` and `r² (π |cosθ| + 8 sinθ)`; a ball's is constant."""
    cube = np.sqrt(4.0 / np.pi - 1.25) / 1.5
    shadow = [
        quad(lambda t, p=power: (np.pi * np.cos(t) + 8.0 * np.sin(t)) ** p * np.sin(t), 0.0, 0.5 * np.pi)[0]
        for power in (1, 2)
    ]
    cylinder = np.sqrt(shadow[1] - shadow[0] ** 2) / shadow[0]
    assert thermal_score(coarse("cube")) == pytest.approx(cube, rel=2e-3)
    assert thermal_score(coarse("cylinder")) == pytest.approx(cylinder, rel=5e-3)
    assert thermal_score(coarse("sphere")) < 1e-3


@pytest.mark.parametrize("rolling", ["all", "straight"])
def test_scores_belong_to_the_body_and_not_to_its_place_or_size(rolling: Rolling) -> None:
    mesh = paper_shape("ellipsoid", 31, 60)
    moved = TriangleMesh(3.0 * mesh.vertices @ random_rotations(1, 4)[0].T + 5.0, mesh.faces)
    assert contact_score(moved, rolling) == pytest.approx(contact_score(mesh, rolling), rel=0.03)
    assert thermal_score(moved) == pytest.approx(thermal_score(mesh), rel=3e-3)


def test_the_contact_score_does_not_depend_on_the_facets() -> None:
    """The score of arXiv 2604.12238 would fall fourfold from the one mesh to the other."""
    scores = [contact_score(paper_shape("ellipsoid", n, 2 * n - 2), "straight") for n in (31, 61)]
    assert scores[1] == pytest.approx(scores[0], rel=0.05)
