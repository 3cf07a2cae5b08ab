"""What an analysis is asked about: a bare body, or a product's outer body and its centre of mass."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gomboc_cad.body import Body, mass_properties
from gomboc_cad.body.catalogue import named_body
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.errors import SpecError
from gomboc_cad.products.body_file import is_body_file, load_body
from gomboc_cad.products.spec import PRODUCTS
from gomboc_cad.progress import Progress, silent

NO_SPEC_TO_CHANGE = "--set changes the spec of a product, and a bare body has none."
DESIGN_STAGES = 4
"""How many stages the design of a product reports."""


def is_spec(name: str) -> bool:
    """Whether a name stands for a spec (a product or a TOML file of one) and not for a body."""
    return name in PRODUCTS or (name.lower().endswith(".toml") and not is_body_file(name))


def bare_body(name: str) -> Body:
    """The body that a name of the catalogue or a TOML file with a body and no product stands for.

    Raises:
        BodyError: If there is no body of that name.
        SpecError: If the file is wrong.
    """
    return load_body(Path(name)) if is_body_file(name) else named_body(name)


def body_and_com(
    subject: str | Body, progress: Progress = silent, *, changes: Sequence[str] = ()
) -> tuple[Body, Vector]:
    """Give the outer body and the centre of mass in mm that an analysis starts from.

    Args:
        subject: A body, or the name or file of one, which stand for the homogeneous solid; or a product or
            the path of a spec, whose parts are designed and weighed.
        progress: Called with the name of each stage of the design as it begins.
        changes: `KEY=VALUE` each, for keys of the spec; a bare body has none.

    Raises:
        BodyError: If there is no body of that name.
        SpecError: If the spec or the file is wrong.
        GeometryError: If the product cannot be made.
    """
    if isinstance(subject, str) and is_spec(subject):
        # The kernel is loaded only for what needs it.
        from gomboc_cad.products.recipes import design_product
        from gomboc_cad.products.spec import load_spec, spec_path

        design = design_product(load_spec(subject, changes), spec_path(subject).parent, progress)
        return design.body, design.assembly.com_mm
    if changes:
        raise SpecError(NO_SPEC_TO_CHANGE)
    body = bare_body(subject) if isinstance(subject, str) else subject
    return body, mass_properties(body).com_mm
