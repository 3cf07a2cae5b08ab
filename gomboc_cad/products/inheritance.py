"""Whether what is exported has the census, or the proof, of the analytic body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from build123d import Shape

from gomboc_cad.body import Body, mass_properties
from gomboc_cad.body.catalogue import catalogue_entries, shipped_certificate
from gomboc_cad.equilibria import Census
from gomboc_cad.equilibria.certificate import loads
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.transfer import Transfer, transfer

_ROUNDING = 1e-9


def proven_margin_mm(body: Body, com_mm: Vector) -> float | None:
    """Distance from a centre of mass within which the shipped certificate proves one stable rest.

    None if the body has no such certificate, or the centre of mass lies outside the ball that it proves.
    """
    entry = catalogue_entries().get(body.name)
    if entry is None or entry.status != "proven" or entry.body.shape != body.shape:
        return None
    certificate = loads(shipped_certificate(body.name) or b"")
    if certificate.margin is None:
        return None
    proven = float(certificate.margin.com_margin) * body.radius_mm
    off_center = float(np.linalg.norm(np.subtract(com_mm, mass_properties(body).com_mm)))
    left = proven - off_center - _ROUNDING * body.radius_mm
    return left if left > 0.0 else None


def inherited(solids: Sequence[Shape], body: Body, census: Census, exported_com_mm: Vector) -> Transfer | str:
    """Compare solids as read back with the analytic body: with the proven margin, else with the computed one.

    Args:
        solids: All parts that carry the outer surface.
        body: The analytic body.
        census: Its census about the centre of mass of the model.
        exported_com_mm: Centre of mass of what was exported.

    Returns:
        What was found, or a sentence that says why the solids cannot be compared.
    """
    proven = proven_margin_mm(body, census.com_mm)
    found: Transfer | None = None
    try:
        if proven is not None:
            found = transfer(solids, body, census.com_mm, exported_com_mm, proven, "proven")
        if census.margin is not None and (found is None or not found.holds):
            found = transfer(solids, body, census.com_mm, exported_com_mm, census.margin.margin_mm)
    except GeometryError as error:
        return str(error)
    return found if found is not None else "The census has no margin to compare the exported solid with."


def inheritance_document(found: Transfer | str | None) -> dict[str, Any] | None:
    """The key `transfer` of body and build; null where nothing was compared."""
    return asdict(found) if isinstance(found, Transfer) else None


def inheritance_reasons(found: Transfer | str | None) -> list[str]:
    """What to say about it."""
    if found is None:
        return []
    return [found.reason if isinstance(found, Transfer) else found]
