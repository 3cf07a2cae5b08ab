"""A TOML file with a body and nothing else: `gomboc-cad design` writes it, other commands read it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from gomboc_cad.body import Body
from gomboc_cad.errors import SpecError
from gomboc_cad.products.body_spec import BodySpec
from gomboc_cad.products.toml_model import TomlModel, parse_model, read_toml


class BodyFile(TomlModel):
    """The file: one table `[body]`, as in a product's spec."""

    body: BodySpec


def is_body_file(name: str) -> bool:
    """Whether a name is that of a TOML file which has a body and no product.

    Raises:
        SpecError: If it is a TOML file that cannot be read.
    """
    path = Path(name)
    if path.suffix.lower() != ".toml" or not path.is_file():
        return False
    data = read_toml(path)
    return "body" in data and "product" not in data


def load_body(path: Path, diameter_mm: float | None = None) -> Body:
    """Read a body, with the diameter of the file or another one; it is named after its file.

    Raises:
        SpecError: If the file is missing or malformed, or the spec of a product.
        BodyError: If its parameters do not describe a body.
    """
    data = read_toml(path)
    if "product" in data:
        raise SpecError(
            f"{path.name} is the spec of a product, and a body is needed: give a name of the catalogue, or a "
            "file with the table [body] and nothing else."
        )
    spec = parse_model(BodyFile, data, path.name).body
    body = spec.body() if spec.name is not None else replace(spec.body(), name=path.name)
    return body if diameter_mm is None else body.with_diameter(diameter_mm)
