"""The allowable form error: closed forms of what a field of one degree can do, and searched amplitudes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi

from gomboc_cad.body import catalog, mass_properties
from gomboc_cad.body.sphere import fibonacci_directions, tangent_frame, unit
from gomboc_cad.equilibria import Census, smooth_census
from gomboc_cad.errors import StudyError
from gomboc_cad.tolerance.acceptance import Effort, Target
from gomboc_cad.tolerance.allowable import (
    SingleDegree,
    census_growth,
    curvature_growth,
    form_error_curve,
    guaranteed_form_mm,
)
from gomboc_cad.tolerance.fast_census import judge
from gomboc_cad.tolerance.harmonics import coefficient_count, form_jets, harmonic_jets
from gomboc_cad.tolerance.requirement import Requirement
from gomboc_cad.tolerance.variants import MONOSTABLE, MULTISTABLE, Nominal, Outcomes, Variants
from tests.body.shapes import real_harmonic
from tests.tolerance.margin_ball import Array, MarginBall

TARGET = Target(Requirement())
EFFORT = Effort(1024, 4096)


def bent(degree: int, direction: Array, step: float = 1e-3) -> tuple[Array, Array]:
    """Second difference along one tangent, and value, of every harmonic of a degree with mean square 1."""
    tangent = tangent_frame(direction[None])[0][0]
    places = [np.cos(t) * direction + np.sin(t) * tangent for t in (-step, 0.0, step)]
    values = np.sqrt(4.0 * np.pi) * np.array(
        [[real_harmonic(degree, m, p[None])[0] for m in range(-degree, degree + 1)] for p in places]
    )
    return (values[0] - 2.0 * values[1] + values[2]) / step**2, values[1]


@pytest.mark.parametrize("degree", [2, 3, 5, 9])
def test_the_growth_is_the_norm_of_a_second_derivative_over_all_harmonics(degree: int) -> None:
    """By finite differences of SciPy's harmonics, at places that are nowhere special."""
    for direction in unit(np.array([[0.3, -0.5, 0.8], [-0.9, 0.1, -0.2]])):
        second, value = bent(degree, direction)
        assert np.linalg.norm(second) == pytest.approx(census_growth(np.array([degree]))[0], rel=1e-4)
        assert np.linalg.norm(second + value) == pytest.approx(
            curvature_growth(np.array([degree]))[0], rel=1e-4
        )


@given(degree=st.integers(2, 12), seed=st.integers(0, 10_000))
def test_no_field_grows_faster(degree: int, seed: int) -> None:
    generator = np.random.default_rng(seed)
    coefficients = np.zeros(coefficient_count(degree))
    coefficients[coefficient_count(degree - 1) :] = unit(generator.normal(size=2 * degree + 1))
    u = fibonacci_directions(200)
    value, g1, g2, h11, h12, h22 = form_jets(u, np.stack(tangent_frame(u), axis=1), coefficients)
    spread = np.hypot(0.5 * (h11 - h22), h12)
    largest = np.abs(0.5 * (h11 + h22)) + spread
    assert np.sqrt(g1**2 + g2**2 + largest**2).max() <= census_growth(np.array([degree]))[0] * (1.0 + 1e-12)
    radius = np.abs(0.5 * (h11 + h22) + value) + spread
    assert radius.max() <= curvature_growth(np.array([degree]))[0] * (1.0 + 1e-12)


def test_the_amplitude_falls_as_the_degree_to_five_halves() -> None:
    """The worst field of degree n has all its 2n + 1 harmonics in step at one place."""
    degrees = np.array([100, 200])
    first, second = guaranteed_form_mm(1.0, 50.0, degrees)
    assert first / second == pytest.approx(2.0**2.5, rel=0.02)


@dataclass(frozen=True)
class RmsLimit(MarginBall):
    """A study in which a part is good if the root of the mean square of its form error is below a limit."""

    limit_mm: float = 0.05

    def judge(self, variants: Variants) -> Outcomes:
        outcomes = super().judge(variants)
        bad = np.linalg.norm(variants.form_mm, axis=1) > self.limit_mm
        return replace(outcomes, verdict=np.where(bad, MULTISTABLE, outcomes.verdict).astype(np.int8))


def test_the_searched_amplitude_is_that_of_the_chi_distribution() -> None:
    model = RmsLimit({"payload": 0.3})
    curve = form_error_curve(model, [2, 4, 7], TARGET, EFFORT)
    for degree, amplitude, checked in zip((2, 4, 7), curve.probable_mm, curve.probable, strict=True):
        dimensions = 2 * degree + 1
        truth = 0.05 * np.sqrt(dimensions) / chi(dimensions).ppf(0.95)
        assert 0.88 * truth < amplitude <= truth
        assert checked.good.low >= 0.95


