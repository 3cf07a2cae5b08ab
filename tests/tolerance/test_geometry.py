"""Variants built as geometry: spheres with every kind of error in closed form, the primary at its margin."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.body import Body, Harmonic, catalog, mass_properties
from gomboc_cad.body.mass import is_closed_mesh, mesh_mass
from gomboc_cad.body.sphere import fibonacci_directions, geodesic_triangulation, tangent_frame, unit
from gomboc_cad.equilibria import Census, com_margin, find_equilibria, mesh_census
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.openings.placed_opening import PlacedOpening, State, judged_opening
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.solid.hollow import Cylinder
from gomboc_cad.tolerance.geometry import MadePart
from gomboc_cad.tolerance.harmonics import coefficient_count
from gomboc_cad.tolerance.rebuilt import Rebuilt, as_made_mesh, rebuild, sampled_census
from gomboc_cad.tolerance.refinement import sample_part
from gomboc_cad.tolerance.variants import Nominal, SeamPlane, Variants
from tests.body.shapes import Array, real_harmonic

RADIUS = 50.0
SPHERE = Body("sphere", Harmonic(()), RADIUS)
PRIMARY = catalog()["primary"].with_diameter(2.0 * RADIUS)
CENTROID = mass_properties(PRIMARY).com_mm
SEAM = SeamPlane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
NO_SHIFT = (0.0, 0.0, 0.0)


def variant(
    com: Vector,
    *,
    stretch: Array | None = None,
    form: Array | None = None,
    shift: Vector = NO_SHIFT,
) -> Variants:
    return Variants(
        np.array([com]),
        (np.eye(3) if stretch is None else stretch)[None],
        np.empty((1, 0)) if form is None else form[None],
        np.array([shift]),
    )


def harmonic(degree: int, order: int, coefficient_mm: float, highest: int | None = None) -> Array:
    """Form error of one term alone."""
    form = np.zeros(coefficient_count(highest or degree))
    form[degree * degree - 4 + degree + order] = coefficient_mm
    return form


def census(nominal: Nominal, made: Variants, barrier_mm: float | None = None) -> Census:
    return sampled_census(sample_part(MadePart.of(nominal, made, 0), 1e-4), barrier_mm)


def assert_rests_at(found: Rebuilt, direction: Array, atol: float = 1e-9) -> None:
    assert (found.verdict, found.stable) == ("monostable", 1), found.reason
    np.testing.assert_allclose(found.rest_direction, direction, atol=atol)


# A sphere whose COM is lowered.


def test_a_sphere_rests_where_its_centre_of_mass_is() -> None:
    nominal = Nominal(SPHERE, (0.0, 0.0, -5.0))
    found = rebuild(nominal, variant((0.3, -0.4, -5.0)), 0)
    assert_rests_at(found, unit(np.array([0.3, -0.4, -5.0])))
    assert found.settled
    assert not found.dented
    assert found.tilt_deg == pytest.approx(math.degrees(math.atan2(0.5, 5.0)), abs=1e-7)
    assert found.barrier_mm < 2e-4


def test_the_hull_is_a_closed_mesh_of_the_part() -> None:
    nominal = Nominal(SPHERE, (0.0, 0.0, -5.0))
    vertices, faces = as_made_mesh(nominal, variant(nominal.com_mm, stretch=np.diag([1.01, 1.0, 0.99])), 0)
    assert is_closed_mesh(faces, len(vertices))
    mass = mesh_mass(vertices, faces)
    sphere = 4.0 / 3.0 * math.pi * RADIUS**3
    assert 0.999 < mass.volume_mm3 / (1.01 * 0.99 * sphere) < 1.0
    np.testing.assert_allclose(mass.com_mm, 0.0, atol=1e-3)
    np.testing.assert_allclose(np.abs(vertices).max(axis=0), [50.5, 50.0, 49.5], atol=2e-2)


# Shrinkage and form error, whose support functions are known.


@settings(max_examples=3, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_a_stretched_sphere_is_an_ellipsoid(seed: int) -> None:
    """Its heights are the semi-axes, wherever they point: two rests, and the middle one is the pass."""
    axes = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    stretch = axes @ np.diag([1.1, 1.0, 0.88]) @ axes.T
    found = census(Nominal(SPHERE, NO_SHIFT), variant(NO_SHIFT, stretch=stretch))
    assert (found.verdict, found.stable, found.unstable, found.saddles) == ("multistable", 2, 2, 2)
    heights = [e.height_mm for e in found.equilibria]
    np.testing.assert_allclose(heights, [44.0, 44.0, 50.0, 50.0, 55.0, 55.0], atol=2e-4)
    for pose in found.equilibria[:2]:
        assert pose.barrier_mm == pytest.approx(6.0, abs=2e-4)
        assert abs(axes[:, 2] @ np.array(pose.direction)) == pytest.approx(1.0, abs=1e-5)


def test_a_form_error_of_two_undulations() -> None:
    """`a Y_22 = a √15/2 (x² − y²)`: rests at ±y, tops at ±x, saddles at ±z, where it vanishes."""
    found = census(Nominal(SPHERE, NO_SHIFT), variant(NO_SHIFT, form=harmonic(2, 2, 2.0)))
    swing = 2.0 * math.sqrt(15.0) / 2.0
    heights = [e.height_mm - RADIUS for e in found.equilibria]
    np.testing.assert_allclose(heights, [-swing, -swing, 0.0, 0.0, swing, swing], atol=2e-4)
    assert abs(found.equilibria[0].direction[1]) == pytest.approx(1.0, abs=1e-5)
    assert found.equilibria[0].barrier_mm == pytest.approx(swing, abs=2e-4)


@settings(max_examples=5, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_the_support_function_is_that_of_the_body_and_the_form_error(seed: int) -> None:
    rng = np.random.default_rng(seed)
    form = rng.normal(scale=5e-3, size=coefficient_count(5))
    part = MadePart.of(Nominal(SPHERE, NO_SHIFT), variant(NO_SHIFT, form=form), 0)
    points = part.at(fibonacci_directions(500))
    terms = [(degree, m) for degree in range(2, 6) for m in range(-degree, degree + 1)]
    delta = sum(
        c * math.sqrt(4.0 * math.pi) * real_harmonic(*term, points.normal)
        for c, term in zip(form, terms, strict=True)
    )
    heights = points.position_mm @ points.normal.T
    np.testing.assert_allclose(np.diag(heights), RADIUS + delta, atol=1e-11)
    assert np.all(heights.max(axis=0) <= np.diag(heights) + 1e-11)


@pytest.mark.parametrize(("share", "dented"), [(0.95, False), (1.1, True)])
def test_a_form_error_too_rough_for_a_convex_part(share: float, dented: bool) -> None:
    """`A cos 16φ` on the equator leaves the curvature radius `R − 255 A`; above that the part has dents."""
    at_equator = math.sqrt(4.0 * math.pi) * real_harmonic(16, 16, np.array([[1.0, 0.0, 0.0]]))[0]
    form = harmonic(16, 16, share * RADIUS / 255.0 / at_equator)
    nominal, made = Nominal(SPHERE, (0.0, 0.0, -5.0)), variant((0.0, 0.0, -5.0), form=form)
    sampled = sample_part(MadePart.of(nominal, made, 0), 1e-2, max_points=12_000)
    assert sampled.part.dented is dented


def test_the_normals_of_a_part_with_dents() -> None:
    """Against those of the surface `r = R + δ`, by differences."""
    form = harmonic(9, 4, 0.5)
    part = replace(MadePart.of(Nominal(SPHERE, NO_SHIFT), variant(NO_SHIFT, form=form), 0), dented=True)
    u = fibonacci_directions(200)
    one, other = tangent_frame(u)
    step = 1e-5

    def along(axis: Array) -> Array:
        ahead, behind = (part.at(unit(u + sign * step * axis)).position_mm for sign in (1.0, -1.0))
        return (ahead - behind) / (2.0 * step)

    expected = unit(np.cross(along(one), along(other)))
    expected *= np.sign((expected * u).sum(axis=1))[:, None]
    np.testing.assert_allclose(part.at(u).normal, expected, atol=1e-6)
    radius = np.linalg.norm(part.at(u).position_mm, axis=1)
    delta = 0.5 * math.sqrt(4.0 * math.pi) * real_harmonic(9, 4, u)
    np.testing.assert_allclose(radius, RADIUS + delta, atol=1e-11)


# Halves that do not meet.


@pytest.mark.parametrize(
    ("com_height", "expected"),
    [(-0.5, (5.0, -0.5)), (0.2, (1.0, 0.0)), (0.9, (5.0, 0.5))],
    ids=["on the lower half", "on the band between", "on the upper half"],
)
def test_halves_with_a_gap(com_height: float, expected: tuple[float, float]) -> None:
    """Between the halves the hull is a cylinder as high as the gap; above, the sphere's centre is higher."""
    com = (5.0, 0.0, com_height)
    found = rebuild(Nominal(SPHERE, com, SEAM), variant(com, shift=(0.0, 0.0, 0.4)), 0)
    across, up = expected
    assert_rests_at(found, unit(np.array([across, 0.0, up])), 1e-9 if up else 2e-3)


