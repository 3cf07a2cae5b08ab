"""Data in TOML files: by the name of one that comes with the package, or from a user's own file."""

from __future__ import annotations

import difflib
from pathlib import Path

from gomboc_cad.errors import SpecError
from gomboc_cad.products.toml_model import Model, parse_model, read_toml
from gomboc_cad.resources import template_folder


def data_names(folder: str) -> tuple[str, ...]:
    """Names of the files of a folder under `templates/`."""
    return tuple(sorted(file.stem for file in (template_folder() / folder).glob("*.toml")))


def load_data(model: type[Model], folder: str, name: str, beside: Path | None = None) -> Model:
    """Read a file by the name of a template or by the path of a user's own file.

    Args:
        model: What it has to be; its name in sentences is that of the class.
        folder: Folder under `templates/`.
        name: Name of a template there, or a path that ends in `.toml`.
        beside: Folder that a relative path starts from, usually that of the spec.

    Raises:
        SpecError: If there is no such file or it is wrong.
    """
    if name.endswith(".toml"):
        path = (beside or Path()) / name
    else:
        known = data_names(folder)
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            meant = f"did you mean {near[0]}? Known: " if near else "choose one of "
            what = model.__name__.lower()
            raise SpecError(f"There is no {what} {name!r}; {meant}{', '.join(known)}, or give a .toml file.")
        path = template_folder() / folder / f"{name}.toml"
    return parse_model(model, read_toml(path), path.name)
