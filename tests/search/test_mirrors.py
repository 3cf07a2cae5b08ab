"""Bodies with two mirror planes: their harmonics, the start, and the search from it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.body import Body, Harmonic, mass_properties
from gomboc_cad.body.sphere import fibonacci_directions
from gomboc_cad.equilibria import com_margin, find_equilibria
from gomboc_cad.errors import BodyError
from gomboc_cad.search import Goal, Programming
from gomboc_cad.search.harmonic import CENTER, mirrored_indices, search_harmonic, symmetric_indices
from gomboc_cad.search.mirror_start import rising_coefficients

MIRRORS = ([1.0, -1.0, 1.0], [1.0, 1.0, -1.0])


def mirrored(coefficients: np.ndarray, degree: int) -> Body:
    terms = zip(mirrored_indices(degree), map(float, coefficients), strict=True)
    return Body("mirrored", Harmonic(tuple(terms)), 1.0)


@given(st.integers(2, 20), st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_the_planes_mirror_these_harmonics(degree: int, seed: int) -> None:
    degrees = [index[0] for index in mirrored_indices(degree)]
    random = np.random.default_rng(seed).normal(size=len(degrees))
    body = mirrored(0.02 * random / np.array(degrees) ** 3, degree)
    u = fibonacci_directions(50)
    for signs in MIRRORS:
        np.testing.assert_allclose(body.radius_at(u * signs), body.radius_at(u), rtol=1e-12)
    assert np.linalg.norm(mass_properties(body).com_mm) < 1e-12


def test_they_are_those_of_the_half_turn_that_have_no_sine() -> None:
    half_turn = {index for order in range(11) for index in symmetric_indices(order, 10 - order)}
    assert set(mirrored_indices(10)) == {(degree, m) for degree, m in half_turn if m >= 0}


def test_the_start_has_one_rest_and_one_top() -> None:
    body = mirrored(0.1 * rising_coefficients(mirrored_indices(12)), 12)
    poses = find_equilibria(body, CENTER)
    assert [pose.kind for pose in poses] == ["stable", "unstable"]
    np.testing.assert_allclose(poses[0].direction, (-1.0, 0.0, 0.0), atol=1e-9)
    np.testing.assert_allclose(poses[1].direction, (1.0, 0.0, 0.0), atol=1e-9)


def test_the_search_gains_from_there() -> None:
    goal = Goal("s-margin", min_curvature=0.3, min_margin=0.001)
    told: list[str] = []
    programming = Programming(symmetry="mirrors", mirrored_degree=10, steps=2)
    body = search_harmonic(goal, programming, told.append)
    assert told[0].startswith("two mirror planes: step 1 of at most 2: s-margin 0.00")
    begun = float(told[0].split("s-margin ")[1].split(" ")[0])
    assert com_margin(body, CENTER).margin_mm > 1.1 * begun
    u = fibonacci_directions(50)
    for signs in MIRRORS:
        np.testing.assert_allclose(body.radius_at(u * signs), body.radius_at(u), rtol=1e-12)


def test_an_unknown_symmetry_is_refused() -> None:
    with pytest.raises(BodyError, match="no symmetry 'cube'; choose one of half-turn, mirrors"):
        Programming(symmetry="cube")
