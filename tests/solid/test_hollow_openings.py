"""Openings, pockets and bodies without a cavity: what moves with the core, and what stays."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gomboc_cad import Body
from gomboc_cad.body import mass_properties
from gomboc_cad.body.catalogue import named_body
from gomboc_cad.body.sphere import fibonacci_directions
from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.boundary import Boundary
from gomboc_cad.solid.hollow import (
    Box,
    Cylinder,
    Ellipsoid,
    HollowBody,
    Seam,
    brep,
    mesh,
    split_brep,
    split_mesh,
    void_properties,
)
from gomboc_cad.solid.mass import solid_mass
from gomboc_cad.solid.offset import InsetSurface
from tests.solid.conftest import ORIGIN
from tests.solid.inspection import problems_on_disk

SAG_UM = 20.0
UP = (0.0, 0.0, 1.0)
AXES = tuple(as_vector(row) for row in np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0])
SEED = Ellipsoid((0.5, -0.3, 0.2), AXES, (8.0, 5.0, 4.0))
EXIT = Cylinder((0.0, 0.0, -16.0), UP, 1.5, 10.0)


@pytest.fixture(scope="module")
def pod(primary: Body) -> HollowBody:
    """A solid body of 30 mm around a seed, with an exit that stays where it is."""
    return HollowBody(primary.with_diameter(30.0), None, (0.1, 0.2, -0.1), holes=(SEED,), openings=(EXIT,))


def test_seed_pod_passes_the_inspection_of_its_files(pod: HollowBody, tmp_path: Path) -> None:
    solid, facets, boundary = brep(pod), mesh(pod, SAG_UM), Boundary.of_hollow(pod)
    assert problems_on_disk(tmp_path, solid, facets, boundary, SAG_UM) == ()
    seam = Seam((0.0, 0.0, 0.5), (0.1, 0.0, 1.0))
    parts = zip(split_brep(solid, seam), split_mesh(facets, seam, SAG_UM), boundary.split(seam), strict=True)
    for lower_or_upper in parts:
        assert problems_on_disk(tmp_path, *lower_or_upper, SAG_UM) == ()


def test_a_pocket_of_another_size_is_found_on_disk(pod: HollowBody, tmp_path: Path) -> None:
    wanted = replace(pod, holes=(replace(SEED, semi_axes_mm=(8.0, 5.0, 4.1)),))
    problems = problems_on_disk(tmp_path, brep(pod), mesh(pod, SAG_UM), Boundary.of_hollow(wanted), SAG_UM)
    assert sum("away from the model's surface" in problem for problem in problems) == 3


def test_void_of_a_pocket_is_the_ellipsoid_and_moves_with_the_core(pod: HollowBody) -> None:
    void = void_properties(pod)
    assert void.volume_mm3 == pytest.approx(4.0 / 3.0 * np.pi * 160.0, rel=1e-8)
    assert void.com_mm == pytest.approx((0.6, -0.1, 0.1), abs=1e-8)
    assert void_properties(replace(pod, openings=())) == void


def test_body_without_a_cavity_is_the_body(primary: Body) -> None:
    plain = HollowBody(primary, None, bosses=(Cylinder(ORIGIN, UP, 3.0, 3.0),))
    assert solid_mass(brep(plain)).volume_mm3 == pytest.approx(mass_properties(primary).volume_mm3, rel=2e-8)
    assert void_properties(plain).volume_mm3 == 0.0
    assert plain.inner is None
    assert plain.thinnest_wall_mm == np.inf


def test_openings_stay_where_they_are(primary: Body) -> None:
    """What the shift changes is the cavity's moment alone while the opening does not reach the cavity."""
    blind = HollowBody(primary, 4.0, openings=(Cylinder((0.0, 0.0, 47.5), UP, 2.0, 10.0),))
    shifted = replace(blind, core_shift_mm=(0.6, -0.5, 0.4))
    here, there = solid_mass(brep(blind)), solid_mass(brep(shifted))
    assert there.volume_mm3 == pytest.approx(here.volume_mm3, rel=1e-7)
    moment = there.volume_mm3 * np.subtract(there.com_mm, here.com_mm)
    cavity = InsetSurface(primary, 4.0).mass().volume_mm3
    assert moment == pytest.approx(-cavity * np.array([0.6, -0.5, 0.4]), rel=1e-5)


def test_counterbore_and_drill_from_outside_make_one_hole(primary: Body, tmp_path: Path) -> None:
    """They meet in a plane, in a boss, and the drill ends flush with the boss's end."""
    axis = (0.36, 0.48, 0.8)
    up = np.array(axis)
    hollow = HollowBody(
        primary,
        3.0,
        (0.2, 0.1, -0.1),
        bosses=(Cylinder(as_vector(30.0 * up), axis, 6.0, 25.0),),
        openings=(
            Cylinder(as_vector(30.0 * up + (0.2, 0.1, -0.1)), axis, 1.6, 10.0),
            Cylinder(as_vector(40.0 * up + (0.2, 0.1, -0.1)), axis, 3.0, 20.0),
        ),
    )
    solid = brep(hollow)
    assert len(solid.shells()) == 1
    assert problems_on_disk(tmp_path, solid, mesh(hollow, SAG_UM), Boundary.of_hollow(hollow), SAG_UM) == ()


