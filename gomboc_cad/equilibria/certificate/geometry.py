"""The ball geometry that belongs to a family."""

from __future__ import annotations

from typing import Any

from gomboc_cad.body.catalogue import ExactParameters
from gomboc_cad.equilibria.certificate.enclosures import BallGeometry
from gomboc_cad.equilibria.certificate.harmonic import HarmonicGeometry
from gomboc_cad.equilibria.certificate.records import Decimals
from gomboc_cad.equilibria.certificate.sloan import SloanGeometry
from gomboc_cad.errors import BodyError

CERTIFIED_FAMILIES = ("harmonic", "sloan2", "extended")


def ball_geometry(
    parameters: ExactParameters, com: Decimals | None = None, chart: tuple[str, ...] = ()
) -> BallGeometry[Any]:
    """The geometry of a body by its exact parameters, about its centroid or another centre of mass.

    Args:
        parameters: Family and exact decimals.
        com: Decimals of the centre of mass; the centroid if not given.
        chart: Decimals of the chart's polynomial, for a `harmonic` body only; the others have their own.

    Raises:
        BodyError: If the parameters are not those of a body that can be certified.
    """
    if parameters.family == "harmonic":
        return HarmonicGeometry.of(parameters, com, chart)
    if parameters.family not in CERTIFIED_FAMILIES:
        *others, last = CERTIFIED_FAMILIES
        raise BodyError(
            f"Certificates are made for the families {', '.join(others)} and {last}, not for "
            f"{parameters.family!r}; the census judges the others."
        )
    if chart:
        raise BodyError(f"The family {parameters.family!r} has a chart of its own.")
    return SloanGeometry.of(parameters, com)
