"""Intervals, percentiles and Sobol indices against definitions, exact sums and published values."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, binomtest

from gomboc_cad.tolerance.statistics import (
    Interval,
    SobolIndex,
    Yield,
    clopper_pearson,
    distribution,
    group_indices,
)
from gomboc_cad.tolerance.study import Sensitivity, run_sensitivity
from tests.tolerance.toys import Ishigami, LoadedSphere

# Sobol and Levitan (1999) and Saltelli et al. (2008), Global Sensitivity Analysis, for a = 7 and b = 0.1.
FIRST = (0.3139, 0.4424, 0.0)
TOTAL = (0.5576, 0.4424, 0.2437)
CLOSED_13 = 0.5576


@given(st.integers(0, 300).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_the_ends_are_where_half_of_the_rest_is_left(counts: tuple[int, int]) -> None:
    """The definition of Clopper and Pearson: at each end what was seen is just too unlikely."""
    passed, trials = counts
    found = clopper_pearson(passed, trials, 0.9)
    if passed > 0:
        assert binom.sf(passed - 1, trials, found.low) == pytest.approx(0.05, rel=1e-9)
    else:
        assert found.low == 0.0
    if passed < trials:
        assert binom.cdf(passed, trials, found.high) == pytest.approx(0.05, rel=1e-9)
    else:
        assert found.high == 1.0


def test_ends_in_closed_form() -> None:
    assert clopper_pearson(0, 10).high == pytest.approx(1.0 - 0.025**0.1, rel=1e-12)
    assert clopper_pearson(10, 10).low == pytest.approx(0.025**0.1, rel=1e-12)
    assert clopper_pearson(10, 10).high == 1.0
    nothing = clopper_pearson(0, 0)
    assert (nothing.low, nothing.high) == (0.0, 1.0)
    assert np.isnan(nothing.estimate)


def test_it_is_the_exact_interval_of_the_binomial_test() -> None:
    for passed, trials in ((3, 17), (16, 17), (9_950, 10_000)):
        ends = binomtest(passed, trials).proportion_ci(0.99, method="exact")
        found = clopper_pearson(passed, trials, 0.99)
        assert found == Interval(
            passed / trials, pytest.approx(ends.low, rel=1e-9), pytest.approx(ends.high, rel=1e-9), 0.99
        )


def test_it_covers_every_truth_at_least_as_often_as_it_says() -> None:
    trials = 40
    ends = [clopper_pearson(passed, trials) for passed in range(trials + 1)]
    low, high = (np.array([getattr(end, name) for end in ends]) for name in ("low", "high"))
    for truth in np.linspace(0.001, 0.999, 333):
        covering = (low <= truth) & (truth <= high)
        assert binom.pmf(np.flatnonzero(covering), trials, truth).sum() >= 0.95


def test_more_good_than_there_are_is_a_mistake() -> None:
    with pytest.raises(ValueError, match="5 of 4"):
        clopper_pearson(5, 4)


def test_undecided_variants_count_against_the_yield_and_are_not_hidden() -> None:
    found = Yield(passed=80, undecided=15, variants=100)
    assert found.interval == clopper_pearson(80, 100)
    assert found.possible == clopper_pearson(95, 100)


def test_percentiles() -> None:
    found = distribution(np.arange(101.0)[::-1])
    assert found is not None
    assert (found.smallest, found.p05, found.p50, found.p95, found.largest) == (0.0, 5.0, 50.0, 95.0, 100.0)
    assert (found.count, found.mean) == (101, 50.0)
    assert distribution(np.empty(0)) is None


def estimates(indices: tuple[SobolIndex, ...]) -> tuple[list[float], list[float]]:
    return [index.first.estimate for index in indices], [index.total.estimate for index in indices]


@pytest.fixture(scope="module")
def ishigami() -> Sensitivity:
    return run_sensitivity(Ishigami(), 8192, seed=1)


def test_ishigami(ishigami: Sensitivity) -> None:
    first, total = estimates(ishigami.tilt_deg)
    assert first == pytest.approx(FIRST, abs=0.02)
    assert total == pytest.approx(TOTAL, abs=0.02)
    assert [index.source for index in ishigami.tilt_deg] == ["group 0", "group 1", "group 2"]
    assert ishigami.undecided == 0


def test_indices_do_not_depend_on_unit_and_zero_of_the_output(ishigami: Sensitivity) -> None:
    for tilt, margin in zip(estimates(ishigami.tilt_deg), estimates(ishigami.s_margin_mm), strict=True):
        assert margin == pytest.approx(tilt, rel=1e-9, abs=1e-12)


def test_groups_of_columns_have_their_closed_indices() -> None:
    """x₁ and x₂ together against x₃ with two columns that do nothing."""
    found = run_sensitivity(Ishigami(groups=(2, 3)), 8192, seed=2)
    first, total = estimates(found.tilt_deg)
    assert first == pytest.approx([FIRST[0] + FIRST[1], FIRST[2]], abs=0.02)
    assert total == pytest.approx([1.0 - FIRST[2], TOTAL[2]], abs=0.02)


def test_bootstrap_intervals_cover_the_published_indices() -> None:
    """Sobol points are more even than the independent rows that a bootstrap supposes: never too rarely."""
    hits = np.zeros(6)
    studies = 40
    for seed in range(studies):
        found = run_sensitivity(Ishigami(), 512, seed=seed).tilt_deg
        intervals = [index.first for index in found] + [index.total for index in found]
        hits += [i.low <= truth <= i.high for i, truth in zip(intervals, FIRST + TOTAL, strict=True)]
    assert hits.min() >= binom.ppf(0.001, studies, 0.95)
    assert np.mean([i.high - i.low for i in intervals]) < 0.5


def test_a_source_without_effect_has_index_zero_and_a_single_one_has_one() -> None:
    still = run_sensitivity(LoadedSphere(along_mm=0.0), 64, seed=3)
    assert estimates(still.tilt_deg) == ([1.0, 0.0], [1.0, 0.0])
    assert still.tilt_deg[1].total == Interval(0.0, 0.0, 0.0)
    rigid = run_sensitivity(LoadedSphere(across_mm=0.0, along_mm=0.0), 64, seed=3)
    assert estimates(rigid.tilt_deg) == ([0.0, 0.0], [0.0, 0.0])


def test_the_bootstrap_is_the_same_for_the_same_seed() -> None:
    rng = np.random.default_rng(0)
    a, b = rng.random((2, 64))
    ab = rng.random((3, 64))
    found = [group_indices("abc", a, b, ab, seed=seed) for seed in (4, 4, 5)]
    assert found[0] == found[1]
    assert found[0] != found[2]
    assert estimates(found[0]) == estimates(found[2])


def test_undecided_variants_count_with_the_mean_of_the_others() -> None:
    model = LoadedSphere(across_mm=0.1, along_mm=0.2, doubt_mm=0.4)
    found = run_sensitivity(model, 1024, seed=6)
    assert 0 < found.undecided < 0.3 * 4 * 1024
    for index in found.tilt_deg + found.s_margin_mm:
        assert np.isfinite([index.first.low, index.first.high, index.total.estimate]).all()
    assert found.tilt_deg[0].total.estimate > found.tilt_deg[1].total.estimate
    assert found.s_margin_mm[1].total.estimate > found.s_margin_mm[0].total.estimate