def stepped(step_mm: float, seam: SeamPlane = SEAM, com: Vector = (5.0, 0.0, 0.0)) -> Rebuilt:
    return rebuild(Nominal(SPHERE, com, seam), variant(com, shift=(step_mm, 0.0, 0.0)), 0)


def test_a_step_is_bridged_from_the_rim_to_the_other_half() -> None:
    """From the rim at R + d the strip is tangent to the sphere of radius R at ε, `cosε = R/(R + d)`."""
    found = stepped(0.1)
    angle = math.acos(RADIUS / (RADIUS + 0.1))
    assert_rests_at(found, np.array([math.cos(angle), 0.0, -math.sin(angle)]), 2e-3)
    assert not found.settled
    assert found.tilt_deg == pytest.approx(math.degrees(angle), abs=0.1)


@pytest.mark.parametrize(
    ("foot", "expected"),
    [(-0.2, None), (0.1, "strip"), (3.4, None)],
    ids=["below the strip", "at its lower end", "above it"],
)
def test_the_ends_of_the_strip(foot: float, expected: str | None) -> None:
    """The strip is `(R + d) sinε` = 3.16 mm wide; beyond its ends the product rests on one of the spheres."""
    angle = math.acos(RADIUS / (RADIUS + 0.1))
    down = np.array([math.cos(angle), 0.0, -math.sin(angle)])
    along = np.array([math.sin(angle), 0.0, math.cos(angle)])
    com = 5.0 * down + foot * along
    found = stepped(0.1, com=as_vector(com))
    if expected is None:
        own_center = np.array([0.1, 0.0, 0.0]) if foot > 0.0 else np.zeros(3)
        assert_rests_at(found, unit(com - own_center))
        assert found.settled
    else:
        assert_rests_at(found, down, 2e-3)


