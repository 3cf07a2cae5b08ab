"""Hollow bodies of the OCCT kernel: mass balance, validity, refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from build123d import Solid

from gomboc_cad import Body
from gomboc_cad.body import mass_properties
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.export import file_date
from gomboc_cad.solid.hollow import Cylinder, HollowBody, Seam, brep, split_brep, void_properties
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.offset import InsetSurface
from gomboc_cad.solid.patches import max_deviation_um
from gomboc_cad.solid.step import NamedSolid, step_bytes
from tests.solid.conftest import ALONG_X, ORIGIN, SEAM, Halves


def test_plain_hollow_is_outer_less_inner(primary: Body) -> None:
    hollow = HollowBody(primary, 3.0, (0.4, 0.0, -0.3))
    mass = solid_mass(brep(hollow))
    outer, inner = hollow.outer.mass(), hollow.inner.mass()
    volume = outer.volume_mm3 - inner.volume_mm3
    moment = outer.volume_mm3 * np.array(outer.com_mm) - inner.volume_mm3 * np.array(inner.com_mm)
    assert mass.volume_mm3 == pytest.approx(volume, rel=1e-7)
    assert mass.com_mm == pytest.approx(moment / volume, abs=2e-6)
    assert void_properties(hollow).volume_mm3 == pytest.approx(inner.volume_mm3, rel=1e-8)


def test_body_is_the_hollow_plus_its_void(primary: Body, hollow: HollowBody, hollow_brep: Solid) -> None:
    body, void, shell = mass_properties(primary), void_properties(hollow), solid_mass(hollow_brep)
    assert shell.volume_mm3 + void.volume_mm3 == pytest.approx(body.volume_mm3, rel=2e-8)
    both = shell.volume_mm3 * np.array(shell.com_mm) + void.volume_mm3 * np.array(void.com_mm)
    assert both / body.volume_mm3 == pytest.approx(body.com_mm, abs=1e-6)


def test_void_moves_rigidly_with_the_core(primary: Body, hollow: HollowBody) -> None:
    here = void_properties(hollow)
    there = void_properties(replace(hollow, core_shift_mm=(-0.5, 0.2, 0.0)))
    assert there.volume_mm3 == here.volume_mm3
    assert np.subtract(there.com_mm, here.com_mm) == pytest.approx((-0.65, 0.28, -0.05), abs=1e-12)
    shell = solid_mass(brep(replace(hollow, core_shift_mm=(-0.5, 0.2, 0.0))))
    body = mass_properties(primary)
    moment = body.volume_mm3 * np.array(body.com_mm) - there.volume_mm3 * np.array(there.com_mm)
    assert shell.com_mm == pytest.approx(moment / shell.volume_mm3, abs=2e-6)


def test_halves_are_one_valid_solid_each_and_add_up(halves: Halves, hollow_brep: Solid) -> None:
    whole, parts = solid_mass(hollow_brep), [solid_mass(solid) for solid in halves.solids]
    assert sum(part.volume_mm3 for part in parts) == pytest.approx(whole.volume_mm3, rel=1e-8)
    moment = sum(part.volume_mm3 * np.array(part.com_mm) for part in parts)
    assert moment / whole.volume_mm3 == pytest.approx(whole.com_mm, abs=1e-6)
    for solid, part in zip(halves.solids, parts, strict=True):
        assert isinstance(solid, Solid)
        assert solid.is_valid
        assert len(solid.solids()) == len(solid.shells()) == 1
        assert (part.com_mm[0] > 0) == (solid is halves.solids[1])


def test_surfaces_of_the_halves_are_the_analytic_ones(hollow: HollowBody, halves: Halves) -> None:
    for solid in halves.solids:
        assert max_deviation_um(solid, Boundary.of_hollow(hollow).curved_surfaces) <= 0.1


def test_enclosed_holes_are_voids_of_their_own(hollow_brep: Solid) -> None:
    # The outer shell, the cavity, and three dowel holes inside the seam bosses.
    assert len(hollow_brep.shells()) == 5


def test_hole_through_the_wall_takes_its_cylinder_away(primary: Body) -> None:
    plain = HollowBody(primary, 3.0)
    drilled = replace(plain, holes=(Cylinder((-60.0, 5.0, 3.0), ALONG_X, 2.0, 20.0),))
    taken = solid_mass(brep(plain)).volume_mm3 - solid_mass(brep(drilled)).volume_mm3
    # The wall is 3 mm along the normal, slightly more along x.
    assert 3.0 * np.pi * 4.0 < taken < 3.2 * np.pi * 4.0
    assert void_properties(drilled).volume_mm3 == pytest.approx(InsetSurface(primary, 3.0).mass().volume_mm3)


def test_oblique_planes_split_too(hollow_brep: Solid) -> None:
    normal = np.array([1.0, 0.2, -0.15])
    parts = split_brep(hollow_brep, Seam((1.0, 0.5, 0.0), tuple(normal)))
    heights = [(np.array(solid_mass(part).com_mm) - (1.0, 0.5, 0.0)) @ normal for part in parts]
    assert heights[0] < 0 < heights[1]
    volumes = [solid_mass(part).volume_mm3 for part in parts]
    assert sum(volumes) == pytest.approx(solid_mass(hollow_brep).volume_mm3, rel=1e-7)


def test_cutting_a_solid_leaves_it_as_it_was(hollow_brep: Solid) -> None:
    """OCCT shares edges between what goes into a cut and what comes out."""

    def halves() -> bytes:
        parts = [NamedSolid(f"half {i}", half) for i, half in enumerate(split_brep(hollow_brep, SEAM))]
        return step_bytes(parts, "halves", file_date())

    first = halves()
    split_brep(hollow_brep, Seam((1.0, 2.0, 3.0), (1.0, 0.3, 0.1)))
    assert halves() == first


def test_a_plane_that_misses_is_refused(hollow_brep: Solid) -> None:
    with pytest.raises(GeometryError, match="leaves 1 below and 0 above"):
        split_brep(hollow_brep, Seam((60.0, 0.0, 0.0), ALONG_X))


def test_a_free_boss_is_refused(primary: Body) -> None:
    floating = HollowBody(primary, 3.0, bosses=(Cylinder((-5.0, 0.0, 0.0), ALONG_X, 3.0, 10.0),))
    with pytest.raises(GeometryError, match="stands free in the cavity"):
        brep(floating)


def test_a_hole_that_cuts_the_body_apart_is_refused(primary: Body) -> None:
    apart = HollowBody(primary, 3.0, holes=(Cylinder((-5.0, 0.0, 0.0), ALONG_X, 60.0, 10.0),))
    with pytest.raises(GeometryError, match="falls into 2 pieces"):
        brep(apart)


def test_walls_that_cannot_be_are_refused(primary: Body) -> None:
    with pytest.raises(GeometryError, match=r"thicker than the smallest inner radius allows.*29\.07 mm"):
        HollowBody(primary, 30.0)
    with pytest.raises(GeometryError, match="breaks through the wall"):
        HollowBody(primary, 3.0, (0.0, 2.0, 2.3))
    with pytest.raises(GeometryError, match="positive thickness"):
        HollowBody(primary, 0.0)
    assert HollowBody(primary, 3.0, (0.0, 1.2, 1.6)).thinnest_wall_mm == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("radius_mm", "length_mm", "axis"),
    [(0.0, 1.0, ALONG_X), (1.0, -1.0, ALONG_X), (float("nan"), 1.0, ALONG_X), (1.0, 1.0, ORIGIN)],
)
def test_senseless_cylinders_are_refused(radius_mm: float, length_mm: float, axis) -> None:
    with pytest.raises(GeometryError, match="cylinder needs"):
        Cylinder(ORIGIN, axis, radius_mm, length_mm)
