"""The catalogue: parameters, statuses, evidence recomputed, and sentences for bad parameters."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import pytest

from gomboc_cad.body import FourierSloan, Harmonic, catalog, catalogue_entries, make_body, mass_properties
from gomboc_cad.body import catalogue as catalogue_module
from gomboc_cad.body.catalogue import (
    CatalogueEntry,
    ExactParameters,
    catalogue_names,
    exact_parameters,
    named_body,
    shipped_certificate,
)
from gomboc_cad.equilibria import convexity, smooth_census
from gomboc_cad.errors import BodyError

PROVEN = [
    "primary",
    "sloan2-0.020",
    "sloan2-0.030",
    "sloan2-0.035",
    "second-convex",
    "third-convex",
    "tolerant-1",
    "tolerant-2",
    "tolerant-k05",
    "tolerant-k10",
    "extended-k05",
    "stiff-k05",
]
REFUTED = ["second", "third"]


def test_names_and_statuses() -> None:
    assert {name: entry.status for name, entry in catalogue_entries().items()} == {
        **dict.fromkeys(PROVEN, "proven"),
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


@pytest.mark.parametrize(("name", "times"), [("tolerant-1", 2.0), ("tolerant-2", 3.0), ("tolerant-k10", 3.0)])
def test_the_tolerant_bodies_have_a_multiple_of_the_margin_of_the_primary(name: str, times: float) -> None:
    entries = catalogue_entries()
    tolerant, primary = entries[name], entries["primary"]
    assert tolerant.beta is None
    assert isinstance(tolerant.body.shape, Harmonic)
    assert mass_properties(tolerant.body).com_mm == pytest.approx((0.0, 0.0, 0.0), abs=1e-13)
    assert tolerant.evidence.margin is not None
    assert primary.evidence.margin is not None
    assert tolerant.evidence.margin > times * primary.evidence.margin


def test_the_stiff_body_rests_far_more_firmly_than_the_primary() -> None:
    softest = [
        min(smooth_census(named_body(name), margins=False).rest.stiffness_mm)
        for name in ("stiff-k05", "primary")
    ]
    assert softest[0] > 30.0 * softest[1]


@pytest.fixture
def read_again() -> Iterator[Callable[[], Mapping[str, CatalogueEntry]]]:
    """Read the catalogue anew, and once more when the test is over."""

    def forget() -> None:
        catalogue_entries.cache_clear()
        catalogue_module._certificate_index.cache_clear()

    def read() -> Mapping[str, CatalogueEntry]:
        forget()
        return catalogue_entries()

    yield read
    forget()


@pytest.mark.parametrize("damage", ["certificate", "parameters", "no certificate", "not in the index"])
def test_a_certificate_counts_only_for_its_own_bytes_and_decimals(
    damage: str,
    read_again: Callable[[], Mapping[str, CatalogueEntry]],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    for name in catalogue_names():
        (tmp_path / f"{name}.json").write_bytes(shipped_certificate(name) or b"")
    index = json.loads((catalogue_module._CERTIFICATES / catalogue_module.INDEX_NAME).read_text("utf-8"))
    primary = tmp_path / "primary.json"
    if damage == "certificate":
        primary.write_bytes(primary.read_bytes() + b" ")
    elif damage == "parameters":
        index["primary"]["parameters"]["beta"] = "0.0231490"
    elif damage == "no certificate":
        primary.unlink()
    else:
        del index["primary"]
    (tmp_path / catalogue_module.INDEX_NAME).write_text(json.dumps(index), encoding="utf-8")
    monkeypatch.setattr(catalogue_module, "_CERTIFICATES", tmp_path)
    entries = read_again()
    assert entries["primary"].status == "computed"
    assert entries["sloan2-0.030"].status == "proven"


def test_exact_parameters_are_the_decimals_of_the_file() -> None:
    assert exact_parameters("primary") == ExactParameters("extended", "0.023149", {"1": "0.234433"})
    assert exact_parameters("sloan2-0.030") == ExactParameters("sloan2", "0.03", {})
    for name, entry in catalogue_entries().items():
        assert ExactParameters.of(entry.body) == exact_parameters(name)
    with pytest.raises(BodyError, match="no body named"):
        exact_parameters("zzz")
    with pytest.raises(BodyError, match="no body named"):
        shipped_certificate("../catalogue")


@pytest.mark.parametrize("name", PROVEN + REFUTED)
def test_the_recorded_curvatures_are_what_the_search_finds(name: str) -> None:
    entry = catalogue_entries()[name]
    found = convexity(entry.body.with_diameter(2.0))
    tolerance = 2e-6 if entry.status == "proven" else 2e-4
    assert found.min_curvature_per_mm == pytest.approx(entry.evidence.min_curvature, abs=tolerance)
    assert found.min_gaussian_curvature_per_mm2 == pytest.approx(
        entry.evidence.min_gaussian_curvature, abs=tolerance
    )
    assert found.strictly_convex == (entry.status == "proven")


@pytest.mark.parametrize("name", PROVEN)
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
