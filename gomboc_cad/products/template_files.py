"""The templates that come with the package: their names, and copies to edit."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

from gomboc_cad.errors import SpecError
from gomboc_cad.products.common_spec import TrimSpec
from gomboc_cad.products.data_files import data_names
from gomboc_cad.products.materials import load_material, material_names
from gomboc_cad.products.spec import PRODUCTS, load_spec
from gomboc_cad.resources import template_folder
from gomboc_cad.solid.output import write_bytes

_FOLDERS = ("boards", "batteries", "seeds", "processes")


def template_names() -> Mapping[str, tuple[str, ...]]:
    """What a spec may name: products, boards, batteries, seeds, processes, materials."""
    folders = {folder: data_names(folder) for folder in _FOLDERS}
    return {"products": tuple(PRODUCTS), **folders, "materials": material_names()}


def template_values() -> Mapping[str, Any]:
    """What a program that offers choices needs beside the names: specs, densities, kinds of trim."""
    return {
        "specs": {name: load_spec(name).model_dump(mode="json", exclude_none=True) for name in PRODUCTS},
        "density_g_cm3": {name: load_material(name).density_g_cm3 for name in material_names()},
        "trims": get_args(TrimSpec.model_fields["kind"].annotation),
    }


def copy_template(name: str, path: Path) -> None:
    """Write a copy of a template.

    Args:
        name: A product, or the name of a data file: `adafruit-bno055`, `cnc-5axis`.
        path: The file to write.

    Raises:
        SpecError: If there is no template of that name.
        OutputError: If the file cannot be written.
    """
    files = {product: template_folder() / f"{product}.toml" for product in PRODUCTS}
    files |= {
        known: template_folder() / folder / f"{known}.toml"
        for folder in _FOLDERS
        for known in data_names(folder)
    }
    if name not in files:
        near = difflib.get_close_matches(name, files, n=3, cutoff=0.4) or list(PRODUCTS)
        raise SpecError(
            f"There is no template {name!r}; did you mean {', '.join(near)}? "
            "`gomboc-cad templates` lists all."
        )
    write_bytes(path, files[name].read_bytes())
