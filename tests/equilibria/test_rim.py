"""Rims of holes: closed forms on a sphere, and what a centre of mass that moves does to them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.body import Body, Harmonic
from gomboc_cad.body.sphere import tangent_frame, unit
from gomboc_cad.body.support import touching_directions
from gomboc_cad.equilibria import Census, find_equilibria
from gomboc_cad.equilibria.rim import (
    hole_rims_mm,
    inside,
    least_slope_mm,
    mouths_mm,
    rim_clearance_mm,
    rim_rest,
)
from gomboc_cad.errors import GeometryError
from tests.body.shapes import Array, random_directions

SPHERE = Body("sphere", Harmonic((((2, 0), 0.0),)), 1.0)
LOWERED = np.array([0.0, 0.0, -0.3])


def rim_on(body: Body, normal: Array, radius: float, axis: Array | None = None) -> Array:
    place = body.position_mm(normal[None])
    axes = body.normal(normal[None]) if axis is None else axis[None]
    return hole_rims_mm(body, place, axes, np.array([radius]))[0]


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_an_oblique_rim_lies_on_the_cylinder_and_on_the_surface(primary: Body, seed: int) -> None:
    rng = np.random.default_rng(seed)
    direction = unit(rng.normal(size=3))
    axis = unit(primary.normal(direction[None])[0] + 0.4 * unit(rng.normal(size=3)))
    place = primary.position_mm(direction[None])[0]
    rim = rim_on(primary, direction, 0.15, axis)
    arm = rim - place
    np.testing.assert_allclose(np.linalg.norm(arm - np.outer(arm @ axis, axis), axis=1), 0.15, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(rim, axis=1), primary.radius_at(unit(rim)), atol=1e-11)


def test_a_cylinder_that_grazes_the_body_has_no_rim() -> None:
    with pytest.raises(GeometryError, match="graze"):
        hole_rims_mm(SPHERE, np.array([[0.9, 0.0, 0.436]]), np.array([[0.0, 0.0, 1.0]]), np.array([0.2]))


@pytest.mark.parametrize("angle_deg", [30.0, 60.0, 100.0, 150.0])
def test_a_sphere_whose_centre_of_mass_is_lowered(angle_deg: float) -> None:
    """The rim is a circle; the foot on its plane is `s sinθ` from its middle, and `√(1−a²) + s cosθ` high."""
    normal = np.array([math.sin(math.radians(angle_deg)), 0.0, math.cos(math.radians(angle_deg))])
    s = -LOWERED[2]
    foot = s * normal[0]
    small, large = 0.5 * foot, 1.8 * foot
    inscribed = 1.0 - math.cos(math.pi / 60)
    outside = rim_on(SPHERE, normal, small)
    assert rim_rest(outside, LOWERED) is None
    assert rim_clearance_mm(outside, LOWERED) == pytest.approx(foot - small, abs=small * inscribed)
    around = rim_on(SPHERE, normal, large)
    rest = rim_rest(around, LOWERED)
    assert rest is not None
    assert rim_clearance_mm(around, LOWERED) == 0.0
    np.testing.assert_allclose(rest.direction, normal, atol=1e-12)
    height = math.sqrt(1.0 - large**2) + s * normal[2]
    assert rest.height_mm == pytest.approx(height, abs=1e-12)
    over_the_rim = math.hypot(height, large - foot) - height
    assert rest.barrier_mm == pytest.approx(over_the_rim, rel=0.02)


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6), radius=st.floats(0.005, 0.05))
def test_the_clearance_is_the_way_of_the_centre_of_mass_to_a_rest(
    primary: Body, seed: int, radius: float
) -> None:
    rng = np.random.default_rng(seed)
    direction = unit(rng.normal(size=3))
    rim = rim_on(primary, direction, radius)
    com = np.array([-0.0027, 0.0, 0.0])
    clearance = rim_clearance_mm(rim, com)
    if clearance == 0.0:
        assert rim_rest(rim, com) is not None
        return
    for way in random_directions(40, seed):
        assert rim_rest(rim, com + 0.99 * clearance * way) is None
    first, second = (axis[0] for axis in tangent_frame(primary.normal(direction[None])))
    angles = np.linspace(0.0, 2.0 * np.pi, 720)
    ways = np.outer(np.cos(angles), first) + np.outer(np.sin(angles), second)
    # The facet is not quite square to the normal, so the shortest way is not quite among these.
    assert any(rim_rest(rim, com + (1.03 * clearance + 1e-5) * way) is not None for way in ways)


def test_the_slope_on_the_rim_of_a_hole_at_the_rest() -> None:
    """About a COM lowered by s, |∇h| = s sinθ on a sphere, so s·a on the rim of a hole of radius a."""
    down = np.array([0.0, 0.0, -1.0])
    assert least_slope_mm(SPHERE, down, down, 0.2, LOWERED) == pytest.approx(0.3 * 0.2, rel=1e-9)


def test_the_slope_finds_the_narrow_valley_along_the_soft_direction(
    primary: Body, primary_census: Census
) -> None:
    """To first order k a / (k + h), k being the soft stiffness and k + h the radius of curvature along it."""
    rest = primary_census.rest
    down = np.array(rest.direction)
    place = primary_census.com_mm + rest.height_mm * down
    radius = 0.01
    soft = rest.stiffness_mm[0]
    slope = least_slope_mm(primary, place, down, radius, np.array(primary_census.com_mm))
    assert slope == pytest.approx(soft * radius / (soft + rest.height_mm), rel=0.01)


@pytest.mark.parametrize(("share", "within"), [(0.95, True), (1.05, False)])
def test_the_rest_leaves_the_mouth_when_the_centre_of_mass_is_off_by_the_slope(
    primary: Body, primary_census: Census, share: float, within: bool
) -> None:
    rest = primary_census.rest
    com, down = np.array(primary_census.com_mm), np.array(rest.direction)
    place = com + rest.height_mm * down
    slope = least_slope_mm(primary, place, down, 0.06, com)
    moved = com + share * slope * np.array(rest.soft_direction)
    lowest = np.array(find_equilibria(primary, moved)[0].direction)
    touching = primary.position_mm(touching_directions(primary, lowest[None]))[0] - place
    assert (np.linalg.norm(touching - (touching @ down) * down) < 0.06) == within


def test_rays_leave_the_body_where_its_surface_is(primary: Body) -> None:
    origins = 0.3 * random_directions(20, seed=1)
    directions = random_directions(20, seed=2)
    mouths = mouths_mm(primary, origins, directions)
    np.testing.assert_allclose(np.linalg.norm(mouths, axis=1), primary.radius_at(unit(mouths)), rtol=1e-9)
    ahead = np.einsum("nx,nx->n", mouths - origins, directions)
    np.testing.assert_allclose(mouths - origins, ahead[:, None] * directions, atol=1e-12)
    assert np.all(ahead > 0.0)
    assert inside(primary, 0.999 * mouths).all()
    assert not inside(primary, 1.001 * mouths).any()
    assert inside(primary, np.zeros((1, 3))).all()
