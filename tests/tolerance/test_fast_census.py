"""The fast census of bodies as made: against closed forms, the smooth census, and meshes of the solids."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gomboc_cad.body.mass import sphere_quadrature
from gomboc_cad.body.sphere import tangent_frame
from gomboc_cad.equilibria import com_margin, find_equilibria, mesh_census, smooth_census
from gomboc_cad.equilibria.margin import s_margin_mm
from gomboc_cad.tolerance.fast_census import judge, nominal_rest_direction
from gomboc_cad.tolerance.harmonics import coefficient_count, form_error, harmonic_jets
from gomboc_cad.tolerance.variants import MONOSTABLE, MULTISTABLE, UNDECIDED, Variants
from tests.tolerance.bodies_as_made import (
    RADIUS_MM,
    ballasted_sphere,
    points_as_made,
    primary,
    random_variants,
    unchanged,
    with_com,
)


@pytest.fixture(scope="module")
def gomboc():
    return primary()


def projected(function, degree):
    """Coefficients of a function of normals (n, 3), without degrees 0 and 1."""
    normals, weights = sphere_quadrature(40)
    harmonics = harmonic_jets(normals, np.stack(tangent_frame(normals), axis=1), degree)[0]
    return harmonics @ (weights * function(normals)) / (4.0 * np.pi)


def test_without_errors_everything_is_as_designed(gomboc):
    outcome = judge(gomboc, unchanged(gomboc, 3, degree=16))
    census = smooth_census(gomboc.body, gomboc.com_mm)
    assert outcome.verdict.tolist() == [MONOSTABLE] * 3
    assert outcome.stable.tolist() == [1] * 3
    assert np.allclose(outcome.tilt_deg, 0.0, atol=1e-6)
    assert np.allclose(outcome.s_margin_mm, census.margin.s_margin_mm, rtol=2e-3)
    assert np.allclose(outcome.stiffness_mm, census.rest.stiffness_mm, rtol=1e-9)
    assert np.allclose(outcome.rest_direction, nominal_rest_direction(gomboc), atol=1e-9)


@pytest.mark.parametrize("lowering_mm", [0.05, 0.5, 5.0])
def test_a_ballasted_sphere_rests_below_its_com(lowering_mm):
    """All focal points are the centre, whose distance is the S-margin and the stiffness."""
    nominal = ballasted_sphere(lowering_mm)
    shifts = lowering_mm * np.random.default_rng(1).normal(size=(40, 3)) * 0.4
    com = np.array(nominal.com_mm) + shifts
    outcome = judge(nominal, with_com(nominal, com))
    away = np.linalg.norm(com, axis=1)
    assert np.all(outcome.verdict == MONOSTABLE)
    assert np.allclose(outcome.s_margin_mm, away, rtol=1e-9)
    assert np.allclose(outcome.stiffness_mm, away[:, None], rtol=1e-9)
    tilt = np.degrees(np.arctan2(np.hypot(com[:, 0], com[:, 1]), -com[:, 2]))
    assert np.allclose(outcome.tilt_deg, tilt, rtol=1e-9)


def test_uniform_shrinkage_changes_nothing_but_the_size(gomboc):
    plain = unchanged(gomboc, 1)
    shrunk = Variants(0.98 * plain.com_mm, 0.98 * plain.stretch, plain.form_mm, plain.upper_shift_mm)
    one, other = judge(gomboc, plain), judge(gomboc, shrunk)
    assert np.allclose(other.s_margin_mm, 0.98 * one.s_margin_mm, rtol=1e-6)
    assert np.allclose(other.stiffness_mm, 0.98 * one.stiffness_mm, rtol=1e-9)
    assert np.allclose(other.tilt_deg, 0.0, atol=1e-6)


def test_an_ellipsoid_loses_its_upper_rest_where_the_curvature_says():
    """With half-axes a ≥ b ≥ c the upper pole is a rest while the COM is nearer to it than b²/c."""
    nominal = ballasted_sphere(1.0)
    axes = np.array([1.02, 1.01, 0.99])
    a, b, c = RADIUS_MM * axes
    threshold = b * b / c - c
    lowering = threshold * np.array([0.0, 0.5, 0.99, 0.9999, 1.0001, 1.01, 2.0])
    plain = unchanged(nominal, len(lowering))
    com = np.stack([np.zeros_like(lowering), np.zeros_like(lowering), -lowering], axis=1)
    outcome = judge(nominal, Variants(com, plain.stretch * axes, plain.form_mm, plain.upper_shift_mm))
    below = lowering < threshold
    assert np.array_equal(outcome.verdict == MULTISTABLE, below)
    assert np.array_equal(outcome.stable == 2, below)
    assert np.allclose(outcome.rest_direction, [0.0, 0.0, -1.0], atol=1e-7) or lowering[0] == 0.0
    lower_pole = np.stack([b * b / c - c + lowering, a * a / c - c + lowering], axis=1)
    assert np.allclose(outcome.stiffness_mm[~below], lower_pole[~below], rtol=1e-9)
    # The COM is on the axis of the focal surface's cusp, so the cusp is as near as the margin can be told to
    # be.
    assert np.all(outcome.s_margin_mm[~below] <= (lowering - threshold)[~below] + 1e-3)
    assert np.all(outcome.s_margin_mm[below] == 0.0)


def test_a_stretched_sphere_is_a_form_error_and_the_other_way_round():
    """The support function of an ellipsoid is `R |S u|`; its harmonics are judged by other code."""
    nominal = ballasted_sphere(0.8)
    rng = np.random.default_rng(5)
    stretch, forms, coms = [], [], []
    for _ in range(12):
        turn = Rotation.random(random_state=rng).as_matrix()
        matrix = turn @ np.diag(1.0 + 0.012 * rng.normal(size=3)) @ turn.T
        size = RADIUS_MM * np.linalg.norm(sphere_quadrature(40)[0] @ matrix, axis=1)
        mean = (size * sphere_quadrature(40)[1]).sum() / (4.0 * np.pi)
        # The sphere keeps its radius, so the mean change of size goes to the stretch.
        matrix = matrix * RADIUS_MM / mean
        stretch.append(matrix)
        forms.append(projected(lambda v, m=matrix: RADIUS_MM * np.linalg.norm(v @ m, axis=1), 10))
        coms.append(np.array(nominal.com_mm) + 0.2 * rng.normal(size=3))
    plain = unchanged(nominal, 12, degree=10)
    as_stretch = judge(
        nominal, Variants(np.array(coms), np.array(stretch), plain.form_mm, plain.upper_shift_mm)
    )
    as_form = judge(nominal, Variants(np.array(coms), plain.stretch, np.array(forms), plain.upper_shift_mm))
    assert np.array_equal(as_stretch.verdict, as_form.verdict)
    assert np.array_equal(as_stretch.stable, as_form.stable)
    assert 0 < np.count_nonzero(as_form.verdict == MONOSTABLE) < 12
    assert np.allclose(as_stretch.tilt_deg, as_form.tilt_deg, atol=1e-5)
    assert np.allclose(as_stretch.s_margin_mm, as_form.s_margin_mm, rtol=5e-3, atol=1e-4)
    assert np.allclose(as_stretch.stiffness_mm, as_form.stiffness_mm, atol=1e-6)


def test_the_com_may_move_by_the_margin_and_not_farther(gomboc):
    margin = com_margin(gomboc.body, gomboc.com_mm)
    way = np.array(margin.s_witness_mm) - np.array(gomboc.com_mm)
    shares = np.array([0.5, 0.9, 0.99, 0.999, 1.001, 1.01, 1.1])
    outcome = judge(gomboc, with_com(gomboc, np.array(gomboc.com_mm) + shares[:, None] * way))
    assert np.all(outcome.verdict[:4] == MONOSTABLE)
    # So near to the change the second rest has a barrier that rounding cannot tell.
    assert outcome.verdict[4] != MONOSTABLE
    assert np.all(outcome.verdict[5:] == MULTISTABLE)
    left = (1.0 - shares)[:4] * margin.s_margin_mm
    assert np.all(outcome.s_margin_mm[:4] <= left * (1.0 + 1e-3))
    assert np.all(outcome.s_margin_mm[5:] == 0.0)


def test_com_shifts_agree_with_the_smooth_census(gomboc):
    rng = np.random.default_rng(3)
    com = np.array(gomboc.com_mm) + 0.15 * rng.normal(size=(60, 3))
    outcome = judge(gomboc, with_com(gomboc, com))
    assert 10 < np.count_nonzero(outcome.verdict == MONOSTABLE) < 55
    for row, center in enumerate(com):
        rests = [e for e in find_equilibria(gomboc.body, center) if e.kind == "stable"]
        assert (outcome.verdict[row] == MONOSTABLE) == (len(rests) == 1)
        if len(rests) == 1:
            assert np.allclose(outcome.rest_direction[row], rests[0].direction, atol=1e-8)
            assert np.allclose(outcome.stiffness_mm[row], rests[0].stiffness_mm, rtol=1e-6)


@pytest.mark.slow
def test_s_margins_agree_with_the_global_search(gomboc):
    rng = np.random.default_rng(4)
    com = np.array(gomboc.com_mm) + 0.06 * rng.normal(size=(8, 3))
    outcome = judge(gomboc, with_com(gomboc, com))
    for row in np.flatnonzero(outcome.verdict == MONOSTABLE):
        expected = s_margin_mm(gomboc.body, com[row])
        assert outcome.s_margin_mm[row] == pytest.approx(expected, rel=0.02)


def test_outcomes_do_not_depend_on_the_company(gomboc):
    variants = random_variants(gomboc, 700, 7, form_mm=0.03, com_mm=0.03, stretch=3e-4)
    whole = judge(gomboc, variants)
    rows = np.random.default_rng(0).permutation(700)[:90]
    some = judge(gomboc, variants.rows(rows))
    alone = judge(gomboc, variants.rows(rows[:1]))
    for name in ("verdict", "stable", "rest_direction", "tilt_deg", "s_margin_mm", "stiffness_mm"):
        column = getattr(whole, name)
        assert np.array_equal(column[rows], getattr(some, name), equal_nan=True), name
        assert np.array_equal(column[rows[:1]], getattr(alone, name), equal_nan=True), name


def test_turning_everything_turns_the_outcome():
    """A sphere with a form error, judged on cells that do not turn with it."""
    nominal = ballasted_sphere(1.0)
    variants = random_variants(nominal, 10, 11, form_mm=0.25, com_mm=0.3, degree=8)
    turn = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
    forms = np.stack(
        [projected(lambda v, c=c: form_error(v @ turn, c).value_mm, 8) for c in variants.form_mm]
    )
    turned = Variants(variants.com_mm @ turn.T, variants.stretch, forms, variants.upper_shift_mm)
    one, other = judge(nominal, variants), judge(nominal, turned)
    assert np.array_equal(one.verdict, other.verdict)
    assert 0 < np.count_nonzero(one.verdict == MONOSTABLE) < 10
    single = one.verdict == MONOSTABLE
    assert np.allclose((one.rest_direction @ turn.T)[single], other.rest_direction[single], atol=1e-7)
    assert np.allclose(one.s_margin_mm, other.s_margin_mm, rtol=0.02, atol=1e-9)


def test_a_surface_that_is_not_convex_is_undecided(gomboc):
    form = np.zeros((2, coefficient_count(16)))
    form[1, -1] = 1.0
    plain = unchanged(gomboc, 2)
    outcome = judge(gomboc, Variants(plain.com_mm, plain.stretch, form, plain.upper_shift_mm))
    assert outcome.verdict.tolist() == [MONOSTABLE, UNDECIDED]


def test_no_variants_give_no_outcomes(gomboc):
    outcome = judge(gomboc, unchanged(gomboc, 0))
    assert outcome.verdict.shape == (0,)
    assert outcome.rest_direction.shape == (0, 3)


@pytest.mark.slow
@pytest.mark.parametrize(("form_mm", "com_mm"), [(0.004, 0.05), (0.03, 0.1)])
def test_meshes_of_the_solids_rest_likewise(gomboc, form_mm, com_mm):
    variants = random_variants(gomboc, 10, 13, form_mm=form_mm, com_mm=com_mm, stretch=1e-4)
    outcome = judge(gomboc, variants)
    decided = 0
    for row in range(len(variants)):
        points, faces = points_as_made(gomboc, variants, row)
        made = points @ variants.stretch[row].T
        census = mesh_census(made, faces, variants.com_mm[row], probabilities=False)
        if census.verdict == "undecided":
            continue
        decided += 1
        # The mesh tells rests with a barrier above its own roughness only.
        if census.verdict == "multistable":
            assert outcome.verdict[row] == MULTISTABLE
        elif outcome.verdict[row] == MONOSTABLE:
            assert np.dot(census.rest.direction, outcome.rest_direction[row]) > np.cos(np.radians(8.0))
    assert decided > 3
