"""The library that the hydrostatics are compared with."""

from __future__ import annotations

from types import ModuleType

import pytest

from tests.external import require_module


@pytest.fixture(scope="session")
def capytaine() -> ModuleType:
    """The module capytaine."""
    return require_module("capytaine", "test")
