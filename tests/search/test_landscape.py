"""The quick look at a body agrees with the exact census, which searches the whole surface.

The catalogue's figures are computed again by the tests of the catalogue.
"""

from __future__ import annotations

import numpy as np
import pytest

from gomboc_cad.body import Body, mass_properties
from gomboc_cad.body.catalogue import catalogue_entries, make_body, named_body
from gomboc_cad.equilibria import com_margin, smooth_census
from gomboc_cad.search.landscape import Landscape, survey


def surveyed(body: Body) -> Landscape:
    landscape = survey(body, np.array(mass_properties(body).com_mm))
    assert landscape is not None
    return landscape


# In tolerant-k05 the curvature is least in a trough as narrow as the grid and askew to it.
@pytest.mark.parametrize("name", ["primary", "sloan2-0.035", "third-convex", "tolerant-1", "tolerant-k05"])
def test_margins_and_curvature_are_those_of_the_catalogue(name: str) -> None:
    evidence = catalogue_entries()[name].evidence
    found = surveyed(named_body(name, 2.0))
    assert found.s_distance_mm.min() == pytest.approx(evidence.s_margin, abs=5e-7)
    assert found.u_distance_mm.min() == pytest.approx(evidence.u_margin, abs=5e-7)
    assert found.min_curvature_per_mm == pytest.approx(evidence.min_curvature, abs=2e-6)


def test_height_range_and_stiffness_are_those_of_the_census() -> None:
    body = named_body("primary", 2.0)
    found, census = surveyed(body), smooth_census(body)
    assert found.height_range_mm == pytest.approx(census.height_range_mm, rel=1e-9)
    assert found.stiffness_mm == pytest.approx(census.rest.stiffness_mm[0], rel=1e-9)


def test_lengths_grow_with_the_body() -> None:
    small, large = (surveyed(named_body("primary", diameter)) for diameter in (2.0, 100.0))
    assert large.margin_mm == pytest.approx(50.0 * small.margin_mm, rel=1e-6)
    assert large.height_range_mm == pytest.approx(50.0 * small.height_range_mm, rel=1e-9)
    assert large.min_curvature_per_mm == pytest.approx(small.min_curvature_per_mm / 50.0, rel=1e-9)


def test_margins_hold_away_from_the_catalogue() -> None:
    # No optimum, so the nearest places are not where they were.
    random = np.random.default_rng(1)
    terms = catalogue_entries()["tolerant-1"].coefficients
    changed = {key: c * float(random.uniform(0.8, 1.0)) for key, c in terms.items()}
    body = make_body("harmonic", None, changed, diameter_mm=2.0)
    found, exact = surveyed(body), com_margin(body, (0.0, 0.0, 0.0))
    assert found.s_distance_mm.min() == pytest.approx(exact.s_margin_mm, rel=1e-3)
    assert found.u_distance_mm.min() == pytest.approx(exact.u_margin_mm, rel=1e-3)
    assert exact.margin_mm < 0.007


def test_a_dented_body_has_no_landscape() -> None:
    assert survey(named_body("second", 2.0), np.zeros(3)) is None


@pytest.mark.parametrize(
    "coefficients",
    [
        pytest.param({"2,0": 0.02, "2,2": 0.01}, id="like an ellipsoid: two rests"),
        pytest.param({"3,1": 0.02, "3,3": 0.02}, id="three lobes"),
    ],
)
def test_a_body_with_more_than_two_poses_has_no_landscape(coefficients: dict[str, float]) -> None:
    body = make_body("harmonic", None, coefficients, diameter_mm=2.0)
    census = smooth_census(body)
    assert census.stable + census.unstable > 2
    assert survey(body, np.zeros(3)) is None
