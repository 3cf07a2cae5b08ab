"""Tools: closed forms for their volumes and distances, the same from both kernels."""

from __future__ import annotations

import numpy as np
import pytest
from build123d import Solid
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gomboc_cad.body.sphere import fibonacci_directions
from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.hollow import Box, Cylinder, Ellipsoid, Tool
from gomboc_cad.solid.hollow.brep_tools import tool_shape
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.patches import max_deviation_um
from tests.solid.conftest import ALONG_X, ORIGIN

TURN = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))[0]
AXES = tuple(as_vector(row) for row in TURN)
CENTER = (1.0, -2.0, 0.5)

TUBE = Cylinder(CENTER, (0.3, 0.4, -1.2), 5.0, 7.0, inner_radius_mm=4.0)
SEED = Ellipsoid(CENTER, AXES, (10.0, 6.0, 2.0))
CRATE = Box(CENTER, AXES[0], AXES[2], (3.0, 4.0, 5.0))
VOLUMES = {TUBE: np.pi * 9.0 * 7.0, SEED: 4.0 / 3.0 * np.pi * 120.0, CRATE: 60.0}


@pytest.mark.parametrize("tool", VOLUMES, ids=lambda tool: type(tool).__name__)
def test_solid_of_a_tool_has_its_volume_and_centre(tool: Tool) -> None:
    mass = solid_mass(Solid(tool_shape(tool)))
    assert mass.volume_mm3 == pytest.approx(VOLUMES[tool], rel=1e-8)
    center = np.add(CENTER, 3.5 * np.array(TUBE.direction)) if tool is TUBE else CENTER
    assert mass.com_mm == pytest.approx(center, abs=1e-7)


@pytest.mark.parametrize("tool", VOLUMES, ids=lambda tool: type(tool).__name__)
def test_contains_measures_the_same_volume(tool: Tool) -> None:
    """By counting points: the share of a box that the tool fills."""
    hull = tool.hull_mm()
    low, high = hull.min(axis=0), hull.max(axis=0)
    points = np.random.default_rng(3).uniform(low, high, (200_000, 3))
    share = tool.contains(points).mean() * np.prod(high - low)
    assert share == pytest.approx(VOLUMES[tool], rel=0.03)
    assert np.all(tool.contains(tool.inside_mm()))
    shift = np.array([5.0, 6.0, 7.0])
    assert np.array_equal(tool.moved(as_vector(shift)).contains(points + shift), tool.contains(points))


def test_hull_holds_the_tool() -> None:
    directions = fibonacci_directions(2000)
    for tool, extent in (
        (SEED, np.linalg.norm(directions @ TURN.T * SEED.semi_axes_mm, axis=1)),
        (CRATE, 0.5 * np.abs(directions @ CRATE.frame.T) @ CRATE.size_mm),
    ):
        hull = ((tool.hull_mm() - CENTER) @ directions.T).max(axis=0)
        assert np.all(hull >= extent - 1e-9)
        assert np.all(hull <= 1.08 * extent)


@given(
    u=arrays(float, 3, elements=st.floats(-1.0, 1.0)).filter(lambda u: np.linalg.norm(u) > 0.1),
    height=st.floats(-0.3, 3.0),
)
@settings(deadline=None)
def test_distance_from_an_ellipsoid_is_the_height_over_it(u: np.ndarray, height: float) -> None:
    """Inside too, down to the focal surface, of which the nearest point is 0.4 mm away."""
    directions = u[None] / np.linalg.norm(u)
    foot, normal = SEED.position_mm(directions), SEED.normal(directions)
    assert SEED.signed_distance_mm(foot + height * normal) == pytest.approx(height, abs=1e-12)


def test_distance_from_an_ellipsoid_holds_deep_inside_and_far_away() -> None:
    """At the centre it is the shortest half-length; elsewhere the nearest of many points of the surface."""
    assert SEED.signed_distance_mm(np.array([CENTER])) == pytest.approx(-2.0, abs=1e-12)
    ball = Ellipsoid(CENTER, AXES, (0.1, 0.1, 0.1))
    assert ball.signed_distance_mm(np.array([CENTER])) == pytest.approx(-0.1, abs=1e-12)
    in_planes = np.array(
        [[4.0, 0.0, 0.0], [0.0, 3.0, 0.0], [5.0, -2.0, 0.0], [0.0, 0.0, 1.0], [9.9, 0.0, 0.0]]
    )
    anywhere = np.random.default_rng(2).uniform(-30.0, 30.0, (20, 3))
    points = np.concatenate([in_planes @ TURN, anywhere]) + CENTER
    surface = SEED.position_mm(fibonacci_directions(200_000))
    nearest = np.array([np.linalg.norm(surface - point, axis=1).min() for point in points])
    assert np.abs(SEED.signed_distance_mm(points)) == pytest.approx(nearest, abs=2e-3)
    assert np.all(SEED.signed_distance_mm(points[:5]) < 0.0)


def test_ellipsoids_in_a_solid_are_the_analytic_ones() -> None:
    for semi_axes in ((10.0, 6.0, 2.0), (3.0, 3.0, 3.0), (1.0, 8.0, 8.0)):
        seed = Ellipsoid(CENTER, AXES, semi_axes)
        assert max_deviation_um(Solid(tool_shape(seed)), [seed]) < 1e-4


def test_a_tube_lacks_its_bore() -> None:
    on_axis = np.array([CENTER]) + 0.5 * np.array(TUBE.direction)
    assert not TUBE.contains(on_axis)[0]
    assert TUBE.bore is not None
    assert TUBE.bore.contains(on_axis)[0]
    assert Cylinder(CENTER, ALONG_X, 1.0, 1.0).bore is None


def test_boxes_run_on_only_where_asked() -> None:
    longer = CRATE.run_on(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 2.0]))
    assert longer.size_mm == (3.0, 4.0, 7.0)
    before, after = CRATE.hull_mm() @ CRATE.frame.T, longer.hull_mm() @ CRATE.frame.T
    assert after.min(axis=0) == pytest.approx(before.min(axis=0))
    assert after.max(axis=0) == pytest.approx(before.max(axis=0) + np.array([0.0, 0.0, 2.0]))


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Cylinder(ORIGIN, ALONG_X, 2.0, 1.0, 2.0), "bore of a tube needs a radius"),
        (lambda: Cylinder(ORIGIN, ALONG_X, 2.0, 1.0, float("nan")), "bore of a tube needs a radius"),
        (lambda: Ellipsoid(ORIGIN, AXES, (1.0, 0.0, 1.0)), "three positive half-lengths"),
        (lambda: Ellipsoid(ORIGIN, (ALONG_X, ALONG_X, (0.0, 0.0, 1.0)), (1.0, 1.0, 1.0)), "orthonormal axes"),
        (lambda: Box(ORIGIN, ALONG_X, (0.0, 0.0, 1.0), (1.0, -1.0, 1.0)), "three positive lengths"),
        (lambda: Box(ORIGIN, ALONG_X, (1.0, 0.0, 1.0), (1.0, 1.0, 1.0)), "square to each other"),
        (lambda: Box(ORIGIN, ALONG_X, ORIGIN, (1.0, 1.0, 1.0)), "square to each other"),
    ],
)
def test_senseless_tools_are_refused(make, sentence: str) -> None:
    with pytest.raises(GeometryError, match=sentence):
        make()
