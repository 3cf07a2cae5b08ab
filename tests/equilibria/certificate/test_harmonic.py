"""Proofs of harmonic bodies: the shipped one, its relatives, and what must not be proven."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from decimal import Decimal
from types import MappingProxyType

import numpy as np
import pytest

from gomboc_cad.body import Body, make_body, mass_properties
from gomboc_cad.body.catalogue import (
    ExactParameters,
    catalogue_entries,
    exact_parameters,
    named_body,
    shipped_certificate,
)
from gomboc_cad.equilibria import smooth_census
from gomboc_cad.equilibria.certificate import Certificate, certify, dumps, loads, prover, verify
from gomboc_cad.equilibria.certificate.records import TURN_UNITS
from gomboc_cad.equilibria.certificate.straightening import straightening_chart
from gomboc_cad.equilibria.margin import com_margin
from gomboc_cad.products.inheritance import proven_margin_mm
from tests.equilibria.certificate.tampering import Document, verify_changed

TOLERANT = exact_parameters("tolerant-1")


def harmonic(coefficients: Mapping[str, str]) -> ExactParameters:
    return ExactParameters("harmonic", None, MappingProxyType(dict(coefficients)))


def scaled(factor: str, **changes: str) -> ExactParameters:
    """The tolerant body with f times a factor, and some coefficients of its own (`l_m`)."""
    coefficients = {key: str(Decimal(c) * Decimal(factor)) for key, c in TOLERANT.coefficients.items()}
    return harmonic({**coefficients, **{key.replace("_", ","): c for key, c in changes.items()}})


def body_of(parameters: ExactParameters) -> Body:
    return make_body(
        "harmonic", None, {key: float(c) for key, c in parameters.coefficients.items()}, diameter_mm=2.0
    )


@pytest.fixture(autouse=True)
def few_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    """Spend little on better bounds; what is proven stays as true."""
    monkeypatch.setattr(prover, "_CELLS_FOR_A_HARMONIC", 1_200)


@pytest.fixture(scope="module")
def mild() -> Iterator[Certificate]:
    """A body half as far from the sphere, and with no symmetry."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prover, "_CELLS_FOR_A_HARMONIC", 1_200)
        yield certify(scaled("0.5", **{"3_-1": "0.00007", "2_1": "-0.0001", "5_0": "0.0001"}))


def test_the_shipped_proof_reaches_nearly_what_the_census_finds() -> None:
    data = shipped_certificate("tolerant-1")
    assert data is not None
    c = loads(data)
    evidence = catalogue_entries()["tolerant-1"].evidence
    assert (c.status, c.strictly_convex, c.stable, c.unstable) == ("proven", True, 1, 1)
    assert c.convexity is not None
    assert c.margin is not None
    assert evidence.margin is not None
    assert 0.95 < float(c.convexity.curvature_above) / evidence.min_curvature < 1.0
    assert 0.98 < float(c.margin.com_margin) / evidence.margin < 1.0
    assert c.com_enclosure == (("0", "0"),) * 3
    low, high = (float(end) for end in c.volume_enclosure)
    assert low - 1e-12 < mass_properties(named_body("tolerant-1", 2.0)).volume_mm3 < high + 1e-12
    assert high - low < 1e-11
    assert len(data) < 1_000_000


def test_a_body_without_symmetry_is_proven(mild: Certificate) -> None:
    assert json.loads(dumps(mild))["beta"] is None
    census = smooth_census(body_of(mild.parameters))
    assert (census.stable, census.unstable) == (1, 1)
    assert mild.status == "proven"
    assert mild.convexity is not None
    assert mild.margin is not None
    assert census.convexity is not None
    assert census.margin is not None
    assert 0.8 < float(mild.convexity.curvature_above) / census.convexity.min_curvature_per_mm < 1.0
    assert 0.3 < float(mild.margin.com_margin) / census.margin.margin_mm < 1.0
    read = loads(dumps(mild))
    assert read == mild
    assert verify(read).accepted


