"""What can be proven, against limits and figures that were found another way."""

from __future__ import annotations

import pytest

from gomboc_cad.body import make_body
from gomboc_cad.body.catalogue import ExactParameters, catalogue_entries, exact_parameters
from gomboc_cad.equilibria import Census, smooth_census
from gomboc_cad.equilibria.certificate import Certificate, certify, dumps, loads, verify
from gomboc_cad.errors import BodyError

CONVEX = ["primary", "sloan2-0.020", "sloan2-0.030", "sloan2-0.035", "second-convex", "third-convex"]


def sloan(beta: str, **coefficients: str) -> ExactParameters:
    return ExactParameters(
        "extended" if coefficients else "sloan2", beta, {k[1:]: a for k, a in coefficients.items()}
    )


def test_the_primary_is_proven(primary_certificate: Certificate, primary_census: Census) -> None:
    c = primary_certificate
    assert (c.status, c.strictly_convex, c.stable, c.unstable) == ("proven", True, 1, 1)
    assert c.convexity is not None
    assert c.margin is not None
    # Proven bounds are below what the census finds, and not by much.
    found = primary_census.convexity
    assert found is not None
    assert 0.9 < float(c.convexity.curvature_above) / found.min_curvature_per_mm < 1.0
    assert primary_census.margin is not None
    assert 0.8 < float(c.margin.com_margin) / primary_census.margin.margin_mm < 1.0
    low, high = (float(end) for end in c.com_enclosure[0])
    assert low <= high
    assert low == pytest.approx(primary_census.com_mm[0], abs=1e-14)
    assert "exactly one stable and one unstable" in c.reason


@pytest.mark.parametrize("name", CONVEX)
def test_convex_bodies_are_proven_with_bounds_near_those_of_the_census(name: str) -> None:
    c = certify(exact_parameters(name))
    evidence = catalogue_entries()[name].evidence
    assert c.status == "proven"
    assert c.convexity is not None
    assert c.margin is not None
    assert evidence.margin is not None
    assert 0.9 < float(c.convexity.curvature_above) / evidence.min_curvature < 1.0
    assert 0.8 < float(c.margin.com_margin) / evidence.margin < 1.0


@pytest.mark.parametrize(
    ("parameters", "status"),
    [
        (sloan("0.0355"), "proven"),
        (sloan("0.03551"), "refuted"),
        (sloan("0.0237", k2="0.1376"), "proven"),
        (sloan("0.0239", k2="0.1376"), "refuted"),
        (sloan("0.0315", k3="-0.0552"), "proven"),
        (sloan("0.0317", k3="-0.0552"), "refuted"),
    ],
)
def test_the_limits_of_convexity(parameters: ExactParameters, status: str) -> None:
    """β < 0.035505 for Sloan 2, < 0.0238 and < 0.0316 for the families of the second and third instance."""
    c = certify(parameters)
    assert c.status == status
    assert c.strictly_convex == (status == "proven")
    assert verify(c).accepted


def test_a_dented_body_is_refuted_at_its_deepest_dent(refuted_certificate: Certificate) -> None:
    c = refuted_certificate
    assert (c.status, c.strictly_convex, c.stable, c.unstable) == ("refuted", False, None, None)
    assert c.witness is not None
    evidence = catalogue_entries()["second"].evidence
    assert float(c.witness.gaussian_curvature_below or 0) == pytest.approx(
        evidence.min_gaussian_curvature, rel=0.01
    )


def test_a_convex_body_that_rests_in_two_ways_is_refuted_by_a_saddle() -> None:
    c = certify(sloan("0.02", k1="-0.3"))
    assert (c.status, c.strictly_convex, c.stable) == ("refuted", True, None)
    assert c.witness is not None
    assert c.witness.kind == "saddle"
    assert verify(c).accepted
    census = smooth_census(make_body("extended", 0.02, {"1": -0.3}, diameter_mm=2.0))
    assert census.stable > 1
    saddles = [e.direction for e in census.equilibria if e.kind == "saddle"]
    assert any(abs(abs(x) - 1.0) < 1e-9 for x, _, _ in saddles)


def test_what_cannot_be_shown_stays_undecided() -> None:
    """This convex body has three stable rests, and both directions of the x-axis are extremes."""
    c = certify(sloan("0.0078", k1="-0.231", k2="-0.033", k3="-0.093"))
    assert (c.status, c.strictly_convex, c.stable, c.unstable) == ("undecided", True, None, None)
    assert c.reason.startswith("Undecided: strictly convex")
    assert verify(c).accepted


def test_a_body_that_is_a_sphere_but_for_rounding_claims_no_more_than_it_can() -> None:
    c = certify(sloan("1e-30"))
    assert verify(c).accepted
    assert c.margin is None


@pytest.mark.parametrize("coefficients", [{"1": "1000"}, {str(k): "1" for k in range(969, 1001)}])
def test_wild_windings_end_in_a_refutation(coefficients: dict[str, str]) -> None:
    """The second one's centroid is not even known to a hundredth, which its refutation does not need."""
    c = certify(ExactParameters("extended", "0.01", coefficients))
    assert c.status == "refuted"
    assert verify(c).accepted


def test_the_same_parameters_give_the_same_bytes(primary_certificate: Certificate) -> None:
    assert dumps(certify(exact_parameters("primary"))) == dumps(primary_certificate)


def test_a_certificate_reads_back_equal(
    primary_certificate: Certificate, refuted_certificate: Certificate
) -> None:
    for certificate in (primary_certificate, refuted_certificate):
        assert loads(dumps(certificate)) == certificate
        assert loads(dumps(certificate).encode()) == certificate


def test_parameters_of_a_body_are_the_decimals_that_were_typed() -> None:
    body = make_body("extended", 0.023149, {"1": 0.234433, "3": -0.0552})
    assert ExactParameters.of(body) == ExactParameters(
        "extended", "0.023149", {"1": "0.234433", "3": "-0.0552"}
    )


def test_other_families_are_refused_with_a_sentence() -> None:
    with pytest.raises(BodyError, match="not for 'sloan1'; the census judges the others"):
        certify(ExactParameters.of(make_body("sloan1", 0.02)))


def test_progress_is_told_by_stage() -> None:
    told: list[str] = []
    certificate = certify(exact_parameters("sloan2-0.035"), told.append)
    verify(certificate, told.append)
    assert told[0] == "proving strict convexity"
    assert "enclosing the centroid" in told
