"""Reading a product spec by the name of a template or from a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gomboc_cad.errors import SpecError
from gomboc_cad.products.buoy.spec import BuoySpec
from gomboc_cad.products.common_spec import ProductSpec
from gomboc_cad.products.imu_housing.spec import ImuHousingSpec
from gomboc_cad.products.seed_pod.spec import SeedPodSpec
from gomboc_cad.products.spec_changes import changed
from gomboc_cad.products.toml_model import parse_model, read_toml
from gomboc_cad.resources import template_folder

PRODUCTS: Mapping[str, type[ProductSpec]] = {
    "imu-housing": ImuHousingSpec,
    "seed-pod": SeedPodSpec,
    "buoy": BuoySpec,
}


def spec_path(name: str) -> Path:
    """Give the file of a product's template, or the path that was given."""
    return template_folder() / f"{name}.toml" if name in PRODUCTS else Path(name)


def load_spec(name: str, changes: Sequence[str] = ()) -> ProductSpec:
    """Read and check a spec.

    Args:
        name: Name of a product, which stands for its template, or the path of a TOML file.
        changes: `KEY=VALUE` each, see `spec_changes.changed`.

    Raises:
        SpecError: If the file is missing or malformed, of an unknown product, or a value is impossible.
    """
    path = spec_path(name)
    if not path.exists() and path.suffix != ".toml" and path.name == name:
        raise SpecError(
            f"There is no product {name!r}; choose one of {', '.join(PRODUCTS)}, or give a .toml file."
        )
    data = changed(read_toml(path), changes)
    product = data.get("product")
    if not isinstance(product, str) or product not in PRODUCTS:
        raise SpecError(
            f'{path.name}: product = {product!r} is not a product; write product = "{next(iter(PRODUCTS))}" '
            f"(known: {', '.join(PRODUCTS)})."
        )
    _refuse_tables_of_another_product(path.name, product, data)
    return parse_model(PRODUCTS[product], data, path.name)


def _refuse_tables_of_another_product(file: str, product: str, data: Mapping[str, Any]) -> None:
    """Tell a spec whose `product` was changed from one with a slip of the pen."""
    for name in data:
        owners = [other for other, model in PRODUCTS.items() if name in model.model_fields]
        if owners and product not in owners:
            raise SpecError(
                f'{file}: product = "{product}" has no table [{name}], which belongs to '
                f'{" or ".join(owners)}; write product = "{owners[0]}", or start from the template of '
                f"{product}."
            )