def test_the_search_finds_amplitudes_below_the_guaranteed_one_too() -> None:
    """A tilt may be asked for that the S-margin says nothing about."""
    curve = form_error_curve(RmsLimit({}, margin_mm=100.0, limit_mm=1e-4), [3], TARGET, EFFORT)
    assert curve.guaranteed_mm[0] > 1.0
    assert 0.8 < curve.probable_mm[0] * chi(7).ppf(0.95) / np.sqrt(7.0) / 1e-4 <= 1.0


def test_where_no_amplitude_will_do_it_is_zero() -> None:
    curve = form_error_curve(RmsLimit({}, limit_mm=0.0), [3], TARGET, EFFORT)
    assert curve.probable_mm[0] == 0.0
    assert curve.document()["degrees"][0]["allowed_um"] == 0.0


def test_what_the_process_makes_is_set_against_what_is_allowed() -> None:
    curve = form_error_curve(RmsLimit({}), [2, 3], TARGET, EFFORT, process_mm=np.array([0.01, 0.1]))
    assert curve.process_use is not None
    assert curve.process_use == pytest.approx(np.array([0.01, 0.1]) / curve.probable_mm)
    assert curve.process_use[0] < 1.0 < curve.process_use[1]


def test_a_degree_that_moves_or_sizes_the_body_is_refused() -> None:
    for degrees in ([], [1, 2]):
        with pytest.raises(StudyError, match="from 2 on"):
            form_error_curve(RmsLimit({}), degrees, TARGET)


def test_everything_else_is_as_designed() -> None:
    field = SingleDegree(RmsLimit({"payload": 5.0}), 3, 0.02)
    made = field.variants(np.random.default_rng(0).random((4000, 7)))
    assert np.all(made.com_mm == 0.0)
    assert np.all(made.form_mm[:, : coefficient_count(2)] == 0.0)
    assert np.sqrt((made.form_mm**2).sum(axis=1).mean()) == pytest.approx(0.02, rel=0.02)


PRIMARY = catalog()["primary"].with_diameter(100.0)


def primary_with(forms_mm: Array) -> Outcomes:
    """The homogeneous primary with form errors, judged."""
    com = mass_properties(PRIMARY).com_mm
    count = len(forms_mm)
    variants = Variants(
        np.tile(com, (count, 1)), np.tile(np.eye(3), (count, 1, 1)), forms_mm, np.zeros((count, 3))
    )
    return judge(Nominal(PRIMARY, com), variants)


@pytest.fixture(scope="module")
def census() -> Census:
    return smooth_census(PRIMARY)


@pytest.mark.parametrize("degree", [2, 3, 6, 16])
def test_the_worst_field_makes_a_second_rest_just_above_the_guaranteed_amplitude(
    census: Census, degree: int
) -> None:
    """It bends the soft direction of the rest and moves nothing else: `λ − a · growth` comes to zero."""
    assert census.margin is not None
    assert census.convexity is not None
    frame = np.array([[census.rest.soft_direction, census.rest.stiff_direction]])
    second = harmonic_jets(np.array([census.rest.direction]), frame, degree)[3, :, 0]
    second[: coefficient_count(degree - 1)] = 0.0
    growth = census_growth(np.array([degree]))[0]
    assert np.linalg.norm(second) == pytest.approx(growth)
    (safe,) = guaranteed_form_mm(
        census.margin.s_margin_mm, census.convexity.min_radius_of_curvature_mm, np.array([degree])
    )
    unstable = census.rest.stiffness_mm[0] / growth
    assert safe < unstable < 1.01 * safe
    outcomes = primary_with(np.outer([0.999 * safe, 1.01 * unstable], -second / growth))
    assert list(outcomes.verdict) == [MONOSTABLE, MULTISTABLE]


@pytest.mark.parametrize("degree", [2, 5, 12])
def test_no_field_below_the_guaranteed_amplitude_makes_a_second_rest(census: Census, degree: int) -> None:
    assert census.margin is not None
    assert census.convexity is not None
    (safe,) = guaranteed_form_mm(
        census.margin.s_margin_mm, census.convexity.min_radius_of_curvature_mm, np.array([degree])
    )
    forms = np.zeros((300, coefficient_count(degree)))
    draws = np.random.default_rng(degree).normal(size=(300, 2 * degree + 1))
    forms[:, coefficient_count(degree - 1) :] = 0.999 * safe * unit(draws)
    assert np.all(primary_with(forms).verdict == MONOSTABLE)
