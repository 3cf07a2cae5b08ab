"""The fitted B-rep against the analytic surface."""

from __future__ import annotations

import numpy as np
import pytest
from build123d import Solid
from scipy.interpolate import BSpline

import gomboc_cad
from gomboc_cad import Body
from gomboc_cad.body import make_body
from gomboc_cad.body.sphere import unit
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.offset import InsetSurface
from gomboc_cad.solid.patches import (
    DEGREE,
    body_solid,
    fit_patches,
    inset_solid,
    interpolate_patches,
    max_deviation_um,
    patches_deviation_um,
)

HARMONIC = make_body("harmonic", coefficients={"2,0": 0.03, "3,2": 0.02, "16,-5": 0.002})


def test_reference_volume_and_com_of_the_primary(primary: Body) -> None:
    mass = solid_mass(body_solid(primary))
    assert mass.volume_mm3 == pytest.approx(523458.313905, rel=1e-8)
    assert mass.com_mm == pytest.approx((-0.134778477, 0.0, 0.0), abs=1e-7)


@pytest.mark.parametrize("name", list(gomboc_cad.catalog()))
@pytest.mark.parametrize("wall_mm", [0.0, 3.0])
def test_every_catalogue_body_is_drawn_to_a_tenth_of_a_micrometre(name: str, wall_mm: float) -> None:
    body = gomboc_cad.catalog()[name]
    surface = InsetSurface(body, wall_mm, (0.1, 0.0, -0.2))
    solid = inset_solid(surface)
    assert max_deviation_um(solid, [surface]) <= 0.1
    mass, truth = solid_mass(solid), surface.mass()
    assert mass.volume_mm3 == pytest.approx(truth.volume_mm3, rel=5e-8)
    assert mass.com_mm == pytest.approx(truth.com_mm, abs=5e-6)
    assert solid.is_valid
    assert len(solid.faces()) == 6


def test_harmonic_bodies_take_more_points_until_they_are_close() -> None:
    coarse = interpolate_patches(HARMONIC.position_mm, 17)
    assert patches_deviation_um(coarse, InsetSurface(HARMONIC)) > 0.1
    assert patches_deviation_um(fit_patches(InsetSurface(HARMONIC)), InsetSurface(HARMONIC)) <= 0.1


def test_allowed_deviation_scales_with_the_size(primary: Body) -> None:
    small = primary.with_diameter(10.0)
    assert max_deviation_um(body_solid(small), [InsetSurface(small)]) <= 0.01


def test_finer_fits_converge(primary: Body) -> None:
    surface = InsetSurface(primary, 3.0)
    deviations = [
        patches_deviation_um(interpolate_patches(surface.position_mm, points), surface) for points in (17, 33)
    ]
    # Sixth order: 64 times closer with intervals half as long.
    assert deviations[1] < deviations[0] / 40.0


def test_patches_meet_smoothly(primary: Body) -> None:
    """Along every common edge the normals of both patches agree to about 1e-4 degree."""
    inside = np.linspace(-np.pi / 4, np.pi / 4, 101)
    ends = inside[[0, -1]]
    normals: dict[tuple[float, ...], list[np.ndarray]] = {}
    for patch in fit_patches(InsetSurface(primary)):
        basis = BSpline(patch.knots, np.eye(len(patch.poles_mm)), DEGREE)
        slope = basis.derivative()
        for a, b in ((inside, ends), (ends, inside)):
            along = np.einsum("ai,bj,ijx->abx", slope(a), basis(b), patch.poles_mm)
            across = np.einsum("ai,bj,ijx->abx", basis(a), slope(b), patch.poles_mm)
            directions, _ = patch.sample(a, b)
            for direction, normal in zip(
                directions, unit(np.cross(along, across)).reshape(-1, 3), strict=True
            ):
                normals.setdefault(tuple(direction.round(9) + 0.0), []).append(normal)
    assert all(len(group) >= 2 for group in normals.values())
    angles = [np.linalg.norm(np.cross(group[0], other)) for group in normals.values() for other in group[1:]]
    assert np.degrees(max(angles)) < 1.5e-4


def test_a_body_that_is_not_smooth_enough_is_refused() -> None:
    # Sloan 1 has a jump in its second derivatives at the poles.
    with pytest.raises(GeometryError, match=r"cannot be drawn to 0\.02 µm.*deviates by"):
        body_solid(make_body("sloan1", 0.03))


def test_deviation_of_a_solid_without_splines_is_an_error(primary: Body) -> None:
    with pytest.raises(GeometryError, match="no B-spline face"):
        max_deviation_um(Solid.make_box(1, 1, 1), [InsetSurface(primary)])
