"""The best place for the COM near a given one."""

from __future__ import annotations

import numpy as np
import pytest

from gomboc_cad.body import Body, Harmonic, depth_mm, make_body, mass_properties
from gomboc_cad.equilibria import Census, com_margin
from gomboc_cad.equilibria.zone import best_com_nearby
from gomboc_cad.errors import CensusError, NotConvexError
from tests.body.shapes import ellipsoid

SPHERE = Body("sphere", Harmonic((((2, 0), 0.0),)), 10.0)


@pytest.fixture(scope="module")
def best_of_primary(primary: Body) -> tuple[tuple[float, float, float], float]:
    return best_com_nearby(primary)


def room(body: Body, place: np.ndarray) -> float:
    return min(com_margin(body, place).s_margin_mm, float(depth_mm(body, place)[0]))


@pytest.mark.parametrize("start", [(0.0, 0.0, -2.0), (1.0, -0.5, 0.7)])
def test_half_way_to_the_surface_of_a_sphere(start: tuple[float, float, float]) -> None:
    """The walls of a sphere are its centre and its surface, so the best ball touches both."""
    place, margin = best_com_nearby(SPHERE, start)
    assert margin == pytest.approx(5.0, rel=1e-3)
    assert np.linalg.norm(place) == pytest.approx(5.0, rel=1e-3)


def test_the_best_place_of_the_primary(
    primary: Body, best_of_primary: tuple[tuple[float, float, float], float]
) -> None:
    """About 0.0055 R nearer to the rest point than the centroid, with a margin of 0.0077 R."""
    place, margin = best_of_primary
    shift = np.subtract(place, mass_properties(primary).com_mm) / primary.radius_mm
    assert shift[0] == pytest.approx(-0.0055, abs=2e-4)
    assert margin / primary.radius_mm == pytest.approx(0.0077, rel=0.01)
    assert margin == pytest.approx(room(primary, np.array(place)), rel=1e-12)


def test_it_stays_on_the_axis_of_symmetry(best_of_primary: tuple[tuple[float, float, float], float]) -> None:
    """The primary is symmetric under a half-turn about x; off it the rest would be tilted by chance."""
    place, _ = best_of_primary
    assert abs(place[0]) > 1e-3
    np.testing.assert_allclose(place[1:], 0.0, atol=1e-12)


def test_no_place_nearby_is_better(
    primary: Body, best_of_primary: tuple[tuple[float, float, float], float]
) -> None:
    place, margin = best_of_primary
    rng = np.random.default_rng(2)
    for step in rng.normal(size=(8, 3)):
        nearby = np.array(place) + 0.1 * margin * step / np.linalg.norm(step)
        assert room(primary, nearby) <= margin * (1.0 + 1e-3)


def test_from_a_place_on_one_plane_of_symmetry_of_an_ellipsoid() -> None:
    body, _ = ellipsoid((1.1, 1.0, 0.92), 12)
    start = (0.0, 0.45, 0.2)
    place, margin = best_com_nearby(body, start)
    assert margin > room(body, np.array(start))
    assert place[0] == 0.0
    for step in 0.05 * np.array(
        [[1.0, 0, 0], [-1.0, 0, 0], [0, 1.0, 0], [0, -1.0, 0], [0, 0, 1.0], [0, 0, -1.0]]
    ):
        assert room(body, np.array(place) + step) <= margin * (1.0 + 2e-3)


def test_it_scales_with_the_body(
    primary: Body, best_of_primary: tuple[tuple[float, float, float], float]
) -> None:
    scale = 3.0
    place, margin = best_com_nearby(primary.with_diameter(scale * primary.diameter_mm))
    np.testing.assert_allclose(place, scale * np.array(best_of_primary[0]), rtol=1e-6, atol=1e-9)
    assert margin == pytest.approx(scale * best_of_primary[1], rel=1e-6)


def test_it_refuses_what_has_no_zone(primary: Body, primary_census: Census) -> None:
    witness = np.array(primary_census.margin.s_witness_mm)
    beyond = witness + 0.2 * (witness - np.array(primary_census.com_mm))
    with pytest.raises(CensusError, match="2 stable rests"):
        best_com_nearby(primary, beyond)
    with pytest.raises(NotConvexError):
        best_com_nearby(make_body("sloan2", 0.05))
    with pytest.raises(CensusError, match="three finite numbers"):
        best_com_nearby(primary, (np.nan, 0.0, 0.0))
