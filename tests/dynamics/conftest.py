"""Bodies that roll, and the simulator that they are compared with."""

from __future__ import annotations

from types import ModuleType

import pytest

from gomboc_cad.body import Body, FourierSloan, catalog
from gomboc_cad.dynamics import RollingBody
from gomboc_cad.equilibria.round_solids import EllipsoidShape
from tests.external import require_module


@pytest.fixture(scope="session")
def mujoco() -> ModuleType:
    """The module mujoco."""
    return require_module("mujoco", "test")


@pytest.fixture(scope="session")
def ball() -> Body:
    """A sphere of radius 50 mm."""
    return Body("ball", FourierSloan(0.0))


@pytest.fixture(scope="session")
def loaded_ball(ball: Body) -> RollingBody:
    """The sphere with three tenths of its mass in a point 40 mm below its centre: COM lowered by 12 mm."""
    return RollingBody.ballasted(ball, 0.3, (0.0, 0.0, -40.0))


@pytest.fixture(scope="session")
def loaded_ellipsoid() -> RollingBody:
    """An ellipsoid of semi-axes 65, 50 and 40 mm with its COM lowered by 9 mm along the shortest."""
    return RollingBody.ballasted(Body("ellipsoid", EllipsoidShape((1.3, 1.0, 0.8))), 0.3, (0.0, 0.0, -30.0))


@pytest.fixture(scope="session")
def rolling_primary() -> RollingBody:
    """The homogeneous primary with R₀ = 50 mm."""
    return RollingBody.homogeneous(catalog()["primary"])
