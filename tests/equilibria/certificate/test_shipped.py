"""Every shipped certificate is proven again, and is what a new run would give."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path

import pytest

from gomboc_cad.body.catalogue import (
    INDEX_NAME,
    catalogue_entries,
    catalogue_names,
    exact_parameters,
    shipped_certificate,
)
from gomboc_cad.equilibria.certificate import certify, dumps, loads, prover, verify
from gomboc_cad.equilibria.certificate.__main__ import SHIPPED, renew
from gomboc_cad.equilibria.certificate.prover import Proof

HARMONIC = [name for name in catalogue_names() if exact_parameters(name).family == "harmonic"]
BOUNDS_SOUGHT = "stiff-k05"


@pytest.mark.parametrize("name", catalogue_names())
def test_the_status_of_each_body_is_what_the_checker_finds(name: str) -> None:
    data = shipped_certificate(name)
    assert data is not None
    certificate = loads(data)
    assert certificate.parameters == exact_parameters(name)
    assert verify(certificate).accepted
    assert certificate.status == catalogue_entries()[name].status


def test_renewing_changes_no_byte(tmp_path: Path) -> None:
    """Of the bodies of few terms; the others follow below."""
    names = [name for name in catalogue_names() if name not in HARMONIC]
    renew(tmp_path, names)
    index = json.loads((tmp_path / INDEX_NAME).read_text(encoding="utf-8"))
    shipped = json.loads((SHIPPED / INDEX_NAME).read_text(encoding="utf-8"))
    assert list(shipped) == list(catalogue_names())
    assert index == {name: shipped[name] for name in names}
    for name in names:
        assert (tmp_path / f"{name}.json").read_bytes() == (SHIPPED / f"{name}.json").read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("name", HARMONIC)
def test_proving_a_harmonic_body_anew_changes_no_byte(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """At the bounds that were found, which is a quarter of the work.

    That the next larger ones cannot be proven is tried on one of these bodies, and on all of few terms above.
    """
    data = (SHIPPED / f"{name}.json").read_bytes()
    known = loads(data)
    assert known.convexity is not None
    assert known.margin is not None
    found = iter((known.convexity.curvature_above, known.margin.com_margin))
    search, bounds = prover._best, prover._BOUNDS

    def search_nearby(prove: Callable[[str, int], Proof | None], few: int) -> Proof | None:
        first = bounds.index(next(found))
        last = first + (1 if name == BOUNDS_SOUGHT else 0)
        monkeypatch.setattr(prover, "_BOUNDS", bounds[first : last + 1])
        return search(prove, few)

    monkeypatch.setattr(prover, "_best", search_nearby)
    fresh = certify(exact_parameters(name))
    assert dumps(fresh).encode() == data
    entry = json.loads((SHIPPED / INDEX_NAME).read_text(encoding="utf-8"))[name]
    parameters = fresh.parameters
    assert entry == {
        "status": fresh.status,
        "parameters": {
            "family": parameters.family,
            "beta": parameters.beta,
            "coefficients": dict(parameters.coefficients),
        },
        "sha256": hashlib.sha256(data).hexdigest(),
    }
