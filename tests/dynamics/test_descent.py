"""Quasi-static descent: ways, basins and barriers against closed forms and against the mesh census."""

from __future__ import annotations

import numpy as np
import pytest

from gomboc_cad.body import Body, catalog, mass_properties, support_jet
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.dynamics import RollingBody, basins, descent_path
from gomboc_cad.equilibria import find_equilibria, mesh_census
from gomboc_cad.equilibria.ballast import ballast_subject
from gomboc_cad.equilibria.round_solids import EllipsoidShape
from gomboc_cad.errors import CensusError

AXES = (1.5, 1.0, 0.7)
ELLIPSOID = Body("ellipsoid", EllipsoidShape(AXES), 1.0)
PRIMARY = catalog()["primary"].with_diameter(2.0)
CENTROID = mass_properties(PRIMARY).com_mm


def test_the_way_of_a_loaded_ball_is_a_great_circle(loaded_ball: RollingBody) -> None:
    start = np.array([0.48, 0.6, 0.64])
    path = descent_path(loaded_ball.body, loaded_ball.com_mm, start)
    assert path.length_rad == pytest.approx(np.pi - np.arccos(0.64), abs=1e-5)
    np.testing.assert_allclose(path.down @ (0.6, -0.48, 0.0), 0.0, atol=1e-6)
    np.testing.assert_allclose(path.height_mm, 50.0 + 12.0 * path.down[:, 2], atol=1e-6)
    assert path.rest.direction == pytest.approx((0.0, 0.0, -1.0), abs=1e-9)


def test_heights_fall_all_the_way_to_the_rest() -> None:
    path = descent_path(PRIMARY, CENTROID, (0.9, 0.3, 0.1))
    assert np.all(np.diff(path.height_mm) < 1e-12)
    assert path.rest == find_equilibria(PRIMARY, CENTROID)[0]
    assert path.length_rad > np.arccos(path.down[0] @ path.down[-1])
    steps = np.linalg.norm(np.diff(path.down, axis=0), axis=1)
    assert np.sum(steps) == pytest.approx(path.length_rad, rel=1e-4)


def test_the_way_is_the_steepest() -> None:
    """Along it the height changes by |∇h| for each radian."""
    path = descent_path(PRIMARY, CENTROID, (0.9, 0.3, 0.1), tolerance=1e-9)
    middle = path.down[1:-1:40]
    rise = (path.height_mm[2::40] - path.height_mm[:-2:40])[: len(middle)]
    step = np.linalg.norm(path.down[2::40] - path.down[:-2:40], axis=1)[: len(middle)]
    slope = np.linalg.norm(support_jet(PRIMARY, middle, np.array(CENTROID)).gradient_mm, axis=1)
    far = step > 1e-4
    assert far.sum() > 10
    np.testing.assert_allclose(-rise[far] / step[far], slope[far], rtol=0.02)


def test_an_ellipsoid_has_two_equal_basins_and_the_barrier_of_its_middle_axis() -> None:
    found = basins(ELLIPSOID, (0.0, 0.0, 0.0), samples=200)
    assert [basin.share for basin in found] == pytest.approx([0.5, 0.5], abs=0.01)
    assert [basin.barrier_mm for basin in found] == pytest.approx([0.3, 0.3], abs=1e-9)


def test_barriers_and_basins_of_a_loaded_ellipsoid() -> None:
    """The saddles lie at z = c² s/(b² − c²) of the section x = 0; the basins are those of a fine mesh."""
    s, (_, b, c) = 0.15, AXES
    found = basins(ELLIPSOID, (0.0, 0.0, -s), samples=1000)
    z = c * c * s / (b * b - c * c)
    saddle = np.hypot(b * np.sqrt(1.0 - (z / c) ** 2), z + s)
    assert [basin.rest.height_mm for basin in found] == pytest.approx([c - s, c + s], abs=1e-12)
    assert [basin.barrier_mm for basin in found] == pytest.approx([saddle - c + s, saddle - c - s], abs=1e-9)
    directions, faces = geodesic_triangulation(5)
    census = mesh_census(ELLIPSOID.position_mm(directions), faces, (0.0, 0.0, -s))
    shares = [pose.probability for pose in census.equilibria if pose.kind == "stable"]
    assert [basin.share for basin in found] == pytest.approx(shares, abs=5e-3)


@pytest.mark.parametrize("name", ["primary", "sloan2-0.030", "third-convex"])
def test_a_mono_monostatic_body_has_one_basin_as_deep_as_its_height_range(name: str) -> None:
    body = catalog()[name].with_diameter(2.0)
    com = mass_properties(body).com_mm
    (basin,) = basins(body, com)
    low, high = find_equilibria(body, com)
    assert basin.share == 1.0
    assert basin.barrier_mm == pytest.approx(high.height_mm - low.height_mm, rel=1e-12)


def test_the_primary_with_a_fiftieth_of_ballast_has_two_basins() -> None:
    """In the window of ballast at w = 0.0205, where the paper's oracle sees one rest."""
    com = ballast_subject("gomboc").com_mm(0.0205)
    low, high = basins(PRIMARY, com, samples=150)
    assert low.share + high.share == pytest.approx(1.0)
    assert min(low.share, high.share) > 0.05
    assert 0.0 < high.barrier_mm < low.barrier_mm < 1e-3
    passes = [e.height_mm for e in find_equilibria(PRIMARY, com) if e.kind == "saddle"]
    assert low.rest.height_mm + low.barrier_mm == pytest.approx(
        high.rest.height_mm + high.barrier_mm, abs=1e-12
    )
    assert min(abs(low.rest.height_mm + low.barrier_mm - height) for height in passes) < 1e-12


def test_an_equilibrium_is_no_start() -> None:
    with pytest.raises(CensusError, match="does not arrive"):
        descent_path(ELLIPSOID, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
