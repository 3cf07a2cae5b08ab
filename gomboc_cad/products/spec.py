"""Reading a product spec by the name of a template or from a file."""

from __future__ import annotations

from pathlib import Path

from gomboc_cad.errors import SpecError
from gomboc_cad.products.imu_housing_spec import ImuHousingSpec
from gomboc_cad.products.toml_model import parse_model, read_toml
from gomboc_cad.resources import template_folder

PRODUCTS = {"imu-housing": ImuHousingSpec}


def spec_path(name: str) -> Path:
    """Give the file of a product's template, or the path that was given."""
    return template_folder() / f"{name}.toml" if name in PRODUCTS else Path(name)


def load_spec(name: str) -> ImuHousingSpec:
    """Read and check a spec.

    Args:
        name: Name of a product, which stands for its template, or the path of a TOML file.

    Raises:
        SpecError: If the file is missing or malformed, of an unknown product, or a value is impossible.
    """
    path = spec_path(name)
    if not path.exists() and path.suffix != ".toml" and path.name == name:
        raise SpecError(
            f"There is no product {name!r}; choose one of {', '.join(PRODUCTS)}, or give a .toml file."
        )
    data = read_toml(path)
    product = data.get("product")
    if not isinstance(product, str) or product not in PRODUCTS:
        raise SpecError(
            f'{path.name}: product = {product!r} is not a product; write product = "{next(iter(PRODUCTS))}" '
            f"(known: {', '.join(PRODUCTS)})."
        )
    return parse_model(PRODUCTS[product], data, path.name)
