"""The drill map: closed forms, invariances, and flats and rims that are checked on their own hulls."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.body import Body, Harmonic, catalog, make_body, support_jet
from gomboc_cad.body.sphere import unit
from gomboc_cad.equilibria import Census, find_equilibria
from gomboc_cad.equilibria.drill_map import DrillMap, drill_limits, drill_map
from gomboc_cad.errors import CensusError, NotConvexError
from tests.body.shapes import ellipsoid, random_directions

SPHERE = Body("sphere", Harmonic((((2, 0), 0.0),)), 1.0)


@pytest.fixture(scope="module")
def primary_map(primary: Body) -> DrillMap:
    return drill_map(primary)


def test_a_sphere_with_its_com_lowered() -> None:
    """About c = −s z: |∇h| = s sinθ, and the ray from c along n has the length √(1 − s² sin²θ) − s (−z)·n."""
    s = 0.2
    normals = random_directions(200, seed=1)
    limits = drill_limits(SPHERE, normals, (0.0, 0.0, -s))
    sine = np.linalg.norm(normals[:, :2], axis=1)
    np.testing.assert_allclose(limits.radius_mm, s * sine, rtol=3e-3, atol=1e-12)
    np.testing.assert_allclose(limits.refined_radius_mm, s * sine, rtol=3e-3, atol=1e-12)
    np.testing.assert_allclose(limits.flat_depth_mm, 1.0 - np.sqrt(1.0 - (s * sine) ** 2), atol=1e-9)
    np.testing.assert_allclose(limits.directions, normals, atol=1e-12)
    np.testing.assert_allclose(limits.positions_mm, normals, atol=1e-12)


def test_flats_on_an_ellipsoid() -> None:
    """A plane flat is a rest when it cuts the ray from the centre, `1/|n/a|` long, and `h = |a n|`."""
    body, axes = ellipsoid((1.1, 1.0, 0.92), 12)
    normals = random_directions(100, seed=2)
    limits = drill_limits(body, normals, (0.0, 0.0, 0.0))
    depth = np.linalg.norm(axes * normals, axis=1) - 1.0 / np.linalg.norm(normals / axes, axis=1)
    np.testing.assert_allclose(limits.flat_depth_mm, depth, atol=2e-5)
    gradient = axes**2 * normals / np.linalg.norm(axes * normals, axis=1)[:, None]
    foot = np.linalg.norm(gradient - np.linalg.norm(axes * normals, axis=1)[:, None] * normals, axis=1)
    assert np.all(limits.radius_mm <= foot * (1.0 + 1e-3))
    small = foot < 0.03
    np.testing.assert_allclose(limits.radius_mm[small], foot[small], rtol=0.02, atol=2e-4)


def test_the_radius_is_the_gradient_of_the_support_function_where_holes_are_small(primary: Body) -> None:
    com = np.array([-0.03, 0.012, 0.02])
    normals = random_directions(300, seed=3)
    limits = drill_limits(primary, normals, com)
    slope = np.linalg.norm(support_jet(primary, normals, com).gradient_mm, axis=1)
    assert np.all(limits.radius_mm <= slope * (1.0 + 1e-9))
    small = slope < 0.05
    assert small.sum() > 50
    np.testing.assert_allclose(limits.radius_mm[small], slope[small], rtol=0.03)


def test_where_curvatures_differ_small_holes_may_be_larger_by_the_formula(primary: Body) -> None:
    """g₂² + (g₁ / (1 − h (1/ρ₁ − 1/ρ₂)))² < a², with the radii of curvature from the Hessian of h."""
    com = np.array([-0.0026956, 0.0, 0.0])
    normals = random_directions(400, seed=4)
    limits = drill_limits(primary, normals, com)
    jet = support_jet(primary, normals, com)
    radii, axes = np.linalg.eigh(jet.hessian_mm + jet.height_mm[:, None, None] * np.eye(2))
    along = np.einsum("nab,nbx,nx->na", axes.transpose(0, 2, 1), jet.tangents, jet.gradient_mm)
    bracket = 1.0 - jet.height_mm * (1.0 / radii[:, 0] - 1.0 / radii[:, 1])
    formula = np.hypot(along[:, 1], along[:, 0] / bracket)
    small = (bracket > 0.0) & (formula < 0.03)
    assert small.sum() > 50
    np.testing.assert_allclose(limits.refined_radius_mm[small], formula[small], rtol=0.05)
    assert np.max(limits.refined_radius_mm[small] / limits.radius_mm[small]) > 1.2
    assert np.all(limits.refined_radius_mm >= limits.radius_mm)


def test_nothing_is_allowed_at_the_equilibria(primary: Body, primary_census: Census) -> None:
    directions = np.array([e.direction for e in primary_census.equilibria])
    limits = drill_limits(primary, directions, primary_census.com_mm)
    np.testing.assert_allclose(limits.radius_mm, 0.0, atol=1e-9)
    np.testing.assert_allclose(limits.flat_depth_mm, 0.0, atol=1e-9)


def test_the_best_place_of_the_primary(primary_map: DrillMap, primary_census: Census) -> None:
    """Up to 0.13 R on the flanks of the primary; its half-turn about x gives every place twice."""
    assert primary_map.max_radius_mm == pytest.approx(0.13, rel=0.03)
    assert primary_map.max_radius_mm >= primary_map.sites.radius_mm.max() * (1.0 - 3e-3)
    around = drill_limits(primary_map.body, random_directions(2000, seed=5), primary_map.com_mm)
    assert around.radius_mm.max() <= primary_map.max_radius_mm * (1.0 + 3e-3)
    np.testing.assert_allclose(primary_map.max_direction, primary_map.best.directions[0])
    turned = np.array(primary_map.max_direction) * [1.0, -1.0, -1.0]
    twin = drill_limits(primary_map.body, turned[None], primary_map.com_mm)
    assert twin.radius_mm[0] == pytest.approx(primary_map.max_radius_mm, rel=5e-3)
    assert primary_map.rest == primary_census.rest
    assert len(primary_map.sites) == 500


def test_limits_scale_with_the_body(primary: Body) -> None:
    normals = random_directions(40, seed=6)
    unit_size = drill_limits(primary, normals, (-0.0027, 0.0, 0.0))
    larger = drill_limits(primary.with_diameter(80.0), normals, (-0.108, 0.0, 0.0))
    np.testing.assert_allclose(larger.radius_mm, 40.0 * unit_size.radius_mm, rtol=1e-6)
    np.testing.assert_allclose(larger.refined_radius_mm, 40.0 * unit_size.refined_radius_mm, rtol=1e-6)
    np.testing.assert_allclose(larger.flat_depth_mm, 40.0 * unit_size.flat_depth_mm, atol=1e-8)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_a_flat_is_a_rest_from_its_limit_on(primary: Body, seed: int) -> None:
    """The foot of the perpendicular from the COM on the cutting plane is inside the body, or outside."""
    rng = np.random.default_rng(seed)
    normal = unit(rng.normal(size=3))
    com = rng.uniform(-0.05, 0.05, size=3)
    limits = drill_limits(primary, normal[None], com)
    height = (limits.positions_mm[0] - com) @ normal
    for share, inside in ((0.99, False), (1.01, True)):
        foot = com + (height - share * limits.flat_depth_mm[0]) * normal
        assert (np.linalg.norm(foot) < primary.radius_at(unit(foot)[None])[0]) == inside


def test_bodies_and_centres_that_cannot_be_mapped(primary: Body) -> None:
    with pytest.raises(NotConvexError):
        drill_map(make_body("sloan2", 0.05))
    with pytest.raises(CensusError, match="outside"):
        drill_map(primary, (0.0, 2.0, 0.0))
    with pytest.raises(CensusError, match="three finite numbers"):
        drill_limits(primary, np.eye(3), (np.nan, 0.0, 0.0))


def test_every_catalogue_body_that_is_convex_has_a_place_for_a_hole() -> None:
    for name in ("sloan2-0.030", "primary"):
        body = catalog()[name]
        drilling = drill_map(body, sites=100)
        rests = find_equilibria(body, drilling.com_mm)
        assert 0.05 < drilling.max_radius_mm / body.radius_mm < 0.25
        assert np.max(np.array([e.direction for e in rests]) @ drilling.max_direction) < 0.999
