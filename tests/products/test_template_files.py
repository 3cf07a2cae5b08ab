"""Templates can be listed and copied from an installation, where their folder is out of sight."""

from __future__ import annotations

from pathlib import Path

import pytest

from gomboc_cad.errors import SpecError
from gomboc_cad.products.materials import load_material
from gomboc_cad.products.process import load_process
from gomboc_cad.products.spec import PRODUCTS, load_spec
from gomboc_cad.products.template_files import copy_template, template_names


def test_what_is_listed_can_be_named_in_a_spec() -> None:
    names = template_names()
    assert names["products"] == tuple(PRODUCTS)
    for material in names["materials"]:
        load_material(material)
    for process in names["processes"]:
        load_process(process)
    assert "adafruit-bno055" in names["boards"]


@pytest.mark.parametrize("product", PRODUCTS)
def test_a_copy_is_the_same_spec(product: str, tmp_path: Path) -> None:
    copy_template(product, tmp_path / "mine.toml")
    assert load_spec(str(tmp_path / "mine.toml")) == load_spec(product)


def test_data_files_are_copied_by_their_names(tmp_path: Path) -> None:
    copy_template("cnc-5axis", tmp_path / "mine.toml")
    assert load_process("mine.toml", tmp_path) == load_process("cnc-5axis")


def test_an_unknown_template_is_told_with_those_near_it(tmp_path: Path) -> None:
    with pytest.raises(SpecError, match=r"did you mean .*cnc-5axis"):
        copy_template("cnc-5", tmp_path / "mine.toml")
    assert not list(tmp_path.iterdir())
