"""The default housing, designed once for all tests that look at it."""

from __future__ import annotations

from pathlib import Path

import pytest

from gomboc_cad.products.imu_housing.recipe import HousingDesign, design_imu_housing
from gomboc_cad.products.spec import load_spec
from gomboc_cad.resources import template_folder


@pytest.fixture(scope="session")
def default_housing() -> HousingDesign:
    """The housing that the template describes."""
    return design_imu_housing(load_spec("imu-housing"))


@pytest.fixture
def template_with(tmp_path: Path):
    """`template_with((old, new), ...)` writes the housing's template with changes and gives its path.

    Without the mark and with coarse meshes, which cost most of the time and are tested on their own.
    """

    def write(*changes: tuple[str, str]) -> Path:
        text = (template_folder() / "imu-housing.toml").read_text(encoding="utf-8")
        for old, new in (('text = "A1" ', 'text = "" '), ("sag_um = 10.0 ", "sag_um = 400.0 "), *changes):
            assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in the template"
            text = text.replace(old, new)
        path = tmp_path / "mine.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write
