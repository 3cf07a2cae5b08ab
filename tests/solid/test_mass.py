"""Mass properties against closed forms, in both kernels."""

from __future__ import annotations

import numpy as np
import pytest
from build123d import Location, Solid
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps

from gomboc_cad.body.mass import mesh_mass
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.solid.mass import solid_mass

BOX_VERTICES = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 2.0) for z in (0.0, 3.0)])
BOX_FACES = np.array(
    [
        face
        for a, b, c, d in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
        for face in ((a, b, c), (a, c, d))
    ]
)
BOX_INERTIA = np.diag([6 * (4 + 9) / 12, 6 * (1 + 9) / 12, 6 * (1 + 4) / 12])


def test_box_in_both_kernels() -> None:
    for mass in (solid_mass(Solid.make_box(1, 2, 3)), mesh_mass(BOX_VERTICES, BOX_FACES)):
        assert mass.volume_mm3 == pytest.approx(6.0, rel=1e-12)
        assert mass.com_mm == pytest.approx((0.5, 1.0, 1.5), rel=1e-12)
        assert np.allclose(mass.inertia_mm5, BOX_INERTIA, rtol=1e-12, atol=1e-12)


def test_a_moved_solid_is_measured_where_it_is() -> None:
    mass = solid_mass(Solid.make_cylinder(2, 5).moved(Location((10, 20, 30))))
    assert mass.volume_mm3 == pytest.approx(20 * np.pi, rel=1e-12)
    assert mass.com_mm == pytest.approx((10, 20, 32.5), rel=1e-12)


def test_mesh_far_from_the_origin_keeps_its_digits() -> None:
    mass = mesh_mass(BOX_VERTICES + 1e6, BOX_FACES)
    assert mass.volume_mm3 == pytest.approx(6.0, rel=1e-9)
    assert mass.com_mm == pytest.approx((1e6 + 0.5, 1e6 + 1.0, 1e6 + 1.5), rel=1e-12)


def test_mesh_of_a_sphere_converges_to_the_sphere() -> None:
    errors = [
        mesh_mass(*geodesic_triangulation(level)).volume_mm3 * 3 / (4 * np.pi) - 1 for level in (3, 4, 5)
    ]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.01)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.01)


def test_other_programs_integrate_our_solids_right_too(halves) -> None:
    """CAD programs call OCCT's integration without a tolerance; on our divided edges it is exact as well."""
    for solid in halves.solids:
        plain = GProp_GProps()
        BRepGProp.VolumeProperties_s(solid.wrapped, plain)
        mass = solid_mass(solid)
        assert plain.Mass() == pytest.approx(mass.volume_mm3, rel=1e-7)
        assert plain.CentreOfMass().Coord() == pytest.approx(mass.com_mm, abs=1e-5)
