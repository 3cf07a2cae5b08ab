"""A changed certificate is rejected, even if it is signed again: each claim is proven from the decimals."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from flint import ctx
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.equilibria.certificate import Certificate, certify, dumps, loads, verify
from gomboc_cad.equilibria.certificate.geometry import ball_geometry
from gomboc_cad.equilibria.certificate.records import SPHERE, TURN_UNITS, Cell
from gomboc_cad.errors import InspectionError
from tests.equilibria.certificate.tampering import Document, verify_changed

LISTS: tuple[tuple[str, ...], ...] = (
    ("convexity", "cells"),
    ("equilibria", "cells"),
    ("margin", "cells"),
    ("equilibria", "stable_disc", "cells"),
    ("equilibria", "unstable_disc", "cells"),
)


def at(document: Document, path: tuple[str, ...]) -> Any:
    value: Any = document
    for key in path:
        value = value[key]
    return value


def test_untouched_certificates_are_accepted(
    primary_certificate: Certificate, refuted_certificate: Certificate
) -> None:
    for certificate in (primary_certificate, refuted_certificate):
        outcome = verify_changed(certificate, lambda document: None)
        assert outcome.accepted
        assert outcome.reason == certificate.reason


@settings(max_examples=60, deadline=None)
@given(path=st.sampled_from(LISTS), data=st.data())
def test_a_removed_cell_leaves_a_gap(
    primary_certificate: Certificate, path: tuple[str, ...], data: st.DataObject
) -> None:
    def remove(document: Document) -> None:
        cells = at(document, path)
        cells.pop(data.draw(st.integers(0, len(cells) - 1)))

    outcome = verify_changed(primary_certificate, remove)
    assert not outcome.accepted
    assert "cover" in outcome.reason or "empty" in outcome.reason


@settings(max_examples=40, deadline=None)
@given(path=st.sampled_from(LISTS), data=st.data())
def test_a_cell_made_smaller_by_the_least_unit_leaves_a_gap(
    primary_certificate: Certificate, path: tuple[str, ...], data: st.DataObject
) -> None:
    def shrink(document: Document) -> None:
        cells = at(document, path)
        index = data.draw(st.integers(0, len(cells) - 1))
        numbers = cells[index].split()
        edge = data.draw(st.integers(0, 3))
        numbers[edge] = str(int(numbers[edge]) + (1 if edge in (0, 2) else -1))
        cells[index] = " ".join(numbers)

    outcome = verify_changed(primary_certificate, shrink)
    assert not outcome.accepted
    assert "cover" in outcome.reason


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_a_flipped_sign_of_a_cell_is_rejected(primary_certificate: Certificate, data: st.DataObject) -> None:
    def flip(document: Document) -> None:
        cells = document["equilibria"]["cells"]
        index = data.draw(st.integers(0, len(cells) - 1))
        swapped = {"s": "u", "u": "s"}.get(cells[index][-1], cells[index][-1].swapcase())
        cells[index] = cells[index][:-1] + swapped

    outcome = verify_changed(primary_certificate, flip)
    assert not outcome.accepted
    assert "of equilibria does not hold" in outcome.reason


CHANGES: dict[str, Callable[[Document], object]] = {
    "another β, not convex": lambda d: d.update(beta="0.035"),
    "a β with a point too many": lambda d: d.update(beta="0.23149"),
    "β a little smaller: another volume": lambda d: d.update(beta="0.023148"),
    "β a last digit off": lambda d: d.update(beta="0.02314900000000001"),
    "the sign of β": lambda d: d.update(beta="-0.023149"),
    "the sign of a coefficient": lambda d: d["coefficients"].update({"1": "-0.234433"}),
    "the coefficient a last digit off": lambda d: d["coefficients"].update({"1": "0.23443300000001"}),
    "another order": lambda d: d.update(coefficients={"2": "0.234433"}),
    "the sign of the centroid": lambda d: d.update(
        com_enclosure=[["0.0026955", "0.0026956"], *d["com_enclosure"][1:]]
    ),
    "a centroid off the axis": lambda d: (
        d["com_enclosure"][1].reverse() or d["com_enclosure"].__setitem__(1, ["0.000001", "0.0000011"])
    ),
    "an enclosure that says nothing": lambda d: d["com_enclosure"].__setitem__(2, ["-1", "1"]),
    "an empty enclosure": lambda d: d["com_enclosure"][0].reverse(),
    "another volume": lambda d: d.update(volume_enclosure=["4.1", "4.1000001"]),
    "a higher curvature": lambda d: d["convexity"].update(curvature_above="0.0886"),
    "a negative curvature bound": lambda d: d["convexity"].update(curvature_above="-0.01"),
    "a curvature bound that is no number": lambda d: d["convexity"].update(curvature_above="nan"),
    "a wider margin than the true one": lambda d: d["margin"].update(com_margin="0.0034"),
    "a centre of mass outside": lambda d: d["margin"].update(com_margin="1.5"),
    "a negative margin": lambda d: d["margin"].update(com_margin="-0.001"),
    "the discs swapped": lambda d: d["equilibria"].update(
        stable_disc=d["equilibria"]["unstable_disc"], unstable_disc=d["equilibria"]["stable_disc"]
    ),
    "one disc for everything": lambda d: d["equilibria"]["stable_disc"].update(
        rectangle=" ".join(map(str, SPHERE)), cells=[" ".join(map(str, SPHERE))]
    ),
    "a disc that reaches the pole": lambda d: d["equilibria"]["stable_disc"].update(
        rectangle="0 528384 1044480 1052672", cells=["0 528384 1044480 1052672"]
    ),
    "one cell for the whole sphere": lambda d: d["convexity"].update(cells=[" ".join(map(str, SPHERE))]),
    "a cell inside out": lambda d: d["convexity"]["cells"].__setitem__(0, "1048576 0 1572864 -524288"),
    "no cells": lambda d: d["convexity"].update(cells=[]),
}


REASONS = {
    "a centre of mass outside": "not certainly inside",
    "a disc that reaches the pole": "reaches a pole",
    "one disc for everything": "reaches a pole",
    "an enclosure that says nothing": "too wide to say anything",
    "a negative margin": "a bound is negative",
    "no cells": "empty",
}


@pytest.mark.parametrize("what", CHANGES)
def test_a_changed_claim_is_rejected(primary_certificate: Certificate, what: str) -> None:
    outcome = verify_changed(primary_certificate, CHANGES[what])
    assert not outcome.accepted
    assert outcome.reason.startswith("Rejected: ")
    assert outcome.reason.endswith(".")
    assert REASONS.get(what, "") in outcome.reason


@pytest.mark.parametrize(
    "change",
    [
        {"gaussian_curvature_below": "-0.44"},
        {"gaussian_curvature_below": "0.43"},
        {"theta": 0},
        {"psi": 0},
        {"theta": -1},
        {"psi": 10**30},
    ],
)
def test_a_changed_witness_is_rejected(refuted_certificate: Certificate, change: dict[str, Any]) -> None:
    outcome = verify_changed(refuted_certificate, lambda document: document["witness"].update(change))
    assert not outcome.accepted
    outside = change.get("theta", 0) < 0 or change.get("psi", 0) > 2 * TURN_UNITS
    assert ("no direction" if outside else "no such negative curvature") in outcome.reason


@pytest.mark.parametrize("beta", ["0.0321", "0.022"])
def test_a_saddle_is_not_believed(refuted_certificate: Certificate, beta: str) -> None:
    """With k = 2 the centroid is at the origin, and the x-axis carries the two extremes."""

    def claim(document: Document) -> None:
        document.update(witness={"kind": "saddle", "theta": TURN_UNITS // 2, "psi": 0}, strictly_convex=None)

    assert not verify_changed(refuted_certificate, claim).accepted


def test_a_saddle_off_the_axis_shows_nothing(primary_certificate: Certificate) -> None:
    """The Hessian is indefinite in many places; only where the gradient vanishes is that a saddle."""

    def claim(document: Document) -> None:
        document.update(witness={"kind": "saddle", "theta": TURN_UNITS // 2, "psi": TURN_UNITS // 2})
        document.update(status="refuted", stable=None, unstable=None)

    with ctx.workprec(64):
        geometry = ball_geometry(primary_certificate.parameters)
        assert geometry.distance_hessian(Cell.at(TURN_UNITS // 2, TURN_UNITS // 2)).determinant < 0
    outcome = verify_changed(primary_certificate, claim)
    assert not outcome.accepted
    assert "not bound to be an equilibrium" in outcome.reason


def test_a_witness_against_a_convex_body_is_rejected(primary_certificate: Certificate) -> None:
    def slander(document: Document) -> None:
        document["witness"] = {
            "kind": "negative curvature",
            "theta": TURN_UNITS // 2,
            "psi": 0,
            "gaussian_curvature_below": "-0.1",
        }
        document.update(status="refuted", strictly_convex=False, stable=None, unstable=None)

    assert not verify_changed(primary_certificate, slander).accepted


def test_cells_of_another_subdivision_are_accepted(primary_certificate: Certificate) -> None:
    """The checker does not care how cells were found: halves of a cell prove the same."""

    def halve(document: Document) -> None:
        cells = document["convexity"]["cells"]
        a, b, c, d = (int(n) for n in cells.pop(0).split())
        third = a + (b - a) // 3
        cells += [f"{a} {third} {c} {d}", f"{third} {b} {c} {d}"]

    assert verify_changed(primary_certificate, halve).accepted


@settings(max_examples=80, deadline=None)
@given(data=st.data())
def test_any_changed_digit_shows_without_a_new_signature(
    primary_certificate: Certificate, data: st.DataObject
) -> None:
    text = dumps(primary_certificate)
    places = [i for i, letter in enumerate(text) if letter.isdigit()]
    place = data.draw(st.sampled_from(places))
    other = data.draw(st.sampled_from([d for d in "0123456789" if d != text[place]]))
    with pytest.raises(InspectionError, match="This is no valid certificate"):
        loads(text[:place] + other + text[place + 1 :])


def test_a_proof_does_not_depend_on_the_precision_that_was_set_before(
    primary_certificate: Certificate,
) -> None:
    with ctx.workprec(20):
        assert verify(primary_certificate).accepted
        assert certify(primary_certificate.parameters) == primary_certificate
