"""Inset surfaces against closed forms and against each other."""

from __future__ import annotations

import numpy as np
import pytest

import gomboc_cad
from gomboc_cad import Body
from gomboc_cad.body import Harmonic, mass_properties
from gomboc_cad.body.sphere import fibonacci_directions
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.offset import InsetSurface

DIRECTIONS = fibonacci_directions(500)


def test_inset_of_a_sphere_is_a_sphere() -> None:
    sphere = Body("sphere", Harmonic(), 50.0)
    mass = InsetSurface(sphere, 3.0, (0.1, 0.2, -0.3)).mass()
    assert mass.volume_mm3 == pytest.approx(4 / 3 * np.pi * 47.0**3, rel=1e-12)
    assert mass.com_mm == pytest.approx((0.1, 0.2, -0.3), abs=1e-12)
    assert np.allclose(mass.inertia_mm5, 0.4 * mass.volume_mm3 * 47.0**2 * np.eye(3), rtol=1e-11, atol=1e-3)


def test_without_inset_the_mass_is_that_of_the_body(primary: Body) -> None:
    mass, known = InsetSurface(primary).mass(), mass_properties(primary)
    assert mass.volume_mm3 == pytest.approx(known.volume_mm3, rel=1e-11)
    assert mass.com_mm == pytest.approx(known.com_mm, abs=1e-10)
    assert np.allclose(mass.inertia_mm5, known.inertia_mm5, rtol=1e-10, atol=1e-2)


def test_volume_of_an_inset_follows_steiner(primary: Body) -> None:
    # V(d) is a cubic in d whose cubic coefficient is −4π/3 for every convex body.
    depths = np.array([0.0, 2.0, 4.0, 6.0])
    volumes = [InsetSurface(primary, d).mass().volume_mm3 for d in depths]
    assert np.polyfit(depths, volumes, 3)[0] == pytest.approx(-4 / 3 * np.pi, rel=1e-6)


@pytest.mark.parametrize("inset_mm", [0.0, 3.0, 12.0])
@pytest.mark.parametrize("height_mm", [-0.5, -1e-4, 1e-4, 0.5])
def test_distance_of_points_along_the_normal(primary: Body, inset_mm: float, height_mm: float) -> None:
    surface = InsetSurface(primary, inset_mm, (0.3, -0.2, 0.1))
    points = surface.position_mm(DIRECTIONS) + height_mm * surface.normal(DIRECTIONS)
    assert surface.signed_distance_mm(points) == pytest.approx(np.full(len(points), height_mm), abs=2e-8)


@pytest.mark.parametrize("wall_mm", [29.2, 60.0])
def test_too_thick_a_wall_is_refused_with_the_number(primary: Body, wall_mm: float) -> None:
    with pytest.raises(GeometryError, match=r"thicker than the smallest inner radius allows.*29\.07 mm"):
        InsetSurface(primary, wall_mm)


@pytest.mark.parametrize("wall_mm", [-1.0, float("nan"), float("inf")])
def test_senseless_walls_are_refused(wall_mm: float) -> None:
    with pytest.raises(GeometryError, match="wall"):
        InsetSurface(gomboc_cad.catalog()["primary"], wall_mm)