@pytest.mark.slow
def test_the_chart_decides_how_much_work_not_whether_it_holds(
    mild: Certificate, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(prover, "straightening_chart", lambda parameters: ())
    other = certify(mild.parameters)
    assert other.status == "proven"
    assert verify(other).accepted
    assert mild.margin is not None
    assert other.margin is not None
    assert float(other.margin.com_margin) < float(mild.margin.com_margin)


CHANGES: dict[str, Callable[[Document], object]] = {
    "a body a little larger": lambda d: d["coefficients"].update({"2,-1": "0.01144"}),
    "another sign": lambda d: d["coefficients"].update({"3,1": "0.02051376142472488"}),
    "a dent": lambda d: d["coefficients"].update({"20,0": "0.003"}),
    "a centroid off the origin": lambda d: d["coefficients"].update({"1,0": "0.001"}),
    "a coefficient left out": lambda d: d["coefficients"].pop("2,-1"),
    "a β": lambda d: d.update(beta="0.02"),
    "a centroid elsewhere": lambda d: d["com_enclosure"].__setitem__(0, ["0.001", "0.001"]),
    "a higher curvature": lambda d: d["convexity"].update(curvature_above="0.6"),
    "a wider margin": lambda d: d["margin"].update(com_margin="0.0041"),
    "a cell left out": lambda d: d["margin"]["cells"].pop(700),
    "another chart": lambda d: d["chart"].__setitem__(1, "3.2"),
    "no chart": lambda d: d.pop("chart"),
    "a chart that is no number": lambda d: d["chart"].__setitem__(0, "nan"),
    "a chart of absurd degree": lambda d: d.update(chart=["0.1"] * 1000),
    "a centre of mass far off": lambda d: d.update(com=["0.02", "0", "0"]),
    "the discs swapped": lambda d: d["equilibria"].update(
        stable_disc=d["equilibria"]["unstable_disc"], unstable_disc=d["equilibria"]["stable_disc"]
    ),
    "a saddle that is none": lambda d: d.update(
        witness={"kind": "saddle", "theta": TURN_UNITS // 2, "psi": 0},
        status="refuted",
        stable=None,
        unstable=None,
    ),
}


@pytest.mark.parametrize("what", CHANGES)
def test_a_changed_claim_is_rejected(mild: Certificate, what: str) -> None:
    outcome = verify_changed(mild, CHANGES[what])
    assert not outcome.accepted
    assert outcome.reason.startswith("Rejected: ")


def test_a_dented_body_is_refuted() -> None:
    c = certify(scaled("1.02"))
    assert (c.status, c.strictly_convex, c.stable) == ("refuted", False, None)
    assert c.witness is not None
    assert verify(loads(dumps(c))).accepted
    changed = {"gaussian_curvature_below": "-0.2"}
    assert not verify_changed(c, lambda d: d["witness"].update(changed)).accepted


def test_an_ellipsoid_with_its_middle_axis_along_x_is_refuted_by_a_saddle() -> None:
    c = certify(harmonic({"2,0": "0.03", "2,2": "0.02"}))
    assert (c.status, c.strictly_convex, c.stable) == ("refuted", True, None)
    assert c.witness is not None
    assert c.witness.kind == "saddle"
    assert verify(loads(dumps(c))).accepted


@pytest.mark.parametrize(
    "tilted", [{"2,0": "0.03", "2,2": "0.02", "2,-2": "0.001"}, {"2,0": "0.03", "3,2": "0.01"}]
)
def test_a_saddle_counts_only_where_symmetry_makes_an_equilibrium(tilted: dict[str, str]) -> None:
    assert certify(harmonic(tilted)).witness is None


@pytest.mark.parametrize(
    "coefficients",
    [{"2,0": "0.03"}, {"2,0": "0.02", "2,2": "0.06"}, {"2,0": "1e-20", "3,1": "1e-18"}, {"40,0": "1e-5"}],
)
def test_what_has_more_equilibria_is_never_proven(coefficients: dict[str, str]) -> None:
    """A body of revolution, an ellipsoid that is longest along x, a sphere but for rounding, a ripple."""
    c = certify(harmonic(coefficients))
    assert c.status == "undecided"
    assert verify(c).accepted


def test_a_given_com_is_proven_with_the_margin_there() -> None:
    parameters, com = scaled("0.5"), ("-0.001", "0.0005", "-0.0007")
    c = certify(parameters, com=com)
    found = com_margin(body_of(parameters), np.array([float(x) for x in com])).margin_mm
    assert c.status == "proven"
    assert c.margin is not None
    assert 0.3 < float(c.margin.com_margin) / found < 1.0
    assert verify(loads(dumps(c))).accepted


def test_a_com_outside_the_zone_is_not_proven() -> None:
    assert certify(scaled("0.5"), com=("0.02", "0.01", "0")).status == "undecided"


def test_the_chart_follows_the_ridge() -> None:
    z, phi = np.linspace(-0.9, 0.9, 19), np.pi * np.arange(-2000, 2000) / 2000
    rho = np.sqrt(1.0 - z * z)[:, None]
    rings = np.stack(np.broadcast_arrays(rho * np.cos(phi), rho * np.sin(phi), z[:, None]), axis=-1)
    radii = body_of(TOLERANT).radius_at(rings.reshape(-1, 3)).reshape(len(z), -1)
    chart = np.polynomial.Polynomial([float(p) for p in straightening_chart(TOLERANT)])(z)
    off = (phi[radii.argmax(axis=1)] - chart + np.pi) % (2.0 * np.pi) - np.pi
    assert np.abs(off).max() < 0.6
    assert straightening_chart(harmonic({"2,0": "0.03", "2,2": "0.02"})) == ()


def test_a_product_inherits_the_proven_margin() -> None:
    body = named_body("tolerant-1", 60.0)
    at_centroid = proven_margin_mm(body, (0.0, 0.0, 0.0))
    assert at_centroid == pytest.approx(0.0074 * 30.0, abs=1e-6)
    assert proven_margin_mm(body, (0.06, 0.0, 0.0)) == pytest.approx(0.0074 * 30.0 - 0.06, abs=1e-6)


@pytest.mark.slow
def test_a_product_with_its_com_off_the_centroid_has_a_proof_of_its_own() -> None:
    body, com = named_body("tolerant-1", 60.0), (-0.15, 0.03, 0.0)
    proven = proven_margin_mm(body, com)
    assert proven is not None
    assert 0.3 < proven / com_margin(body, np.array(com)).margin_mm < 1.0