def test_a_strip_and_a_sphere_may_both_hold_the_product() -> None:
    """At the upper end of the strip the product also rests above it; the barrier between them is the rim."""
    angle = math.acos(RADIUS / (RADIUS + 0.1))
    com = 5.0 * np.array([math.cos(angle), 0.0, -math.sin(angle)])
    com += 3.0 * np.array([math.sin(angle), 0.0, math.cos(angle)])
    nominal, made = Nominal(SPHERE, as_vector(com), SEAM), variant(as_vector(com), shift=(0.1, 0.0, 0.0))
    found = census(nominal, made)
    assert (found.verdict, found.stable) == ("multistable", 2)
    deep, strip = (pose for pose in found.equilibria if pose.kind == "stable")
    np.testing.assert_allclose(deep.direction, unit(com - [0.1, 0.0, 0.0]), atol=2e-3)
    height = RADIUS - 5.0
    assert strip.height_mm == pytest.approx(height, abs=2e-4)
    to_rim = (RADIUS + 0.1) * math.sin(angle) - 3.0
    assert strip.barrier_mm == pytest.approx(math.hypot(height, to_rim) - height, abs=2e-4)


def test_swapped_halves_and_a_step_to_the_other_side_are_told() -> None:
    swapped = stepped(0.1, SeamPlane(SEAM.origin_mm, (0.0, 0.0, -1.0)))
    other_way = stepped(-0.1)
    for damaged in (swapped, other_way):
        assert damaged.rest_direction is not None
        assert damaged.rest_direction[2] > 0.06  # the strip of the right part faces the other way: −0.063


def test_a_seam_without_a_step_changes_nothing() -> None:
    com = (0.0, 3.0, -4.0)
    whole, parted = (rebuild(Nominal(SPHERE, com, seam), variant(com), 0) for seam in (None, SEAM))
    assert whole == parted


def test_a_seam_that_misses_the_part_is_refused() -> None:
    beside = SeamPlane((0.0, 0.0, 60.0), (0.0, 0.0, 1.0))
    with pytest.raises(GeometryError, match="does not cut"):
        stepped(0.1, beside)


# Holes.


def drilled(radius_mm: float, polar_deg: float = 60.0, state: State = "allowed") -> PlacedOpening:
    axis = np.array([math.sin(math.radians(polar_deg)), 0.0, math.cos(math.radians(polar_deg))])
    tool = Cylinder(as_vector(40.0 * axis), as_vector(axis), radius_mm, 12.0)
    place = as_vector(RADIUS * axis)
    return PlacedOpening("port", tool, radius_mm, None, as_vector(axis), place, state, None, "")


def on_a_drilled_sphere(opening: PlacedOpening) -> Rebuilt:
    com = (0.0, 0.0, -5.0)
    return rebuild(Nominal(SPHERE, com, openings=(opening,)), variant(com), 0)


