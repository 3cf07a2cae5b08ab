"""The thinnest wall against closed forms, and against walls that were made thin on purpose."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from manifold3d import CrossSection, Manifold

from gomboc_cad.solid.hollow import HollowBody, Seam, mesh, split_mesh
from gomboc_cad.solid.mesh import Mesh
from gomboc_cad.solid.wall import WallThickness, thinnest_wall
from tests.solid.conftest import ORIGIN, reference_hollow
from tests.solid.manifolds import block, mesh_of, rod

SHIFT = np.array([0.3, 0.4, 0.0])


def shell() -> Manifold:
    """A wall of 3 mm whose cavity is shifted by 0.5 mm."""
    return Manifold.sphere(30.0, 200) - Manifold.sphere(27.0, 200).translate(SHIFT.tolist())


@pytest.fixture(scope="module")
def shifted_shell() -> WallThickness:
    return thinnest_wall(mesh_of(shell()))


def test_a_shifted_cavity_leaves_the_wall_less_the_shift(shifted_shell: WallThickness) -> None:
    # The facets of both spheres stand off them by at most 4 µm.
    assert shifted_shell.min_mm == pytest.approx(2.5, abs=0.005)


def test_the_thinnest_place_is_where_the_cavity_moved_to(shifted_shell: WallThickness) -> None:
    place, opposite = np.array(shifted_shell.place_mm), np.array(shifted_shell.opposite_mm)
    assert np.linalg.norm(place - opposite) == pytest.approx(shifted_shell.min_mm, rel=1e-3)
    # The wall is 2.5 + 0.5 (1 − cos φ) mm thick at the angle φ, so a difference of 4 µm is one of 7°.
    outer = max(place, opposite, key=np.linalg.norm)
    assert outer @ SHIFT / np.linalg.norm(outer) / 0.5 > math.cos(math.radians(10.0))


@pytest.mark.parametrize(
    ("part", "thickness"),
    [
        (lambda: block(40.0, 30.0, 20.0), 20.0),
        (lambda: block(40.0, 30.0, 20.0) - block(30.0, 20.0, 16.0).translate([2.0, 0.5, 0.4]), 1.6),
        (lambda: block(40.0, 30.0, 20.0) - block(50.0, 1.0, 16.0).translate([0.0, 13.8, 0.0]), 0.7),
        (lambda: rod(3.0, 25.0, 400) - rod(1.6, 30.0, 400), 1.4),
        (lambda: rod(10.0, 0.6), 0.6),
    ],
    ids=["block", "box", "slot", "standoff", "disc"],
)
def test_parts_with_sharp_edges_have_the_thickness_of_their_walls(
    part: Callable[[], Manifold], thickness: float
) -> None:
    assert thinnest_wall(mesh_of(part())).min_mm == pytest.approx(thickness, rel=1e-3)


def wedge(opening_deg: float) -> Mesh:
    """A wedge 20 mm long from its edge to its back."""
    half = 20.0 * math.tan(math.radians(0.5 * opening_deg))
    return mesh_of(CrossSection([[(0.0, 0.0), (20.0, -half), (20.0, half)]]).extrude(15.0))


def test_a_feather_edge_is_a_wall_of_no_thickness_and_a_blunt_edge_is_none() -> None:
    assert thinnest_wall(wedge(20.0)).min_mm < 0.1
    assert thinnest_wall(wedge(45.0)).min_mm > 1.0


@pytest.mark.parametrize("left_mm", [0.2, 0.05])
def test_a_thin_spot_of_a_millimetre_is_found_in_a_large_part(left_mm: float) -> None:
    """A drill that went almost through a wall of 3 mm."""
    drilled = shell() - rod(0.5, 3.0 - left_mm, 48).translate([0.0, 0.0, 27.0 + 0.5 * (3.0 - left_mm) - 0.01])
    found = thinnest_wall(mesh_of(drilled))
    assert found.min_mm < 0.3
    assert np.linalg.norm(np.array(found.place_mm)[:2]) < 0.6


def test_the_thickness_scales_with_the_part_and_does_not_turn_with_it() -> None:
    part = block(40.0, 30.0, 20.0) - block(30.0, 20.0, 16.0).translate([2.0, 0.5, 0.4])
    plain = thinnest_wall(mesh_of(part), samples=20_000)
    moved = part.rotate([31.0, 17.0, 59.0]).scale([3.0, 3.0, 3.0]).translate([400.0, -50.0, 7.0])
    found = thinnest_wall(mesh_of(moved), samples=20_000)
    assert found.min_mm == pytest.approx(3.0 * plain.min_mm, rel=1e-6)
    assert found.spacing_mm == pytest.approx(3.0 * plain.spacing_mm, rel=1e-9)


def test_halves_of_a_hollow_body_are_thinnest_where_the_model_says(primary) -> None:
    """Standoffs of 5.5 mm with holes of 3.2 mm, and bosses of 7 mm with holes of 3 mm: 1.15 and 2 mm."""
    hollow: HollowBody = reference_hollow(primary)
    whole = mesh(hollow, 50.0)
    lower, upper = split_mesh(whole, Seam(ORIGIN, (1.0, 0.0, 0.0)), 50.0)
    # Both the hole's and the standoff's facets may be off by the sag.
    assert thinnest_wall(lower).min_mm == pytest.approx(1.15, abs=0.1)
    assert thinnest_wall(upper).min_mm == pytest.approx(2.0, abs=0.1)


def test_a_wall_may_be_thinnest_at_an_edge_of_a_hole() -> None:
    """A slanting blind hole comes nearest to the underside with the lowest point of its end."""
    tilt, depth, radius = math.radians(30.0), 12.0, 2.0
    hole = rod(radius, 2.0 * depth, 400).rotate([30.0, 0.0, 0.0]).translate([0.0, 0.0, 7.0])
    left = 14.0 - depth * math.cos(tilt) - radius * math.sin(tilt)
    found = thinnest_wall(mesh_of(block(60.0, 60.0, 14.0) - hole))
    assert found.min_mm == pytest.approx(left, abs=1e-3)
    assert min(found.place_mm[2], found.opposite_mm[2]) == pytest.approx(-7.0)
