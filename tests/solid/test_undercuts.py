"""Undercuts against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from manifold3d import Manifold

from gomboc_cad.solid.undercuts import undercuts
from tests.solid.manifolds import block, mesh_of, rod

UP, ALONG_X = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)
HOLE_DEPTH = math.sqrt(30.0**2 - 3.0**2) - 20.0


def ball() -> Manifold:
    return Manifold.sphere(30.0, 128)


def side_hole() -> Manifold:
    """A rod of radius 3 mm along x, from x = 20 mm outwards."""
    return rod(3.0, 30.0, 64).rotate([0.0, 90.0, 0.0]).translate([35.0, 0.0, 0.0])


direction = st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1)


@settings(max_examples=10, deadline=None)
@given(direction)
def test_a_convex_part_has_none_in_any_direction(along: tuple[float, float, float]) -> None:
    found = undercuts(mesh_of(ball()), along, samples=5_000)
    assert (found.area_mm2, found.share, found.deepest_mm, found.places) == (0.0, 0.0, 0.0, ())


def test_a_block_with_upright_walls_and_pockets_from_both_sides_has_none() -> None:
    pocket = block(20.0, 10.0, 10.0)
    part = block(40.0, 30.0, 20.0) - pocket.translate([0.0, 0.0, 8.0]) - pocket.translate([3.0, 2.0, -9.0])
    assert undercuts(mesh_of(part), UP).area_mm2 == 0.0


def test_a_side_hole_is_an_undercut_as_a_whole() -> None:
    """A blind hole of radius a and depth L to its rim has the area 2 π a L + π a²."""
    found = undercuts(mesh_of(ball() - side_hole()), UP)
    assert found.area_mm2 == pytest.approx(2.0 * math.pi * 3.0 * HOLE_DEPTH + 9.0 * math.pi, rel=0.03)
    assert found.share == pytest.approx(found.area_mm2 / (4.0 * math.pi * 900.0), rel=0.03)
    assert len(found.places) == 1
    assert found.places[0].area_mm2 == pytest.approx(found.area_mm2)


def test_a_slide_has_to_be_drawn_as_far_as_a_side_hole_is_deep() -> None:
    found = undercuts(mesh_of(ball() - side_hole()), UP)
    assert found.deepest_mm == pytest.approx(HOLE_DEPTH, abs=60.0 / 200.0)
    assert np.linalg.norm(np.subtract(found.places[0].position_mm, (20.0 + 0.5 * HOLE_DEPTH, 0, 0))) < 1.0


def test_a_side_hole_is_released_along_its_axis() -> None:
    assert undercuts(mesh_of(ball() - side_hole()), ALONG_X).area_mm2 == 0.0


def test_a_dumbbell_is_released_across_its_neck_and_not_along_it() -> None:
    """Two balls of radius r on a neck of radius a: their inner halves and the neck between them."""
    r, a, half = 15.0, 5.0, 20.0
    end = Manifold.sphere(r, 128)
    part = end.translate([0, 0, half]) + end.translate([0, 0, -half]) + rod(a, 2.0 * half)
    reach = math.sqrt(r**2 - a**2)
    inner = 2.0 * (2.0 * math.pi * r**2 - 2.0 * math.pi * r * (r - reach))
    found = undercuts(mesh_of(part), UP)
    assert found.area_mm2 == pytest.approx(inner + 2.0 * math.pi * a * 2.0 * (half - reach), rel=0.01)
    assert found.deepest_mm == pytest.approx(r - a, abs=0.3)
    assert undercuts(mesh_of(part), ALONG_X).area_mm2 == 0.0


def test_a_closed_cavity_is_an_undercut_in_every_direction_and_half_of_it_is_none() -> None:
    shell = ball() - Manifold.sphere(27.0, 128)
    found = undercuts(mesh_of(shell), (1.0, 2.0, 3.0))
    assert found.share == pytest.approx(27.0**2 / (27.0**2 + 30.0**2), rel=0.005)
    upper, lower = shell.split_by_plane([0.0, 0.0, 1.0], 0.0)
    assert undercuts(mesh_of(upper), UP).area_mm2 == undercuts(mesh_of(lower), UP).area_mm2 == 0.0


def test_separate_undercuts_are_told_apart_the_largest_first() -> None:
    small = rod(1.5, 30.0, 64).rotate([90.0, 0.0, 0.0]).translate([0.0, 35.0, 0.0])
    found = undercuts(mesh_of(ball() - side_hole() - small), UP)
    assert len(found.places) == 2
    assert found.places[0].position_mm[0] > 20.0
    assert found.places[1].position_mm[1] > 20.0
    assert found.places[0].area_mm2 > found.places[1].area_mm2


def test_areas_grow_with_the_square_of_the_size_and_do_not_turn_with_the_part() -> None:
    plain = undercuts(mesh_of(ball() - side_hole()), UP)
    turned = (ball() - side_hole()).rotate([0.0, 90.0, 0.0]).scale([2.0] * 3).translate([100.0, 50.0, -30.0])
    found = undercuts(mesh_of(turned), (2.0, 0.0, 0.0))
    assert found.area_mm2 == pytest.approx(4.0 * plain.area_mm2, rel=1e-6)
    assert found.deepest_mm == pytest.approx(2.0 * plain.deepest_mm, abs=0.7)
