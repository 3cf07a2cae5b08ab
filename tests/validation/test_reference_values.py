"""Reference figures of the bodies, as an independent recomputation found them.

Source: section 3 of the amended source paper's recomputation (arXiv 2604.17120 v2 retracts much of arXiv
2604.17095 v1); grids of 1500² to 2000² points with refinement, R₀ = 1. Agreement is asked to one percent.
"""

from __future__ import annotations

import numpy as np
import pytest

from gomboc_cad.body import Body, catalog, make_body
from gomboc_cad.body.sphere import fibonacci_directions
from gomboc_cad.equilibria import Census, com_margin, convexity, find_equilibria, smooth_census


@pytest.fixture(scope="module")
def primary() -> Body:
    return catalog()["primary"].with_diameter(2.0)


@pytest.fixture(scope="module")
def census(primary: Body) -> Census:
    return smooth_census(primary)


def test_the_primary_is_mono_monostatic(census: Census) -> None:
    assert (census.stable, census.unstable, census.saddles) == (1, 1, 0)


def test_figures_of_the_primary(census: Census) -> None:
    assert census.margin.margin_mm == pytest.approx(0.00330, rel=0.01)
    assert census.margin.s_margin_mm == pytest.approx(0.00339, rel=0.01)
    np.testing.assert_allclose(census.com_mm, (-0.0026956, 0.0, 0.0), atol=1e-7)
    np.testing.assert_allclose(census.rest.direction, (-1.0, 0.0, 0.0), atol=1e-9)
    assert census.height_range_mm == pytest.approx(0.0518, rel=0.01)
    assert census.convexity.min_curvature_per_mm == pytest.approx(0.0885, rel=0.01)


def test_figures_of_sloan2() -> None:
    """Sloan's second body has one stable and one unstable equilibrium, against the claim of v1."""
    census = smooth_census(catalog()["sloan2-0.030"].with_diameter(2.0))
    assert (census.stable, census.unstable, census.saddles) == (1, 1, 0)
    assert census.margin.margin_mm == pytest.approx(0.00114, rel=0.01)


@pytest.mark.parametrize(
    ("family", "beta", "coefficients"),
    [
        ("sloan1", 0.005, {}),
        ("sloan1", 0.03, {}),
        ("sloan2", 0.005, {}),
        ("sloan2", 0.0354, {}),
        ("extended", 0.0236, {"2": 0.1376}),
        ("extended", 0.0314, {"3": -0.0552}),
    ],
)
def test_convex_members_of_every_family_are_mono_monostatic(
    family: str, beta: float, coefficients: dict[str, float]
) -> None:
    """Also of the families of the paper's second and third bodies, where those are not convex themselves."""
    body = make_body(family, beta, coefficients, diameter_mm=2.0)
    com = smooth_census(body).com_mm if family == "extended" else (0.0, 0.0, 0.0)
    assert [e.kind for e in find_equilibria(body, com)] == ["stable", "unstable"]


@pytest.mark.parametrize(("name", "gauss"), [("second", -0.43), ("third", -0.89)])
def test_the_papers_second_and_third_bodies_are_dented(name: str, gauss: float) -> None:
    found = convexity(catalog()[name].with_diameter(2.0))
    assert not found.strictly_convex
    assert found.min_gaussian_curvature_per_mm2 == pytest.approx(gauss, rel=0.01)


def test_beta_0_05_is_not_convex() -> None:
    """arXiv 2604.17095 v1 calls it convex; its Gaussian curvature falls to −0.57.

    It is negative over 6.0 % of the directions, which is 5.4 % of the area.
    """
    body = make_body("sloan2", 0.05, diameter_mm=2.0)
    assert convexity(body).min_gaussian_curvature_per_mm2 == pytest.approx(-0.57, rel=0.01)
    u = fibonacci_directions(40_000)
    points = body.surface(u)
    area = body.radius_at(u) ** 2 / np.einsum("nx,nx->n", u, points.normal)
    negative = np.prod(points.principal_curvatures_per_mm(), axis=1) < 0.0
    assert negative.mean() == pytest.approx(0.0604, abs=0.001)
    assert area[negative].sum() / area.sum() == pytest.approx(0.0545, abs=0.001)


@pytest.mark.parametrize(
    ("nearer", "s_margin"), [(0.0, 0.00339), (0.0055, 0.0077), (0.020, 0.0008), (0.05, 0.024), (0.10, 0.062)]
)
def test_the_loading_zone_along_the_axis(
    primary: Body, census: Census, nearer: float, s_margin: float
) -> None:
    """S-margin with the COM nearer to the rest; one stable rest all along."""
    com = np.array(census.com_mm) + nearer * np.array(census.rest.direction)
    assert com_margin(primary, com).s_margin_mm == pytest.approx(s_margin, rel=0.05)
    assert sum(e.kind == "stable" for e in find_equilibria(primary, com)) == 1
