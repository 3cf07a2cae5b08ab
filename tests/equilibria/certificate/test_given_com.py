"""Proofs about a centre of mass that is given, which the half-turn symmetry of the body does not help."""

from __future__ import annotations

import json

import numpy as np
import pytest
from flint import ctx

from gomboc_cad.body.catalogue import exact_parameters, named_body
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria import smooth_census
from gomboc_cad.equilibria.certificate import certify, dumps, loads, verify
from gomboc_cad.equilibria.certificate.geometry import ball_geometry
from gomboc_cad.equilibria.certificate.records import TURN_UNITS, Cell, Decimals
from gomboc_cad.errors import BodyError, InspectionError
from tests.equilibria.certificate.tampering import signed

PRIMARY = exact_parameters("primary")
ANYWHERE: Decimals = ("-0.0123", "0.0045", "0.0067")


def direction(cell: Cell) -> Array:
    """The direction of the cell's first corner, shape (3,)."""
    shape = named_body("primary", 2.0).shape
    theta, psi = np.pi * cell.theta_low / TURN_UNITS, np.pi * cell.psi_low / TURN_UNITS
    eta = 1.5 * np.pi * (np.cos(theta) - np.cos(theta) ** 3 / 3.0)
    phi = psi + eta + sum(a * np.sin(k * eta) for k, a in shape.terms)
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


@pytest.mark.parametrize("theta", [TURN_UNITS // 5, TURN_UNITS // 2, 4 * TURN_UNITS // 5])
@pytest.mark.parametrize("psi", [-TURN_UNITS // 3, 0, TURN_UNITS // 4, TURN_UNITS])
def test_the_hessian_is_that_of_the_distance(theta: int, psi: int) -> None:
    """Second differences of half the squared distance in the chart, about a centre of mass off all axes."""
    body, com = named_body("primary", 2.0), np.array(ANYWHERE, dtype=float)
    step = TURN_UNITS // 2048
    width = np.pi * step / TURN_UNITS

    def distance(i: int, j: int) -> float:
        u = direction(Cell.at(theta + i * step, psi + j * step))
        return 0.5 * float(np.sum((body.position_mm(u[None])[0] - com) ** 2))

    middle = distance(0, 0)
    expected = (
        (distance(1, 0) - 2.0 * middle + distance(-1, 0)) / width**2,
        (distance(1, 1) - distance(1, -1) - distance(-1, 1) + distance(-1, -1)) / (4.0 * width**2),
        (distance(0, 1) - 2.0 * middle + distance(0, -1)) / width**2,
    )
    with ctx.workprec(64):
        form = ball_geometry(PRIMARY, ANYWHERE).distance_hessian(Cell.at(theta, psi))
        found = [float(entry.mid()) for entry in form]
    assert found == pytest.approx(expected, abs=3e-4)


@pytest.mark.parametrize(
    "com", [("-0.00822", "0", "0"), ("-0.0082", "0.0003", "-0.0002"), ("-0.01", "0", "0")]
)
def test_a_com_in_the_zone_is_proven_with_the_margin_of_the_census(com: Decimals) -> None:
    made = certify(PRIMARY, com=com)
    census = smooth_census(named_body("primary", 2.0), tuple(float(c) for c in com))
    assert (census.stable, census.unstable) == (1, 1)
    assert made.status == "proven"
    assert made.margin is not None
    assert census.margin is not None
    assert 0.75 < float(made.margin.com_margin) / census.margin.margin_mm < 1.0
    read = loads(dumps(made))
    assert read == made
    assert verify(read).accepted
    assert ", ".join(com) in made.reason


def test_a_com_outside_the_zone_is_not_proven() -> None:
    com = ("0.01", "0.005", "0")
    assert smooth_census(named_body("primary", 2.0), (0.01, 0.005, 0.0)).stable > 1
    assert certify(PRIMARY, com=com).status == "undecided"


def test_a_com_outside_the_body_is_not_proven() -> None:
    assert certify(PRIMARY, com=("2", "0", "0")).status == "undecided"


def test_a_com_that_was_moved_is_rejected() -> None:
    """The proof holds for one centre of mass and is not repeated for another."""
    document = json.loads(dumps(certify(PRIMARY, com=("-0.00822", "0", "0"))))
    document["com"] = ["-0.00122", "0", "0"]
    with pytest.raises(InspectionError, match="digest"):
        loads(json.dumps(document))
    outcome = verify(loads(signed(document)))
    assert not outcome.accepted


@pytest.mark.parametrize("com", [("x", "0", "0"), ("nan", "0", "0"), ("1e999", "0", "0")])
def test_a_com_that_is_no_decimal_is_refused(com: Decimals) -> None:
    with pytest.raises(BodyError, match="decimal"):
        certify(PRIMARY, com=com)
