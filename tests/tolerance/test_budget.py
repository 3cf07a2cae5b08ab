"""The budget against the closed form of a COM that has to stay within a ball."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from scipy.stats import chi

from gomboc_cad.body import catalog
from gomboc_cad.equilibria import smooth_census
from gomboc_cad.errors import StudyError
from gomboc_cad.products.process import load_process
from gomboc_cad.tolerance.acceptance import Effort, Target
from gomboc_cad.tolerance.budget import MOST_FACTOR, Budget, lone_factors, solve_budget
from gomboc_cad.tolerance.model import Source
from gomboc_cad.tolerance.product_study import body_study
from gomboc_cad.tolerance.requirement import Requirement
from gomboc_cad.tolerance.variants import MULTISTABLE, Outcomes, Variants
from tests.tolerance.margin_ball import Array, MarginBall

TARGET = Target(Requirement())
SURE = float(chi(3).ppf(0.95))


def with_budget(model: MarginBall, budget: Budget) -> MarginBall:
    return replace(model, sizes_mm={a.source.name: a.allowed for a in budget.allowances})


@pytest.mark.parametrize("size_mm", [0.02, 0.07, 0.09, 0.5, 40.0])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_single_source_gets_what_the_chi_distribution_allows(size_mm: float, seed: int) -> None:
    model = MarginBall({"payload": size_mm})
    budget = solve_budget(model, TARGET, Effort(seed=seed))
    truth = model.margin_mm / SURE
    (allowance,) = budget.allowances
    assert budget.met
    # The target holds in truth, and what the confidence costs is little.
    assert with_budget(model, budget).true_yield >= 0.95
    assert 0.92 * truth < allowance.allowed <= truth or allowance.allowed == MOST_FACTOR * size_mm
    assert allowance.alone == pytest.approx(min(truth, MOST_FACTOR * size_mm), rel=0.2)


@pytest.mark.parametrize("good_share", [0.5, 0.9, 0.99])
def test_the_target_is_that_which_was_asked_for(good_share: float) -> None:
    model = MarginBall({"payload": 1.0})
    budget = solve_budget(model, Target(Requirement(), good_share))
    assert budget.met
    assert budget.checked.good.low >= good_share
    assert good_share <= with_budget(model, budget).true_yield <= good_share + 0.3 * (1.0 - good_share) ** 0.5


def test_a_tolerance_of_the_tilt_is_shared_as_well() -> None:
    """The tilt of this study is the distance of the COM from the axis, of Rayleigh's distribution."""
    model = MarginBall({"payload": 0.5}, margin_mm=1e3)
    budget = solve_budget(model, Target(Requirement(max_tilt_deg=0.1)))
    truth = 0.1 / np.sqrt(-2.0 * np.log(0.05))
    assert budget.met
    assert 0.9 * truth < budget.allowances[0].allowed <= truth


def test_what_dominates_is_tightened_and_what_does_not_matter_is_left_alone() -> None:
    model = MarginBall({"glue": 0.005, "payload": 0.1, "shell": 0.3, "screw": 0.0})
    budget = solve_budget(model, TARGET)
    assert [a.source.name for a in budget.allowances] == ["shell", "payload", "glue", "screw"]
    shell, payload, glue, screw = budget.allowances
    assert budget.met
    assert with_budget(model, budget).true_yield >= 0.95
    assert glue.allowed == glue.source.size
    assert screw.allowed == 0.0
    # Those that are tightened share alike: √2 less than alone.
    assert shell.allowed == pytest.approx(payload.allowed, rel=0.2)
    assert shell.allowed == pytest.approx(0.2 / SURE / np.sqrt(2.0), rel=0.2)
    assert shell.factor < payload.factor < 1.0
    assert budget.as_made.met is False
    assert "shell" in budget.sentence
    assert "glue" not in budget.sentence


def test_room_to_spare_goes_to_those_that_use_little() -> None:
    model = MarginBall({"payload": 0.01, "shell": 0.05})
    budget = solve_budget(model, TARGET)
    shell, payload = budget.allowances
    assert budget.as_made.met
    assert budget.met
    assert shell.source.name == "shell"
    assert shell.allowed == shell.source.size
    assert payload.allowed > 2.0 * payload.source.size
    assert with_budget(model, budget).true_yield >= 0.95


def test_a_study_just_above_the_target_is_not_made_worse() -> None:
    """So near to it, fresh rows refuse what the search finds now and then; then all stays as it is."""
    model = MarginBall({"payload": 0.2 / float(chi(3).ppf(0.957))})
    for seed in range(5):
        budget = solve_budget(model, TARGET, Effort(seed=seed))
        assert with_budget(model, budget).true_yield >= 0.95
        assert budget.met == budget.checked.met
        if budget.as_made.met:
            assert budget.met


