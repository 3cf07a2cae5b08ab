"""Every shipped certificate is proven again, and is what a new run would give."""

from __future__ import annotations

from pathlib import Path

import pytest

from gomboc_cad.body.catalogue import (
    catalogue_entries,
    catalogue_names,
    exact_parameters,
    shipped_certificate,
)
from gomboc_cad.equilibria.certificate import loads, verify
from gomboc_cad.equilibria.certificate.__main__ import SHIPPED, renew


@pytest.mark.parametrize("name", catalogue_names())
def test_the_status_of_each_body_is_what_the_checker_finds(name: str) -> None:
    data = shipped_certificate(name)
    assert data is not None
    certificate = loads(data)
    assert certificate.parameters == exact_parameters(name)
    assert verify(certificate).accepted
    assert certificate.status == catalogue_entries()[name].status


@pytest.mark.slow
def test_renewing_changes_no_byte(tmp_path: Path) -> None:
    renew(tmp_path)
    fresh = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert fresh == {path.name: path.read_bytes() for path in SHIPPED.glob("*.json")}