def test_boxes_and_rings_are_cut_by_both_kernels_alike(primary: Body, tmp_path: Path) -> None:
    bay = Box((0.0, -30.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.6, 0.8), (12.0, 10.0, 8.0))
    ring = Cylinder((0.0, 0.0, 10.0), (0.0, 0.2, 1.0), 12.0, 3.0, 9.0)
    hollow = HollowBody(primary.with_diameter(80.0), None, (0.0, 0.3, 0.1), holes=(bay, ring))
    solid = brep(hollow)
    assert len(solid.shells()) == 3
    void = void_properties(hollow).volume_mm3
    assert void == pytest.approx(960.0 + np.pi * (12.0**2 - 9.0**2) * 3.0, rel=1e-9)
    assert problems_on_disk(tmp_path, solid, mesh(hollow, SAG_UM), Boundary.of_hollow(hollow), SAG_UM) == ()


def test_a_bay_flush_with_a_boss_is_open(primary: Body) -> None:
    """Rounding must leave no skin over the mouth of a box."""
    boss = Cylinder((0.0, 0.0, -50.0), UP, 12.0, 20.0)
    bay = Box((0.0, 0.0, -33.0), (0.8, 0.6, 0.0), UP, (6.0, 8.0, 6.0))
    hollow = HollowBody(primary, 3.0, bosses=(boss,), holes=(bay,))
    assert len(brep(hollow).shells()) == 2
    taken = mesh(replace(hollow, holes=()), 50.0).mass().volume_mm3 - mesh(hollow, 50.0).mass().volume_mm3
    assert taken == pytest.approx(6.0 * 8.0 * 6.0, rel=1e-4)


def test_a_field_of_dots_passes_the_inspection_of_its_files(primary: Body, tmp_path: Path) -> None:
    """A mark of dots, each along its own normal, across several patches of the surface."""
    patch = fibonacci_directions(900)
    patch = patch[patch @ np.array([0.6, 0.6, 0.5]) > 0.925 * np.linalg.norm([0.6, 0.6, 0.5])]
    surface = InsetSurface(primary)
    feet, normals = surface.position_mm(patch), surface.normal(patch)
    dots = tuple(
        Cylinder(as_vector(foot - 0.4 * normal), as_vector(normal), 0.4, 1.4)
        for foot, normal in zip(feet, normals, strict=True)
    )
    hollow = HollowBody(primary, 3.0, openings=dots)
    solid = brep(hollow)
    assert len(dots) > 30
    assert len(solid.faces()) >= 12 + 2 * len(dots)
    assert problems_on_disk(tmp_path, solid, mesh(hollow, SAG_UM), Boundary.of_hollow(hollow), SAG_UM) == ()


def test_a_boss_that_occt_leaves_out_is_refused(primary: Body) -> None:
    """Its rim just touches the cavity's surface, at the end where OCCT finds no section at all."""
    large = primary.with_diameter(300.0)
    touching = Cylinder((0.0, 0.0, -140.0896536744836), (0.0, 0.0, -1.0), 30.0, 40.0)
    with pytest.raises(GeometryError, match="OCCT left out the boss"):
        brep(HollowBody(large, 6.0, bosses=(touching,)))
    clear = touching.moved((0.0, 0.0, 0.5))
    assert void_properties(HollowBody(large, 6.0, bosses=(clear,))).volume_mm3 > 0.0


def test_a_moved_boundary_is_the_boundary_of_the_moved_part(pod: HollowBody) -> None:
    lower = Boundary.of_hollow(pod).split(Seam((0.0, 0.0, 0.5), UP, (Cylinder(ORIGIN, UP, 9.0, 2.0, 8.0),)))[
        0
    ]
    shift = (3.0, -50.0, 7.0)
    points = np.random.default_rng(5).uniform(-8.0, 8.0, (50, 3)) - np.array([0.0, 0.0, 10.0])
    for here, there in zip(lower.surfaces(), lower.moved(shift).surfaces(), strict=True):
        assert there.outward == here.outward
        assert there.distance_mm(points + shift) == pytest.approx(here.distance_mm(points), abs=1e-9)


def test_a_hole_that_the_kernel_leaves_in_place_is_cut_again() -> None:
    """Cut with its seam line where OCCT puts it first, this one gives the whole body and a loose plug."""
    body = named_body("primary", 100.0)
    place = (45.4421173236856, 9.096128679265222, 17.486605519919774)
    axis = (0.8897918732592479, 0.15432166228827088, 0.42948253378965673)
    hollow = HollowBody(body, 3.0, openings=(Cylinder(place, axis, 0.4, 0.9),))
    taken = solid_mass(brep(replace(hollow, openings=()))).volume_mm3 - solid_mass(brep(hollow)).volume_mm3
    assert taken == pytest.approx(math.pi * 0.4**2 * 0.4, rel=0.01)