def test_the_lone_limits_do_not_depend_on_the_sizes() -> None:
    truth = 0.2 / SURE
    for size in (0.02, 0.2, 2.0):
        factor = lone_factors(MarginBall({"payload": size, "shell": 5.0}), TARGET, Effort())["payload"]
        assert size * factor == pytest.approx(min(truth, MOST_FACTOR * size), rel=0.2)


@dataclass(frozen=True)
class Scrapping(MarginBall):
    """One part in ten fails whatever the sizes are."""

    @property
    def sources(self) -> tuple[Source, ...]:
        return (*super().sources, Source("scrap", "scrap", 0.0, "", 3, "test"))

    def scaled(self, factors: Mapping[str, float]) -> MarginBall:
        return super().scaled({name: f for name, f in factors.items() if name != "scrap"})

    def variants(self, quantiles: Array) -> Variants:
        made = super().variants(quantiles[:, :-3])
        return replace(made, upper_shift_mm=quantiles[:, -3:])

    def judge(self, variants: Variants) -> Outcomes:
        outcomes = super().judge(variants)
        scrap = variants.upper_shift_mm[:, 0] < 0.1
        return replace(outcomes, verdict=np.where(scrap, MULTISTABLE, outcomes.verdict).astype(np.int8))


def test_a_target_that_cannot_be_met_is_not_promised() -> None:
    budget = solve_budget(Scrapping({"payload": 0.05}), TARGET)
    assert not budget.met
    assert budget.checked.good.low < 0.9 < budget.checked.good.high
    assert budget.sentence.startswith("No budget was found")
    assert budget.allowances[0].source.name == "payload"
    assert budget.allowances[0].use == np.inf
    assert budget.document()["met"] is False


def test_a_target_that_scrap_just_allows_is_met_by_tightening_the_rest() -> None:
    model = Scrapping({"payload": 0.2})
    budget = solve_budget(model, Target(Requirement(), 0.85))
    allowed = {a.source.name: a.allowed for a in budget.allowances}
    truth = 0.9 * MarginBall({"payload": allowed["payload"]}).true_yield
    assert budget.met
    assert 0.85 <= truth < 0.88


def test_no_tolerance_helps_a_design_that_is_not_good() -> None:
    with pytest.raises(StudyError, match="even when it is made perfectly"):
        solve_budget(MarginBall({"payload": 0.1}, margin_mm=0.0), TARGET)


def test_more_must_not_be_asked_of_rows_than_they_can_show() -> None:
    with pytest.raises(StudyError, match="cannot show"):
        solve_budget(MarginBall({"payload": 0.1}), Target(Requirement(), 0.9999))


def first_columns(effort: Effort) -> frozenset[float]:
    """What the rows of the search begin with, and those that would follow them."""
    sample = replace(effort.search_rows, count=effort.check).of(MarginBall({"payload": 1.0}))
    return frozenset(float(row[0]) for index in range(sample.batches) for row in sample.batch(index))


@dataclass(frozen=True)
class LearntByHeart(MarginBall):
    """A study that is good on the rows of the search, however large its errors are."""

    known: frozenset[float] = field(default_factory=lambda: first_columns(Effort()))

    def variants(self, quantiles: Array) -> Variants:
        made = super().variants(quantiles)
        known = np.isin(quantiles[:, 0], list(self.known))
        return replace(made, com_mm=np.where(known[:, None], 0.0, made.com_mm))


def test_what_only_the_rows_of_the_search_say_is_found_out() -> None:
    """Rows that an answer was chosen by vouch for anything; fresh ones do not."""
    model = LearntByHeart({"payload": 2.0})
    budget = solve_budget(model, TARGET)
    assert not budget.met
    assert budget.checked.good.high < 0.1


def test_room_that_only_the_rows_of_the_search_see_is_not_given_away() -> None:
    budget = solve_budget(LearntByHeart({"payload": 0.05}), TARGET)
    (allowance,) = budget.allowances
    assert budget.met
    assert budget.checked == budget.as_made
    assert allowance.allowed == allowance.source.size


def test_the_answer_is_the_same_again_and_another_with_another_seed() -> None:
    model = MarginBall({"payload": 0.1, "shell": 0.2})
    first, again, other = (solve_budget(model, TARGET, Effort(seed=seed)) for seed in (3, 3, 4))
    assert first == again
    assert first.checked.good != other.checked.good


@pytest.mark.slow
def test_the_primary_may_have_com_errors_beyond_those_that_its_margin_promises() -> None:
    """A cube within the ball of the S-margin loses no part; the budget is not below it, and not far above."""
    primary = catalog()["primary"].with_diameter(100.0)
    margin = smooth_census(primary).margin
    assert margin is not None
    study = body_study(primary, load_process("cnc-5axis"), com_error_mm=1.0, degree=2).only("com_error")
    budget = solve_budget(study, TARGET, Effort(512, 2048))
    (allowance,) = budget.allowances
    assert budget.met
    assert margin.s_margin_mm / np.sqrt(3.0) < allowance.allowed < 2.0 * margin.s_margin_mm
