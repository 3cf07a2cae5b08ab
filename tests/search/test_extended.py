"""Differential evolution over the extended family, and what is written of its result."""

from __future__ import annotations

import tomllib
from functools import lru_cache
from pathlib import Path

import pytest

from gomboc_cad.body.catalogue import ExactParameters, catalogue_entries, make_body
from gomboc_cad.errors import BodyError
from gomboc_cad.products.body_spec import BodySpec
from gomboc_cad.search import (
    Design,
    Evolution,
    Goal,
    Programming,
    design_body,
    judge,
    search_method,
    write_body_file,
)
from gomboc_cad.search.extended import search_extended

GOAL = Goal("s-margin", min_curvature=0.088)
SHORT = Evolution(orders=(1,), seed=1, population=8, generations=2)


@lru_cache(maxsize=1)
def design() -> Design:
    return design_body(GOAL, SHORT)


def test_it_finds_more_margin_than_the_primary_at_the_same_curvature() -> None:
    primary = catalogue_entries()["primary"].evidence
    figures = design().figures
    assert primary.margin is not None
    assert min(figures.s_margin, figures.u_margin) > 1.1 * primary.margin
    assert figures.min_curvature >= 0.088


def test_it_ends_with_a_proof_of_exactly_its_decimals() -> None:
    found = design()
    assert found.accepted
    assert found.certificate.status == "proven"
    assert found.certificate.parameters == ExactParameters.of(found.body)
    assert found.certificate.margin is not None
    assert float(found.certificate.margin.com_margin) <= min(found.figures.s_margin, found.figures.u_margin)
    assert found.reasons == (found.certificate.reason,)


def test_the_file_is_the_body_table_of_a_spec(tmp_path: Path) -> None:
    file = tmp_path / "body.toml"
    write_body_file(design(), file)
    text = file.read_text(encoding="utf-8")
    spec = BodySpec.model_validate(tomllib.loads(text)["body"])
    assert ExactParameters.of(spec.body()) == ExactParameters.of(design().body)
    assert "Proven: strictly convex" in text
    assert max(map(len, text.splitlines())) <= 110


def test_the_same_seed_gives_the_same_body() -> None:
    quick = Evolution(orders=(1,), seed=5, population=3, generations=1)
    goal = Goal("height-range", min_curvature=0.3, min_margin=0.0005)
    assert search_extended(goal, quick) == search_extended(goal, quick)


def test_progress_is_told_and_can_cancel() -> None:
    told: list[str] = []

    def cancel(stage: str) -> None:
        told.append(stage)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        search_extended(GOAL, Evolution(orders=(1,), population=3, generations=9), cancel)
    assert told == [told[0]]
    assert told[0].startswith("generation 1 of at most 9: ")


def test_constraints_that_no_body_meets_are_said_so() -> None:
    goal = Goal("s-margin", min_curvature=0.9, min_margin=0.01)
    with pytest.raises(BodyError, match="no body within the constraints"):
        search_extended(goal, Evolution(orders=(1,), population=3, generations=1))


def test_a_proven_body_that_misses_a_constraint_is_not_accepted() -> None:
    body = catalogue_entries()["sloan2-0.030"].body
    found = judge(body, Goal("s-margin", min_curvature=0.5, min_margin=0.002))
    assert found.certificate.status == "proven"
    assert found.missed == ("smallest curvature", "smallest margin")
    assert not found.accepted
    assert "misses the smallest curvature and the smallest margin" in found.reasons[-1]
    # Figures are in units of the nominal radius, whatever it is.
    evidence = catalogue_entries()["sloan2-0.030"].evidence
    assert found.figures.s_margin == pytest.approx(evidence.s_margin, rel=1e-5)
    assert found.figures.min_curvature == pytest.approx(evidence.min_curvature, abs=2e-6)


def test_a_body_with_two_rests_is_not_accepted_and_its_file_says_so() -> None:
    body = make_body("harmonic", None, {"2,0": 0.02, "2,2": 0.01}, diameter_mm=2.0)
    found = judge(body, Goal("s-margin", min_curvature=0.1, min_margin=0.001))
    assert (found.census.stable, found.census.unstable) == (2, 2)
    assert not found.accepted
    assert "The census finds 2 stable and 2 unstable poses." in found.reasons
    assert "# " + found.certificate.reason[:30] in found.as_toml()


def test_a_search_is_chosen_by_its_family() -> None:
    assert search_method("extended", seed=7) == Evolution(seed=7)
    assert search_method("extended", seed=7, steps=3) == Evolution(seed=7, generations=3)
    assert search_method("harmonic", seed=7) == Programming()
    assert search_method("harmonic", steps=3) == Programming(steps=3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Goal("u-margin"), "no objective 'u-margin'; choose one of s-margin, height-range"),
        (lambda: Goal(min_curvature=0.0), "smallest curvature must be"),
        (lambda: Goal(min_curvature=float("nan")), "smallest curvature must be"),
        (lambda: Goal(min_margin=-1.0), "smallest margin must be"),
        (lambda: Evolution(orders=()), "different orders"),
        (lambda: Evolution(orders=(1, 1)), "different orders"),
        (lambda: Evolution(orders=(0,)), "different orders"),
        (lambda: Evolution(generations=0), "generations"),
        (lambda: search_method("sloan2"), "no search in the family 'sloan2'; choose extended or harmonic"),
    ],
)
def test_wrong_wishes_are_refused(make: object, message: str) -> None:
    assert callable(make)
    with pytest.raises(BodyError, match=message):
        make()
