"""Extremes of curvature: closed forms, known limits, hostile shapes in bounded time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from gomboc_cad.body import Body, FourierSloan, Harmonic, ShapeFunction, Sloan1, catalog, make_body
from gomboc_cad.body.sphere import fibonacci_directions
from gomboc_cad.equilibria import convexity
from gomboc_cad.equilibria.cells import minimise_on_sphere
from tests.body.shapes import EVERY_FAMILY, Array, Counting, ellipsoid, random_directions


@pytest.mark.parametrize(
    ("shape", "low", "high", "limit"),
    [
        (FourierSloan(0.03), 0.03, 0.04, 0.035505),
        (Sloan1(0.03), 0.03, 0.04, 0.0323),
        (FourierSloan(0.02, ((2, 0.1376),)), 0.02, 0.03, 0.0238),
        (FourierSloan(0.02, ((3, -0.0552),)), 0.02, 0.04, 0.0316),
    ],
    ids=["sloan2", "sloan1", "second", "third"],
)
def test_convexity_is_lost_at_the_published_amplitude(
    shape: FourierSloan | Sloan1, low: float, high: float, limit: float
) -> None:
    """arXiv 2604.17120 v2: the limits of β, with the coefficients of the paper's bodies."""

    def least(beta: float) -> float:
        return convexity(Body("b", replace(shape, beta=beta), 1.0)).min_curvature_per_mm

    digits = len(str(limit)) - 2
    assert brentq(least, low, high, xtol=1e-7) == pytest.approx(limit, abs=0.51 * 10.0**-digits)


def test_an_ellipsoid_has_its_extremes_at_the_ends_of_its_axes() -> None:
    """a > b > c: κ from c/a² at the short end to a/c² at the long end; least Gauss curvature c²/(a²b²)."""
    body, (a, b, c) = ellipsoid((1.1, 1.0, 0.92), 18)
    found = convexity(body)
    assert found.strictly_convex
    assert found.min_curvature_per_mm == pytest.approx(c / a**2, abs=2e-6)
    assert found.min_radius_of_curvature_mm == pytest.approx(c**2 / a, abs=1e-4)
    assert found.min_gaussian_curvature_per_mm2 == pytest.approx(c**2 / (a * b) ** 2, abs=2e-6)
    np.testing.assert_allclose(np.abs(found.min_curvature_direction), (0.0, 0.0, 1.0), atol=5e-3)


@pytest.mark.parametrize("family", EVERY_FAMILY)
def test_no_dense_sample_is_below_the_minimum(family: str) -> None:
    name, beta, coefficients = EVERY_FAMILY[family]
    body = make_body(name, beta, coefficients, diameter_mm=2.0)
    found = convexity(body)
    points = body.surface(np.concatenate([fibonacci_directions(100_000), random_directions(1000)]))
    curvature = points.principal_curvatures_per_mm()
    assert curvature[:, 1].min() >= found.min_curvature_per_mm - 2e-6
    assert curvature[:, 1].min() <= found.min_curvature_per_mm + 5e-3
    assert np.prod(curvature, axis=1).min() >= found.min_gaussian_curvature_per_mm2 - 2e-6
    assert 1.0 / curvature[:, 0].max() >= found.min_radius_of_curvature_mm - 2e-4
    at = body.surface(np.array([found.min_curvature_direction])).principal_curvatures_per_mm()
    assert at[0, 1] == pytest.approx(found.min_curvature_per_mm, rel=1e-12)


def test_curvatures_carry_their_units() -> None:
    one, fifty = (convexity(catalog()["primary"].with_diameter(d)) for d in (2.0, 100.0))
    assert fifty.min_curvature_per_mm * 50.0 == pytest.approx(one.min_curvature_per_mm, abs=2e-6)
    assert fifty.min_gaussian_curvature_per_mm2 * 2500.0 == pytest.approx(
        one.min_gaussian_curvature_per_mm2, abs=2e-6
    )
    assert fifty.min_radius_of_curvature_mm == pytest.approx(50.0 * one.min_radius_of_curvature_mm, rel=1e-3)


@pytest.mark.parametrize(
    ("shape", "convex", "evaluations"),
    [
        (FourierSloan(0.0), True, 50_000),
        (Harmonic((((2, 0), 0.05),)), True, 1_500_000),
        (FourierSloan(1e-9), True, 50_000),
        (FourierSloan(0.2499999), False, 3_000_000),
        (FourierSloan(0.02, ((20, 0.5),)), False, 4_000_000),
    ],
    ids=["sphere", "spheroid", "near sphere", "near cusp", "finely wound"],
)
def test_plateaus_and_wild_shapes_take_bounded_work(
    shape: ShapeFunction, convex: bool, evaluations: int
) -> None:
    counting = Counting(shape)
    assert convexity(Body("hostile", counting, 1.0)).strictly_convex == convex
    assert counting.asked < evaluations


def test_a_minimum_far_narrower_than_the_first_cells_is_followed_down() -> None:
    """A cone of slope 1 that ends in a spike of slope 30 and width 0.01 rad, off every grid point."""
    tip = random_directions(1, seed=12)[0]

    def function(u: Array) -> Array:
        angle = 2.0 * np.arcsin(np.minimum(1.0, 0.5 * np.linalg.norm(u - tip, axis=1)))
        return angle + 30.0 * np.minimum(angle, 0.01)

    found = minimise_on_sphere(function, 1e-6)
    assert found.value == pytest.approx(0.0, abs=1e-6)
    np.testing.assert_allclose(found.direction, tip, atol=1e-7)
    assert np.all(np.diff(function(found.candidates)) >= 0.0)


def test_a_known_upper_bound_saves_work_and_not_the_minimum() -> None:
    asked = []

    def function(u: Array) -> Array:
        asked.append(len(u))
        return u[:, 0] ** 2 + 3.0 * u[:, 1] ** 2 + 0.1 * u[:, 2]

    plain = minimise_on_sphere(function, 1e-5)
    without = sum(asked)
    asked.clear()
    helped = minimise_on_sphere(function, 1e-5, upper_bound=-0.1)
    assert plain.value == pytest.approx(-0.1, abs=1e-5)
    assert helped.value == pytest.approx(-0.1, abs=1e-4)
    assert sum(asked) <= without


def test_a_function_with_thousands_of_equal_minima_ends_with_the_best_found() -> None:
    asked = []

    def function(u: Array) -> Array:
        asked.append(len(u))
        return np.sin(1000.0 * u[:, 0]) * np.sin(1000.0 * u[:, 1])

    assert minimise_on_sphere(function, 1e-12).value == pytest.approx(-1.0, abs=1e-3)
    assert sum(asked) < 1_500_000


def test_smallest_radius_of_curvature_of_the_primary() -> None:
    """29.07 mm on a body of 100 mm: the reference of the thickest smooth wall."""
    primary = catalog()["primary"]
    assert convexity(primary).min_radius_of_curvature_mm == pytest.approx(29.07, abs=0.01)
    assert convexity(primary.with_diameter(10.0)).min_radius_of_curvature_mm == pytest.approx(2.907, abs=1e-3)
