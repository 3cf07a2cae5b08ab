"""Bodies and censuses that many tests look at."""

from __future__ import annotations

import pytest

from gomboc_cad.body import Body, catalog
from gomboc_cad.equilibria import Census, smooth_census


@pytest.fixture(scope="session")
def primary() -> Body:
    """The catalogue's primary with R₀ = 1."""
    return catalog()["primary"].with_diameter(2.0)


@pytest.fixture(scope="session")
def primary_census(primary: Body) -> Census:
    """Its census about its own centroid."""
    return smooth_census(primary)
