"""What a build stores for its report."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gomboc_cad.body import Body, catalog
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.equilibria import Census, mesh_census
from gomboc_cad.products.imu_housing.spec import ImuHousingSpec
from gomboc_cad.products.loads import UncertainLoad
from gomboc_cad.products.spec import load_spec
from gomboc_cad.report.build_records import com_covariance_mm2, product_records


def design(body: Body, spec: object = None) -> Any:
    """A product of 100 g with a board of 10 g, 20 mm off, that is known to 0.5 g and to 1 mm."""
    board = SimpleNamespace(name="board", mass_g=10.0, com_mm=(20.0, 0.0, 0.0))
    assembly = SimpleNamespace(mass_g=100.0, com_mm=(0.0, 0.0, 0.0), parts=[board])
    return SimpleNamespace(body=body, spec=spec, assembly=assembly, loads=(UncertainLoad("board", 0.5, 1.0),))


def test_tolerances_spread_the_centre_of_mass() -> None:
    """0.1 mm along x by the mass, 0.1 mm along each axis by the place; uniform within these half-widths."""
    expected = np.diag([0.02, 0.01, 0.01]) / 3.0
    np.testing.assert_allclose(com_covariance_mm2(design(catalog()["primary"])), expected)


def test_a_housing_says_what_else_moves_it() -> None:
    spec = load_spec("imu-housing")
    assert isinstance(spec, ImuHousingSpec)
    assert spec.tolerances.com_error_um == 10.0
    more = com_covariance_mm2(design(catalog()["primary"], spec))
    less = com_covariance_mm2(design(catalog()["primary"]))
    np.testing.assert_allclose(more - less, 0.01**2 / 3.0 * np.eye(3), atol=1e-15)


@pytest.fixture(scope="module")
def dented() -> Census:
    directions, faces = geodesic_triangulation(3)
    return mesh_census(catalog()["second"].position_mm(directions), faces)


def test_a_dented_body_has_what_its_hull_tells(dented: Census) -> None:
    found = product_records(design(catalog()["second"]), SimpleNamespace(census=dented, s_margin_mm=None))  # type: ignore[arg-type]
    assert set(found) == {"surface", "landscape", "tilt"}
    assert found["surface"]["drill_radius_mm"] is None
    assert found["tilt"]["s_margin_um"] is None


def test_without_a_census_there_is_nothing() -> None:
    assert product_records(design(catalog()["second"]), SimpleNamespace(census=None)) == {}  # type: ignore[arg-type]
