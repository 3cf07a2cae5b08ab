"""Certificates that many tests look at."""

from __future__ import annotations

import pytest

from gomboc_cad.body.catalogue import exact_parameters
from gomboc_cad.equilibria.certificate import Certificate, certify


@pytest.fixture(scope="session")
def primary_certificate() -> Certificate:
    """The primary, made anew."""
    return certify(exact_parameters("primary"))


@pytest.fixture(scope="session")
def refuted_certificate() -> Certificate:
    """The second instance of the paper, made anew."""
    return certify(exact_parameters("second"))
