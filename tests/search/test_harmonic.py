"""Sequential linear programming in the harmonic family."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.body import mass_properties
from gomboc_cad.body.catalogue import ExactParameters, exact_parameters, make_body
from gomboc_cad.body.families import FourierSloan, Harmonic
from gomboc_cad.body.sphere import fibonacci_directions
from gomboc_cad.equilibria import com_margin, convexity
from gomboc_cad.errors import BodyError
from gomboc_cad.search import Goal, Programming, design_body
from gomboc_cad.search.harmonic import CENTER, projected, search_harmonic, symmetric_indices
from gomboc_cad.search.landscape import survey

HALF_TURN = np.array([1.0, -1.0, -1.0])


@given(st.integers(0, 8), st.integers(2, 16), st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_the_harmonics_are_symmetric_and_centred(order: int, top: int, seed: int) -> None:
    indices = symmetric_indices(order, top)
    random = np.random.default_rng(seed).normal(size=len(indices))
    terms = {
        f"{degree},{m}": float(0.02 * c / degree**2) for (degree, m), c in zip(indices, random, strict=True)
    }
    body = make_body("harmonic", None, terms, diameter_mm=2.0)
    u = fibonacci_directions(50)
    np.testing.assert_allclose(body.radius_at(u * HALF_TURN), body.radius_at(u), rtol=1e-12)
    assert np.linalg.norm(mass_properties(body).com_mm) < 1e-12


def test_the_trial_body_has_exactly_these_harmonics() -> None:
    mine = set(symmetric_indices(1, 16)).union(*(symmetric_indices(m, 10) for m in (0, 2, 3, 4)))
    theirs = {
        tuple(int(part) for part in key.split(",")) for key in exact_parameters("tolerant-1").coefficients
    }
    assert mine == theirs


def test_sloan_2_is_a_sum_of_these_harmonics() -> None:
    shape, indices = FourierSloan(0.03), symmetric_indices(1, 24)
    sum_of = Harmonic(tuple(zip(indices, map(float, projected(shape, indices)), strict=True)))
    u = fibonacci_directions(500)
    np.testing.assert_allclose(sum_of.ambient_jet(u).value, shape.ambient_jet(u).value, atol=1e-9)


def test_few_steps_with_the_first_order_alone_double_the_margin_of_sloan_2() -> None:
    told: list[str] = []
    goal = Goal("s-margin", min_curvature=0.1, min_margin=0.001)
    body = search_harmonic(goal, Programming(first_degree=10, orders=1, other_degree=2, steps=5), told.append)
    # Sloan 2 has 0.0013 at the amplitude that curves as little.
    assert com_margin(body, (0.0, 0.0, 0.0)).margin_mm > 0.0026
    assert convexity(body).min_curvature_per_mm >= 0.1
    assert told[0].startswith("order 1 alone: step 1 of at most 5: s-margin 0.001")


@pytest.mark.parametrize(("objective", "gain"), [("height-range", 1.2), ("stiffness", 5.0)])
def test_other_objectives_grow_and_keep_the_margin(objective: str, gain: float) -> None:
    goal = Goal(objective, min_curvature=0.1, min_margin=0.0025)
    body = search_harmonic(goal, Programming(first_degree=10, other_degree=2, orders=1, steps=12))
    found, sloan = survey(body, CENTER), survey(make_body("sloan2", 0.03, diameter_mm=2.0), CENTER)
    assert found is not None
    assert sloan is not None
    assert goal.value(found) > gain * goal.value(sloan)
    assert convexity(body).min_curvature_per_mm >= 0.1
    assert com_margin(body, CENTER).margin_mm >= 0.0025


def test_progress_can_cancel() -> None:
    def cancel(stage: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        search_harmonic(Goal(), Programming(first_degree=8, steps=2), cancel)


def test_a_curvature_that_no_start_has_is_said_so() -> None:
    with pytest.raises(BodyError, match=r"No start of these degrees has all curvatures above 0\.95"):
        search_harmonic(Goal(min_curvature=0.95), Programming())


@pytest.mark.parametrize(
    "wrong", [{"first_degree": 7}, {"other_degree": 31}, {"mirrored_degree": 9}, {"orders": 9}, {"steps": 0}]
)
def test_degrees_outside_the_family_are_refused(wrong: dict[str, int]) -> None:
    with pytest.raises(BodyError, match="degrees must be"):
        Programming(**wrong)


@pytest.mark.slow
def test_it_finds_the_like_of_the_trial_body_by_itself_and_proves_it() -> None:
    """The trial: 0.00748 and 0.00748 at a smallest curvature of 0.010."""
    found = design_body(Goal("s-margin", min_curvature=0.01), Programming(steps=10))
    assert found.figures.s_margin >= 0.0074
    assert found.figures.u_margin >= 0.0074
    assert found.figures.min_curvature >= 0.01
    assert found.accepted
    assert found.certificate.margin is not None
    assert float(found.certificate.margin.com_margin) >= 0.0065
    assert found.certificate.parameters == ExactParameters.of(found.body)
