"""Whether what is exported has the census, or the proof, of the analytic body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from functools import lru_cache
from typing import Any

import numpy as np
from build123d import Shape

from gomboc_cad.body import Body, mass_properties
from gomboc_cad.body.catalogue import catalogue_entries, exact_parameters, shipped_certificate
from gomboc_cad.equilibria import Census
from gomboc_cad.equilibria.certificate import certify, loads, verify
from gomboc_cad.equilibria.certificate.records import Decimals
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.transfer import Transfer, transfer

_ROUNDING = 1e-9
_DECIMALS = 7
_NEAR = 0.5
"""A shipped proof is used where it leaves at least half of its margin."""


def proven_margin_mm(body: Body, com_mm: Vector) -> float | None:
    """Distance from a centre of mass within which a certificate proves one stable rest.

    That is the shipped one where the centre of mass lies well inside the ball that it proves, else one that
    is made and checked for this very centre of mass. None if the body is not proven.
    """
    entry = catalogue_entries().get(body.name)
    if entry is None or entry.status != "proven" or entry.body.shape != body.shape:
        return None
    shipped = loads(shipped_certificate(body.name) or b"")
    if shipped.margin is not None:
        about_centroid = float(shipped.margin.com_margin) * body.radius_mm
        off_center = float(np.linalg.norm(np.subtract(com_mm, mass_properties(body).com_mm)))
        if off_center < _NEAR * about_centroid:
            return about_centroid - off_center - _ROUNDING * body.radius_mm
    x, y, z = (f"{coordinate / body.radius_mm:.{_DECIMALS}f}" for coordinate in com_mm)
    proven = _proven_about(body.name, (x, y, z))
    return None if proven is None else (proven - _ROUNDING - 10.0**-_DECIMALS) * body.radius_mm


@lru_cache(maxsize=16)
def _proven_about(name: str, com: Decimals) -> float | None:
    """Radius in R₀ of a ball about a centre of mass in which the counts are proven; None if they are not."""
    made = certify(exact_parameters(name), com=com)
    return float(made.margin.com_margin) if made.margin is not None and verify(made).accepted else None


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
