"""The rules by which a figure is judged, and the published figures as data."""

from __future__ import annotations

import pytest

from gomboc_cad.paper.published import published
from gomboc_cad.paper.records import Figure, Verdict, judged, shown


@pytest.mark.parametrize(
    ("paper", "reproduced", "refuted", "verdict"),
    [
        (0.624, 0.62449, False, "agrees"),
        (0.624, 0.6246, False, "differs"),
        (3, 3, False, "agrees"),
        (3, 4, False, "differs"),
        (3, 3, True, "refuted"),
        (3, 4, True, "refuted"),
        ("never", "never", False, "agrees"),
        ("never", 0.1, False, "differs"),
        (0.01, None, False, "differs"),
    ],
)
def test_verdicts_follow_from_the_figures(
    paper: Figure, reproduced: Figure, refuted: bool, verdict: Verdict
) -> None:
    row = judged("figure", paper, reproduced, None, "none", "Because.", refuted=refuted)
    assert row.verdict == verdict


def test_a_stated_tolerance_decides_instead_of_the_digits_but_not_against_the_truth() -> None:
    assert judged("h", 0.051, 0.0519, 0.0518, "none", "So.", within=True).verdict == "agrees"
    assert judged("h", 0.051, 0.0511, 0.0518, "none", "So.", within=False).verdict == "differs"
    assert judged("h", 0.051, 0.0511, 0.0518, "none", "So.", within=True, refuted=True).verdict == "refuted"


@pytest.mark.parametrize(
    ("figure", "digits", "text"),
    [(1.0, 3, "1.000"), (-0.0004, 3, "0.000"), (41, 3, "41"), (None, 3, "–"), ("a ring", 3, "a ring")],
)
def test_figures_are_shown_in_the_papers_digits(figure: Figure, digits: int, text: str) -> None:
    assert shown(figure, digits) == text


def test_a_row_as_json_has_the_keys_that_scripts_rely_on() -> None:
    document = judged("label", 1, 2, 3, "closed form", "Why.").document()
    assert set(document) == {"label", "paper", "reproduced", "truth", "evidence", "verdict", "why"}


def test_the_published_figures_are_those_of_the_paper() -> None:
    figures = published()
    assert figures["beta_sweep"]["ecs"] == [38, 7, 4, 3, 2, 7, 11]
    assert figures["dynamics"]["gomboc"] == [1, 0.028, 0.051, 0.023, 1.0]
    assert figures["imu"]["improvement"] == 349
