"""Volumes above a plane and lines along a seam, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from gomboc_cad import catalog
from gomboc_cad.body import Body, FourierSloan, mass_properties
from gomboc_cad.body.sphere import unit
from gomboc_cad.products.placement import Parting
from gomboc_cad.tolerance.weighing import glue_line, machine_axes, volume_above_mm3, whole_body

SPHERE = Body("sphere", FourierSloan(0.0), 10.0)
OBLIQUE = unit(np.array([1.0, -2.0, 0.5]))


@pytest.mark.parametrize("height", [-9.0, -3.0, 0.0, 1.0, 9.5, 12.0])
def test_cap_of_a_sphere(height: float) -> None:
    """A cap of height t has the volume π t² (3R − t)/3."""
    top = max(0.0, 10.0 - height)
    assert volume_above_mm3(SPHERE, OBLIQUE, height) == pytest.approx(
        np.pi * top**2 * (30.0 - top) / 3.0, rel=5e-3, abs=1e-9
    )


@pytest.mark.parametrize("height", [0.0, 7.0])
def test_both_sides_of_a_plane_make_the_whole(height: float) -> None:
    body = catalog()["primary"]
    sides = volume_above_mm3(body, OBLIQUE, height), volume_above_mm3(body, -OBLIQUE, -height)
    assert sum(sides) == pytest.approx(mass_properties(body).volume_mm3, rel=1e-6)


def test_middle_plane_of_the_primary_against_a_count_of_points() -> None:
    body = catalog()["primary"]
    points = 52.0 * (2.0 * np.random.default_rng(5).random((400_000, 3)) - 1.0)
    distance = np.linalg.norm(points, axis=1)
    inside = distance < body.radius_at(points / distance[:, None])
    above = (inside & (points[:, 0] > 5.0)).mean() * 104.0**3
    assert volume_above_mm3(body, np.array([1.0, 0.0, 0.0]), 5.0) == pytest.approx(above, rel=0.01)


def test_seam_of_a_sphere_is_a_circle() -> None:
    line = glue_line(SPHERE, Parting(tuple(OBLIQUE), 6.0, (0.0, 0.0, 0.0)), 1.0)
    assert line.length_mm == pytest.approx(2.0 * np.pi * 7.0, rel=1e-5)
    assert line.center_mm == pytest.approx(6.0 * OBLIQUE, abs=1e-9)
    # Half the radius, along two directions in the plane that are square to each other.
    assert line.first_moments_mm @ line.first_moments_mm.T == pytest.approx(3.5**2 * np.eye(2), abs=1e-9)
    assert line.first_moments_mm @ OBLIQUE == pytest.approx([0.0, 0.0], abs=1e-9)


def test_machine_axes_are_a_frame_with_the_build_direction_last() -> None:
    axes = machine_axes((0.0, 0.6, -0.8))
    assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-15)
    assert tuple(axes[2]) == (0.0, 0.6, -0.8)


def test_whole_body_has_its_height_and_spread() -> None:
    part = whole_body(SPHERE, (0.0, 0.0, -1.0), (0.0, 0.0, 1.0))
    assert part.height_mm == pytest.approx(20.0)
    assert part.spread_mm2 == pytest.approx(20.0 * np.eye(3), abs=1e-9)
    assert part.mass_g == pytest.approx(4e-3 / 3.0 * np.pi * 1e3)
    assert part.com_mm == (0.0, 0.0, -1.0)