def test_a_hole_is_a_rest_once_the_foot_falls_into_it() -> None:
    """About a COM lowered by s the foot is `s sinθ` from the middle of a hole at the polar angle θ."""
    foot = 5.0 * math.sin(math.radians(60.0))
    assert_rests_at(on_a_drilled_sphere(drilled(0.97 * foot)), np.array([0.0, 0.0, -1.0]))
    wide = on_a_drilled_sphere(drilled(1.1 * foot))
    assert (wide.verdict, wide.stable) == ("multistable", 2)
    assert on_a_drilled_sphere(drilled(1.1 * foot, state="plugged")).verdict == "monostable"


@pytest.mark.parametrize(("share", "stable"), [(0.998, 1), (1.002, 2)])
def test_a_rest_on_a_rim_is_told_however_shallow(share: float, stable: int) -> None:
    found = on_a_drilled_sphere(drilled(share * 5.0 * math.sin(math.radians(60.0))))
    assert found.stable == stable
    assert found.verdict == ("monostable" if stable == 1 else "multistable")
    if stable == 2:
        assert "rim of a hole, with a barrier of" in found.reason


def test_an_error_of_the_centre_of_mass_brings_the_foot_into_a_hole() -> None:
    hole = drilled(0.97 * 5.0 * math.sin(math.radians(60.0)))
    nominal = Nominal(SPHERE, (0.0, 0.0, -5.0), openings=(hole,))
    assert rebuild(nominal, variant((0.0, 0.0, -4.6)), 0).stable == 2


def test_a_hole_at_the_rest_carries_the_product_on_its_rim() -> None:
    found = on_a_drilled_sphere(drilled(2.0, 180.0, "rest"))
    assert_rests_at(found, np.array([0.0, 0.0, -1.0]), 1e-9)
    assert not found.settled


@pytest.mark.parametrize(("share", "verdict"), [(0.9, "monostable"), (1.3, "multistable")])
def test_a_hole_in_the_flank_of_the_primary(share: float, verdict: str) -> None:
    frame = RestFrame.from_rest(find_equilibria(PRIMARY, CENTROID)[0].direction)
    place = PRIMARY.surface(unit(np.array([[0.5, -0.5, 0.7]])))
    base = place.position_mm[0] - 10.0 * place.normal[0]

    def hole(radius: float) -> PlacedOpening:
        tool = Cylinder(as_vector(base), as_vector(place.normal[0]), radius, 20.0)
        return judged_opening(PRIMARY, CENTROID, "port", tool, frame=frame)

    allowed = hole(1.0).allowed_radius_mm
    assert allowed is not None
    nominal = Nominal(PRIMARY, CENTROID, openings=(hole(share * allowed),))
    assert rebuild(nominal, variant(CENTROID), 0).verdict == verdict


# The primary.


@pytest.mark.parametrize(("share", "verdict"), [(0.9, "monostable"), (1.3, "multistable")])
def test_the_primary_just_inside_and_outside_of_its_margin(share: float, verdict: str) -> None:
    """Towards the nearest place where the COM makes a new rest, which another method has found."""
    witness = np.array(com_margin(PRIMARY, CENTROID).s_witness_mm)
    com = as_vector(np.array(CENTROID) + share * (witness - np.array(CENTROID)))
    found = rebuild(Nominal(PRIMARY, CENTROID), variant(com), 0)
    assert found.verdict == verdict
    assert found.settled
    rest = find_equilibria(PRIMARY, com)[0].direction
    np.testing.assert_allclose(found.rest_direction, rest, atol=1e-7)


def test_points_where_they_matter_find_the_rests_that_points_all_over_find() -> None:
    """With rough variants of the primary, whose barriers range from nothing to a tenth of a millimetre."""
    rng = np.random.default_rng(5)
    u, faces = geodesic_triangulation(5)
    nominal, barrier, rests = Nominal(PRIMARY, CENTROID), 0.04, 0
    for _ in range(3):
        form = rng.normal(scale=5e-3, size=coefficient_count(8))
        com = as_vector(np.array(CENTROID) + rng.normal(scale=0.1, size=3))
        made = variant(com, form=form)
        points = MadePart.of(nominal, made, 0).at(u).position_mm

        def stable_all_over(barrier_mm: float, points: Array = points, com: Vector = com) -> int:
            return mesh_census(points, faces, com, barrier_mm=barrier_mm, probabilities=False).stable

        sampled = sample_part(MadePart.of(nominal, made, 0), 5e-4)
        found = sampled_census(sampled, barrier).stable
        # The even points have a sag of 10 to 20 µm.
        assert stable_all_over(barrier + 0.02) <= found <= stable_all_over(barrier - 0.02)
        rests += found
    assert rests > 6


def test_where_points_run_short_the_barrier_says_so() -> None:
    part = MadePart.of(Nominal(PRIMARY, CENTROID), variant(CENTROID), 0)
    sampled = sample_part(part, 1e-6, max_points=30_000)
    assert len(sampled.points_mm) <= 30_000
    assert sampled.sag_mm > 1e-4
