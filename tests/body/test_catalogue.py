"""The catalogue: parameters, statuses, evidence recomputed, and sentences for bad parameters."""

from __future__ import annotations

import math

import pytest

from gomboc_cad.body import FourierSloan, Harmonic, catalog, catalogue_entries, make_body
from gomboc_cad.body.catalogue import named_body
from gomboc_cad.equilibria import convexity, smooth_census
from gomboc_cad.errors import BodyError

COMPUTED = ["primary", "sloan2-0.020", "sloan2-0.030", "sloan2-0.035"]
REFUTED = ["second", "third"]


def test_names_and_statuses() -> None:
    assert {name: entry.status for name, entry in catalogue_entries().items()} == {
        **dict.fromkeys(COMPUTED, "computed"),
        **dict.fromkeys(REFUTED, "refuted"),
    }
    for entry in catalogue_entries().values():
        assert entry.reason.endswith(".")
        assert entry.source
        assert entry.body.diameter_mm == 100.0


def test_the_primary_carries_the_full_precision_coefficients() -> None:
    entry = catalogue_entries()["primary"]
    assert entry.beta == 0.023149
    assert entry.coefficients == {"1": 0.234433}
    assert entry.body.shape == FourierSloan(0.023149, ((1, 0.234433),))


@pytest.mark.parametrize("name", COMPUTED + REFUTED)
def test_the_recorded_curvatures_are_what_the_search_finds(name: str) -> None:
    entry = catalogue_entries()[name]
    found = convexity(entry.body.with_diameter(2.0))
    tolerance = 2e-6 if entry.status == "computed" else 2e-4
    assert found.min_curvature_per_mm == pytest.approx(entry.evidence.min_curvature, abs=tolerance)
    assert found.min_gaussian_curvature_per_mm2 == pytest.approx(
        entry.evidence.min_gaussian_curvature, abs=tolerance
    )
    assert found.strictly_convex == (entry.status == "computed")


@pytest.mark.parametrize("name", COMPUTED)
def test_the_recorded_margins_and_counts_are_what_the_census_finds(name: str) -> None:
    entry = catalogue_entries()[name]
    census = smooth_census(entry.body.with_diameter(2.0))
    assert (census.stable, census.unstable, census.saddles) == (1, 1, 0)
    assert census.margin.margin_mm == pytest.approx(entry.evidence.margin, rel=1e-5)
    assert census.margin.s_margin_mm == pytest.approx(entry.evidence.s_margin, rel=1e-5)
    assert census.margin.u_margin_mm == pytest.approx(entry.evidence.u_margin, rel=1e-5)


def test_the_catalogue_cannot_be_changed_by_its_readers() -> None:
    with pytest.raises(TypeError):
        catalog()["primary"] = catalog()["second"]  # type: ignore[index]
    with pytest.raises(TypeError):
        catalogue_entries()["primary"].coefficients["1"] = 0.0  # type: ignore[index]


def test_a_misspelt_name_is_answered_with_the_nearest() -> None:
    with pytest.raises(BodyError, match=r"no body named 'primry' .* did you mean primary"):
        named_body("primry")
    with pytest.raises(BodyError, match="did you mean primary or"):
        named_body("zzz")


@pytest.mark.parametrize("diameter", [0.0, -1.0, math.nan, math.inf])
def test_a_senseless_diameter_is_refused(diameter: float) -> None:
    with pytest.raises(BodyError, match="nominal radius must be between"):
        named_body("primary", diameter)


@pytest.mark.parametrize(
    ("family", "beta", "coefficients", "sentence"),
    [
        ("gomboc", 0.02, None, "no family 'gomboc'; choose one of sloan1, sloan2, extended, harmonic"),
        ("sloan2", None, None, "'sloan2' needs beta"),
        ("sloan1", math.nan, None, "beta = nan is outside"),
        ("sloan1", math.inf, None, "beta = inf is outside"),
        ("sloan2", -0.01, None, "beta = -0.01 is outside"),
        ("sloan2", 0.25, None, "beta = 0.25 is outside 0 ≤ beta < 0.25"),
        ("sloan2", 0.02, {"1": 0.1}, "'sloan2' takes no coefficients; use the extended family"),
        ("extended", 0.02, {}, "needs at least one coefficient"),
        ("extended", 0.02, {"0": 0.1}, "needs an integer order k ≥ 1"),
        ("extended", 0.02, {"-3": 0.1}, "needs an integer order k ≥ 1"),
        ("extended", 0.02, {"1": math.nan}, "finite a"),
        ("extended", 0.02, {"1": -math.inf}, "finite a"),
        ("extended", 0.02, {"1": 1e308}, "k |a| ≤ 1000"),
        ("extended", 0.02, {"1": 0.1, "01": 0.2}, "may be given once only"),
        ("extended", 0.02, {"1.5": 0.1}, "coefficient key '1.5' must be an integer k"),
        ("extended", 0.02, {"2,1": 0.1}, "coefficient key '2,1' must be an integer k"),
        ("harmonic", 0.02, {"2,0": 0.1}, "takes no beta"),
        ("harmonic", None, {"2": 0.1}, "coefficient key '2' must be two integers l,m"),
        ("harmonic", None, {"a,b": 0.1}, "must be two integers l,m"),
        ("harmonic", None, {"1,0": 0.01}, "l = 1, m = 0"),
        ("harmonic", None, {"41,0": 0.01}, "2 ≤ l ≤ 40"),
        ("harmonic", None, {"3,4": 0.01}, "|m| ≤ l"),
        ("harmonic", None, {"3,1": math.nan}, "finite c"),
        ("harmonic", None, {"2,0": 0.01, "2, 0": 0.01}, "may be given once only"),
        ("harmonic", None, {"2,0": -0.5}, "too large: the radius is not real and positive everywhere"),
    ],
)
def test_bad_parameters_are_refused_with_a_sentence(
    family: str, beta: float | None, coefficients: dict[str, float] | None, sentence: str
) -> None:
    with pytest.raises(BodyError) as caught:
        make_body(family, beta, coefficients)
    text = str(caught.value)
    assert sentence in text
    assert text.endswith(".")
    assert "\n" not in text


def test_a_fractional_order_is_refused_by_the_family_itself() -> None:
    with pytest.raises(BodyError, match="integer order"):
        FourierSloan(0.02, ((1.5, 0.1),))  # type: ignore[arg-type]


def test_bodies_are_equal_by_value_so_that_results_can_be_kept() -> None:
    one, other = make_body("sloan2", 0.02), make_body("sloan2", 0.02)
    assert one == other
    assert hash(one) == hash(other)
    assert one != make_body("sloan2", 0.021)
    assert one.with_diameter(10.0).radius_mm == 5.0


def test_a_name_describes_the_parameters() -> None:
    assert make_body("extended", 0.02, {"1": 0.5}).name == "extended(beta=0.02, 1=0.5)"
    assert make_body("harmonic", None, {"2,0": 0.01}).name == "harmonic(2,0=0.01)"
    assert make_body("harmonic", None, {}).shape == Harmonic()
