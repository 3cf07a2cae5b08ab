"""Displaced halves and openings of bodies as made: closed forms on spheres, and meshes of the solids."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from gomboc_cad.body.sphere import unit
from gomboc_cad.equilibria import mesh_census
from gomboc_cad.equilibria.rim import mouths_mm
from gomboc_cad.products.openings.placed_opening import PlacedOpening
from gomboc_cad.solid.hollow import Cylinder
from gomboc_cad.tolerance.fast_census import judge, nominal_rest_direction
from gomboc_cad.tolerance.harmonics import form_error
from gomboc_cad.tolerance.variants import MONOSTABLE, MULTISTABLE, UNDECIDED, Nominal, SeamPlane, Variants
from tests.tolerance.bodies_as_made import (
    RADIUS_MM,
    ballasted_sphere,
    points_as_made,
    primary,
    random_variants,
    unchanged,
)


def parted(nominal, normal, origin=(0.0, 0.0, 0.0), openings=()):
    return Nominal(nominal.body, nominal.com_mm, SeamPlane(origin, normal), openings)


def displaced(nominal, com_mm, shift_mm):
    com = np.atleast_2d(np.asarray(com_mm, dtype=float))
    plain = unchanged(nominal, len(com), degree=4)
    return Variants(com, plain.stretch, plain.form_mm, np.broadcast_to(shift_mm, com.shape).astype(float))


def test_a_seam_without_displacement_changes_nothing():
    whole = primary()
    halves = parted(whole, (0.0, 0.0, 1.0))
    variants = random_variants(whole, 60, 1, form_mm=0.02, com_mm=0.05)
    one, other = judge(whole, variants), judge(halves, variants)
    assert np.array_equal(one.verdict, other.verdict)
    assert np.array_equal(one.stable, other.stable)
    assert np.allclose(one.tilt_deg, other.tilt_deg, atol=1e-7, equal_nan=True)


@pytest.mark.parametrize("step_mm", [0.02, 0.05, 0.1, 0.3])
def test_a_ballasted_sphere_stands_on_its_step(step_mm):
    """The half x > 0 of a sphere is lower by t; the COM is at (−e, 0, −s).

    The lower rim point and the sphere of the other half touch together at `cosθ = R / (R + t)`; that is the
    rest if the smooth rest `tanθ = e / s` would be nearer to the seam.
    """
    nominal = parted(ballasted_sphere(1.0), (1.0, 0.0, 0.0))
    com = (-0.05, 0.0, -1.0)
    outcome = judge(nominal, displaced(nominal, com, (0.0, 0.0, -step_mm)))
    on_step = np.degrees(np.arccos(RADIUS_MM / (RADIUS_MM + step_mm)))
    smooth = np.degrees(np.arctan2(0.05, 1.0))
    assert outcome.verdict.tolist() == [MONOSTABLE]
    assert outcome.tilt_deg[0] == pytest.approx(max(on_step, smooth), abs=1e-5)
    assert outcome.rest_direction[0, 0] < 0.0
    assert np.isinf(outcome.stiffness_mm[0, 1]) == (on_step > smooth)


@pytest.mark.parametrize("height_mm", [-0.1, 0.02, 0.15, 0.4])
def test_a_ballasted_sphere_rests_across_its_gap(height_mm):
    """Halves that are g apart carry the sphere with the foot of the COM between them."""
    gap = 0.2
    nominal = parted(Nominal(ballasted_sphere(1.0).body, (-1.0, 0.0, 0.0)), (0.0, 0.0, 1.0))
    outcome = judge(nominal, displaced(nominal, (-1.0, 0.0, height_mm), (0.0, 0.0, gap)))
    beside = min(height_mm, 0.0) + max(height_mm - gap, 0.0)
    assert outcome.verdict.tolist() == [MONOSTABLE]
    assert outcome.tilt_deg[0] == pytest.approx(np.degrees(np.arctan(abs(beside))), abs=1e-5)
    if 0.0 < height_mm < gap:
        assert outcome.stiffness_mm[0, 0] == pytest.approx(1.0, rel=1e-3)


def test_a_step_at_the_side_makes_a_second_rest():
    """The foot of the COM of a barely ballasted sphere is between two halves that are a step apart."""
    nominal = parted(ballasted_sphere(0.5), (0.0, 0.0, 1.0))
    # At (−1, 0, 0) the lower rim stands out: the touching points are sqrt(2 R t) apart, and seen from the
    # sphere that touches above the seam the foot is 0.5 mm below.
    enough = 0.5**2 / (2.0 * RADIUS_MM)
    steps = enough * np.array([0.8, 0.97, 1.03, 1.3, 30.0])
    shift = np.stack([steps, 0.0 * steps, 0.0 * steps], axis=1)
    plain = unchanged(nominal, len(steps))
    outcome = judge(nominal, Variants(plain.com_mm, plain.stretch, plain.form_mm, shift))
    assert np.array_equal(outcome.verdict == MULTISTABLE, steps > enough)
    assert np.all(outcome.s_margin_mm[:2] < 0.12)


@pytest.mark.slow
def test_meshes_of_displaced_halves_rest_likewise():
    nominal = parted(ballasted_sphere(1.0), (0.0, 0.0, 1.0), (0.0, 0.0, 2.0))
    variants = random_variants(nominal, 8, 5, form_mm=0.05, com_mm=0.3, shift_mm=0.2, degree=6)
    outcome = judge(nominal, variants)
    told = 0
    for row in range(len(variants)):
        solid = halves_as_made(nominal, variants, row)
        faces = ConvexHull(solid).simplices
        # The facets of the mesh make barriers of a few micrometres by themselves.
        census = mesh_census(
            solid, faces, variants.com_mm[row], sag_mm=0.0, barrier_mm=6e-3, probabilities=False
        )
        if census.stable > 1 and outcome.verdict[row] != UNDECIDED:
            told += 1
            assert outcome.verdict[row] == MULTISTABLE
        if outcome.verdict[row] == MONOSTABLE:
            assert np.dot(census.rest.direction, outcome.rest_direction[row]) > np.cos(np.radians(8.0))
    assert told > 2


def halves_as_made(nominal, variants, row):
    """Points of both halves with their rims, the upper one displaced."""
    normal, origin = np.array(nominal.seam.normal), np.array(nominal.seam.origin_mm)
    points, _ = points_as_made(nominal, variants, row, level=6)
    angles = np.linspace(0.0, 2.0 * np.pi, 4000, endpoint=False)
    rays = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
    rim = mouths_mm(nominal.body, origin, rays)
    above = (points - origin) @ normal
    lower, upper = points[above <= 0.0], points[above >= 0.0]
    return np.concatenate(
        [lower, rim, upper + variants.upper_shift_mm[row], rim + variants.upper_shift_mm[row]]
    )


def hole(direction, radius_mm, state="allowed"):
    axis = unit(np.array(direction, dtype=float))
    base = tuple((0.5 * RADIUS_MM * axis).tolist())
    tool = Cylinder(base, tuple(axis.tolist()), radius_mm, 0.6 * RADIUS_MM)
    mouth = tuple((RADIUS_MM * axis).tolist())
    return PlacedOpening("a hole", tool, radius_mm, radius_mm, tuple(axis.tolist()), mouth, state, 1.0, "")


def drilled(nominal, *openings):
    return Nominal(nominal.body, nominal.com_mm, None, openings)


def test_a_hole_at_the_side_is_a_rest_when_the_foot_of_the_com_is_in_it():
    nominal = drilled(ballasted_sphere(5.0), hole((1.0, 0.0, 0.0), 2.0))
    depth = np.array([2.5, 2.02, 1.98, 0.5])
    com = np.stack([0.0 * depth, 0.0 * depth, -depth], axis=1)
    outcome = judge(nominal, displaced(nominal, com, (0.0, 0.0, 0.0)))
    assert outcome.verdict.tolist() == [MONOSTABLE, MONOSTABLE, MULTISTABLE, MULTISTABLE]
    # The rim is a polygon of sixty corners.
    assert np.allclose(outcome.s_margin_mm[:2], depth[:2] - 2.0, atol=6e-3)
    plugged = drilled(ballasted_sphere(5.0), hole((1.0, 0.0, 0.0), 2.0, "plugged"))
    assert np.all(judge(plugged, displaced(plugged, com, (0.0, 0.0, 0.0))).verdict == MONOSTABLE)


def test_a_sphere_on_the_rim_of_a_hole():
    """The sphere rests beside the hole as well beyond `s a / R`, and only there beyond a."""
    nominal = drilled(ballasted_sphere(5.0), hole((0.0, 0.0, -1.0), 2.0, "rest"))
    aside = np.array([0.0, 0.19, 0.21, 1.9, 2.1])
    com = np.stack([aside, 0.0 * aside, 0.0 * aside - 5.0], axis=1)
    outcome = judge(nominal, displaced(nominal, com, (0.0, 0.0, 0.0)))
    assert np.allclose(nominal_rest_direction(nominal), (0.0, 0.0, -1.0), atol=1e-9)
    assert outcome.stable.tolist() == [1, 1, 2, 2, 1]
    assert np.allclose(outcome.tilt_deg[:2], 0.0, atol=1e-6)
    assert np.all(np.isinf(outcome.stiffness_mm[:2]))
    assert outcome.tilt_deg[4] == pytest.approx(np.degrees(np.arctan2(2.1, 5.0)), rel=1e-9)
    assert outcome.s_margin_mm[0] == pytest.approx(0.2, rel=0.01)


def test_a_form_error_at_the_rim_decides_like_a_mesh_of_the_hole():
    """A second-degree form error tilts the rim; the flat across it is then nearer to the foot of the COM."""
    nominal = drilled(ballasted_sphere(2.0), hole((1.0, 0.0, 0.0), 2.0))
    variants = random_variants(nominal, 20, 3, form_mm=0.3, com_mm=0.4, degree=4)
    smooth = judge(Nominal(nominal.body, nominal.com_mm), variants)
    outcome = judge(nominal, variants)
    added = 0
    for row in range(len(variants)):
        points, _ = points_as_made(nominal, variants, row, level=5)
        mouth = (points[:, 0] > 0.0) & (np.hypot(points[:, 1], points[:, 2]) < 2.0)
        ring = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
        near = unit(
            np.stack(
                [np.full_like(ring, np.sqrt(RADIUS_MM**2 - 4.0)), 2.0 * np.cos(ring), 2.0 * np.sin(ring)],
                axis=1,
            )
        )
        rim = rim_points(variants.form_mm[row], near)
        solid = np.concatenate([points[~mouth], rim])
        census = mesh_census(
            solid, ConvexHull(solid).simplices, variants.com_mm[row], sag_mm=0.0, probabilities=False
        )
        on_rim = any(
            e.kind == "stable" and e.direction[0] > 0.995 and e.barrier_mm > 3e-3 for e in census.equilibria
        )
        if on_rim and smooth.stable[row] == 1:
            added += 1
            assert outcome.stable[row] == 2
    assert added > 2


def rim_points(form_mm, near):
    """Points of the surface as made on the cylinder of radius 2 about the x-axis."""

    v = near
    for _ in range(20):
        value, gradient = form_error(v, form_mm)
        point = RADIUS_MM * v + gradient + value[:, None] * v
        wanted = 2.0 * unit(near[:, 1:])
        v = v.copy()
        v[:, 1:] += (wanted - point[:, 1:]) / RADIUS_MM
        v = unit(v)
    return point
