"""Acceptance sampling: exact bounds, rows that come again, fresh rows that vouch for what was found."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi

from gomboc_cad.errors import StudyError
from gomboc_cad.tolerance.acceptance import (
    Rows,
    Target,
    accepted,
    first_confirmed,
    good_parts,
    largest_accepted,
    refined,
)
from gomboc_cad.tolerance.requirement import Requirement
from gomboc_cad.tolerance.sampling import BATCH_ROWS
from gomboc_cad.tolerance.statistics import clopper_pearson
from gomboc_cad.tolerance.variants import Variants
from tests.tolerance.margin_ball import Array, MarginBall

RIGHTS_ITSELF = Requirement()
TARGET = Target(RIGHTS_ITSELF)
SURE = float(chi(3).ppf(0.95))
"""Margin over the size of a COM error of which 95 % of the parts stay within the margin."""


@dataclass(frozen=True)
class Witnessed(MarginBall):
    """A study that writes down every batch of quantiles it is asked about."""

    seen: list[Array] = field(default_factory=list)

    def variants(self, quantiles: Array) -> Variants:
        self.seen.append(quantiles)
        return super().variants(quantiles)


@given(
    rows=st.integers(100, 5000),
    share=st.floats(0.5, 0.97),
    confidence=st.sampled_from([0.9, 0.95, 0.99]),
)
def test_the_acceptance_number_is_that_of_the_exact_interval(
    rows: int, share: float, confidence: float
) -> None:
    target = Target(RIGHTS_ITSELF, share, confidence)
    if rows < target.least_rows:
        return
    allowed = target.allowed_failures(rows)
    assert clopper_pearson(rows - allowed, rows, confidence).low >= share
    assert clopper_pearson(rows - allowed - 1, rows, confidence).low < share


def test_too_few_rows_are_refused_with_the_number_that_it_takes() -> None:
    target = Target(RIGHTS_ITSELF, 0.999)
    assert target.least_rows == 3688
    assert target.allowed_failures(3688) == 0
    with pytest.raises(StudyError, match=r"99\.9 % .* at least 3688"):
        target.allowed_failures(3687)


@pytest.mark.parametrize("wrong", [0.0, 1.0, 95.0, float("nan")])
def test_a_share_is_between_zero_and_one(wrong: float) -> None:
    with pytest.raises(StudyError, match="yield target"):
        Target(RIGHTS_ITSELF, wrong)
    with pytest.raises(StudyError, match="confidence"):
        Target(RIGHTS_ITSELF, 0.9, wrong)


def test_rows_are_the_same_again_and_those_of_another_stream_or_seed_are_others() -> None:
    model = MarginBall({"payload": 0.1})
    batch = Rows(1000).of(model).batch(1)
    assert np.array_equal(batch, Rows(5000).of(model).batch(1))
    assert 0.0 < batch.min() < batch.max() < 1.0
    for other in (Rows(1000, stream=1).of(model).batch(1), Rows(1000, seed=1).of(model).batch(1)):
        assert np.intersect1d(batch, other).size == 0


def test_as_many_are_good_as_the_closed_form_says() -> None:
    model = MarginBall({"payload": 0.06, "shell": 0.05})
    rows = Rows(20_000 + 7)
    found = clopper_pearson(good_parts(model, RIGHTS_ITSELF, rows), rows.count, 0.999)
    assert found.low < model.true_yield < found.high


def test_rows_beyond_those_that_were_asked_for_do_not_count() -> None:
    model = Witnessed({"payload": 0.1})
    rows = Rows(BATCH_ROWS + 3)
    good = good_parts(model, RIGHTS_ITSELF, rows)
    kept = [model.judge(MarginBall.variants(model, q)).verdict == 0 for q in model.seen]
    assert good == np.concatenate(kept)[: rows.count].sum()


def test_a_hopeless_study_is_given_up_at_once_and_a_good_one_is_judged_to_the_end() -> None:
    bad, good = Witnessed({"payload": 1.0}), Witnessed({"payload": 0.01})
    assert not accepted(bad, TARGET, Rows(20 * BATCH_ROWS))
    assert accepted(good, TARGET, Rows(20 * BATCH_ROWS))
    assert len(bad.seen) <= 3
    assert len(good.seen) == 20


def test_every_try_has_rows_that_nobody_has_seen() -> None:
    model = Witnessed({"payload": 0.1})
    accepted(model, TARGET, Rows(BATCH_ROWS))
    first_confirmed([1.0, 0.9, 0.8], lambda _: model, TARGET, Rows(BATCH_ROWS, stream=1))
    assert len(model.seen) == 4
    assert len(np.unique(model.seen)) == sum(batch.size for batch in model.seen)


def test_tries_that_are_repeated_are_no_way_to_a_false_answer() -> None:
    """The yield is just below the target: one try in forty may say that it is met, four tries no more."""
    model = MarginBall({"payload": 0.2 / (SURE * 0.9999)})
    false = sum(
        first_confirmed([1.0] * 4, lambda _: model, TARGET, Rows(2 * BATCH_ROWS, seed=seed)).met
        for seed in range(400)
    )
    # 10 are expected at most; more than 22 of 400 come with a probability of 3e-4.
    assert false <= 22


def test_the_first_value_that_is_confirmed_is_given_or_else_the_last() -> None:
    def at(factor: float) -> MarginBall:
        return MarginBall({"payload": factor * 0.2 / SURE})

    rows = Rows(8 * BATCH_ROWS)
    found = first_confirmed([2.0, 1.5, 0.8, 0.5], at, TARGET, rows)
    assert found.met
    assert found.value == 0.8
    assert found.good.low >= 0.95
    missed = first_confirmed([2.0, 1.5], at, TARGET, rows)
    assert not missed.met
    assert missed.value == 1.5
    assert missed.good.low < at(1.5).true_yield < missed.good.high


@pytest.mark.parametrize("threshold", [1e-4, 0.3, 0.5, 0.999, 1.0, 3.3, 7.9])
def test_the_largest_accepted_value_is_found_on_either_side_of_the_start(threshold: float) -> None:
    found = largest_accepted(lambda value: value <= threshold, 1.0, 2.0**-20, 8.0, 0.01)
    assert found is not None
    assert threshold / 1.011 <= found <= threshold


def test_ends_of_the_search_are_said() -> None:
    assert largest_accepted(lambda value: True, 1.0, 1e-3, 8.0, 0.01) == 8.0
    asked: list[float] = []
    assert largest_accepted(lambda value: bool(asked.append(value)), 1.0, 1e-3, 8.0, 0.01) is None
    assert min(asked) == 1e-3
    assert largest_accepted(lambda value: value <= 1e-3, 1.0, 1e-3, 8.0, 0.01) == 1e-3
    assert largest_accepted(lambda value: True, 1.0, 1e-3, 1.0, 0.01) == 1.0


def test_refining_goes_towards_a_bad_value_on_either_side() -> None:
    assert refined(lambda value: value >= 0.37, 1.0, 0.1, 1e-4) == pytest.approx(0.37, rel=1e-4)
    assert refined(lambda value: value <= 0.37, 0.1, 1.0, 1e-4) == pytest.approx(0.37, rel=1e-4)


def test_an_executor_changes_nothing() -> None:
    model = MarginBall({"payload": 0.07})
    rows = Rows(3 * BATCH_ROWS + 11)
    with ThreadPoolExecutor(2) as executor:
        assert good_parts(model, RIGHTS_ITSELF, rows, executor) == good_parts(model, RIGHTS_ITSELF, rows)
        assert not accepted(replace(model, sizes_mm={"payload": 1.0}), TARGET, rows, executor)
