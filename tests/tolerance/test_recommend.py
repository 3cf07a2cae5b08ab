"""What to change, against studies whose yield is known in closed form."""

from __future__ import annotations

import pytest
from scipy.stats import chi

from gomboc_cad.tolerance.acceptance import Target
from gomboc_cad.tolerance.budget import solve_budget
from gomboc_cad.tolerance.recommend import Proposal, Recommendation, recommend
from gomboc_cad.tolerance.requirement import Requirement
from tests.tolerance.margin_ball import MarginBall
from tests.tolerance.test_budget import LearntByHeart, Scrapping

TARGET = Target(Requirement())
SURE = float(chi(3).ppf(0.95))


def of_kind(found: tuple[Proposal, ...], change: str) -> list[Proposal]:
    return [proposal for proposal in found if proposal.change == change]


def growing(lowered_mm: float) -> float:
    return 0.1 + lowered_mm


def dipping(lowered_mm: float) -> float:
    """As on a real body: a little more margin at first, then none, then as much as you like."""
    return 0.1 + 0.3 * lowered_mm if lowered_mm < 0.3 else max(0.0, lowered_mm - 1.0)


def test_a_study_that_meets_the_target_is_left_alone() -> None:
    found = recommend(MarginBall({"payload": 0.05}), TARGET)
    assert found.as_made.met
    assert found.proposals == found.fell_short == ()
    assert found.sentence.startswith("Nothing has to be changed")


def test_the_com_is_lowered_by_as_much_as_the_closed_form_says() -> None:
    model = MarginBall({"payload": 0.2}, margin_of_lowering=growing)
    (proposal,) = of_kind(recommend(model, TARGET).proposals, "lower_com")
    truth = SURE * 0.2 - 0.1
    assert proposal.met
    assert truth <= proposal.proposed < 1.1 * truth
    assert proposal.sentence.startswith(f"Lowering the centre of mass by {proposal.proposed:.3g} mm")


def test_the_first_lowering_that_meets_the_target_is_found_though_farther_ones_do_not() -> None:
    near = recommend(MarginBall({"payload": 0.05}, margin_of_lowering=dipping), TARGET)
    (proposal,) = of_kind(near.proposals, "lower_com")
    truth = (SURE * 0.05 - 0.1) / 0.3
    assert truth <= proposal.proposed < 0.3
    far = recommend(MarginBall({"payload": 0.2}, margin_of_lowering=dipping), TARGET)
    (proposal,) = of_kind(far.proposals, "lower_com")
    truth = 1.0 + SURE * 0.2
    assert truth <= proposal.proposed < 1.06 * truth


def test_a_com_is_not_lowered_beyond_the_reach() -> None:
    model = MarginBall({"payload": 0.2}, margin_of_lowering=growing)
    (short,) = of_kind(recommend(model, TARGET, most_lowering_mm=0.3).fell_short, "lower_com")
    assert not short.met
    assert short.proposed == 0.3
    assert short.checked.good.low < chi(3).cdf(0.4 / 0.2) < short.checked.good.high


def test_the_tolerance_that_matters_is_tightened_and_the_other_does_not_help() -> None:
    model = MarginBall({"glue": 0.02, "payload": 0.1})
    found = recommend(model, TARGET)
    (tightened,) = of_kind(found.proposals, "tighten")
    truth = ((0.2 / SURE) ** 2 - 0.02**2) ** 0.5
    assert tightened.subject == "payload"
    assert 0.85 * truth < tightened.proposed <= truth
    (useless,) = of_kind(found.fell_short, "tighten")
    assert useless.subject == "glue"
    assert useless.proposed == 0.0
    assert useless.checked.good.low < MarginBall({"payload": 0.1}).true_yield < useless.checked.good.high


@pytest.mark.parametrize(("best_mm", "attainable"), [(0.05, True), (0.09, False), (None, None)])
def test_a_tolerance_beyond_the_best_shops_is_said_to_be_so(
    best_mm: float | None, attainable: bool | None
) -> None:
    """About 0.07 mm is what the target takes."""
    model = MarginBall({"payload": 0.1}, best_mm=best_mm)
    (tightened,) = of_kind(recommend(model, TARGET).proposals, "tighten")
    assert tightened.attainable is attainable
    assert ("at best" in tightened.sentence) is (attainable is False)
    budget = solve_budget(model, TARGET)
    assert budget.allowances[0].attainable is attainable
    assert ("at best" in budget.sentence) is (attainable is False)


def test_processes_are_confirmed_one_by_one() -> None:
    processes = {
        "good": MarginBall({"payload": 0.06}),
        "better": MarginBall({"payload": 0.03}),
        "worse": MarginBall({"payload": 0.2}),
    }
    found = recommend(MarginBall({"payload": 0.1}), TARGET, processes=processes)
    assert [p.subject for p in of_kind(found.proposals, "process")] == ["better", "good"]
    assert [p.subject for p in of_kind(found.fell_short, "process")] == ["worse"]


def test_first_comes_the_design_then_a_tolerance_then_the_process() -> None:
    model = MarginBall({"payload": 0.06, "shell": 0.06}, margin_of_lowering=lambda d: 0.2 + 0.1 * d)
    found = recommend(model, TARGET, processes={"precise": MarginBall({"payload": 0.001})})
    assert [(p.change, p.subject) for p in found.proposals][::3] == [
        ("lower_com", "com"),
        ("process", "precise"),
    ]
    tightened = [p.proposed / p.now for p in of_kind(found.proposals, "tighten")]
    assert len(tightened) == 2
    assert tightened[0] >= tightened[1]
    assert found.sentence == found.proposals[0].sentence
    assert [p["change"] for p in found.document()["proposals"]] == [p.change for p in found.proposals]


def test_that_nothing_helps_is_an_answer_with_numbers() -> None:
    found: Recommendation = recommend(Scrapping({"payload": 0.1}), TARGET)
    assert found.proposals == ()
    assert not found.as_made.met
    best = found.fell_short[0]
    assert best.subject == "payload"
    assert best.checked.good.low < 0.9 < best.checked.good.high
    assert f"{100.0 * best.checked.good.estimate:.4g} %" in found.sentence
    assert found.sentence.startswith("No single change")


def test_what_only_the_rows_of_the_search_say_is_not_proposed() -> None:
    found = recommend(LearntByHeart({"payload": 2.0}), TARGET, most_lowering_mm=0.1)
    assert not found.as_made.met
    assert found.proposals == ()
    assert all(p.checked.good.high < 0.1 for p in found.fell_short)


@pytest.mark.parametrize("share", [0.9, 0.99])
def test_a_lower_target_needs_less(share: float) -> None:
    model = MarginBall({"payload": 0.2}, margin_of_lowering=growing)
    (proposal,) = of_kind(recommend(model, Target(Requirement(), share)).proposals, "lower_com")
    truth = float(chi(3).ppf(share)) * 0.2 - 0.1
    assert truth <= proposal.proposed < 1.12 * truth
