"""Columns along the wall that trim masses go into, from the open seam downwards and upwards."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.closures.records import ClosureSite
from gomboc_cad.products.common_spec import TrimSpec
from gomboc_cad.products.envelope import Envelope
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.products.placing.trim import TrimSite
from gomboc_cad.solid.hollow import Cylinder

_COLUMNS = 4
_DEPTH_SHARE = 0.2
"""Depth of a hole on each side of the seam, in units of the diameter of the body."""

_START_ANGLES = 90


@dataclass(frozen=True)
class TrimColumns:
    """Columns with a site for trim on each side of the seam.

    Attributes:
        bosses: The columns.
        sites: Where trim may go, in the unmoved core.
    """

    bosses: tuple[Cylinder, ...] = ()
    sites: tuple[TrimSite, ...] = ()


def place_trim_columns(
    spec: TrimSpec,
    site: ClosureSite,
    wall_mm: float,
    rooms: Sequence[Envelope],
    columns: Sequence[Cylinder],
) -> TrimColumns:
    """Place four columns on a circle about the vertical, turned to where they have most room.

    Args:
        spec: What trim is wanted, and up to which size.
        site: Body, frame and seam.
        wall_mm: Material around a hole and between it and the outer surface.
        rooms: What the columns must stay clear of.
        columns: Other upright columns that they must stay clear of.

    Raises:
        GeometryError: If there is no room for them.
    """
    radius = 0.5 * spec.max_diameter_mm + wall_mm
    reach = _DEPTH_SHARE * site.body.diameter_mm
    from_axis = site.widest_ring_mm(reach, reach, radius)

    def places(start: float) -> list[tuple[float, float]]:
        angles = [start + 2.0 * math.pi * index / _COLUMNS for index in range(_COLUMNS)]
        return [(from_axis * math.cos(angle), from_axis * math.sin(angle)) for angle in angles]

    def room(start: float) -> float:
        made = [site.column(place, radius) for place in places(start)]
        gaps = [envelope.gap_to_column_mm(site.frame, boss) for envelope in rooms for boss in made]
        gaps += [_gap_mm(site.frame, boss, other) for boss in made for other in columns]
        return min(gaps, default=math.inf)

    starts = 2.0 * math.pi / _COLUMNS * np.arange(_START_ANGLES) / _START_ANGLES
    best = max(starts.tolist(), key=room)
    if room(best) < 0.0:
        raise GeometryError(
            f"There is no room for four columns of {2.0 * radius:.3g} mm for trim masses beside the contents "
            "and the closure; make trim.max_diameter_mm smaller, or take a larger diameter."
        )
    sites = [
        TrimSite(
            f"trim {side} {number}",
            site.point(*place, 0.0),
            as_vector(sign * np.array(site.frame.up)),
            reach,
            spec.max_diameter_mm,
        )
        for number, place in enumerate(places(best), start=1)
        for side, sign in (("lower", -1.0), ("upper", 1.0))
    ]
    return TrimColumns(tuple(site.column(place, radius) for place in places(best)), tuple(sites))


def _gap_mm(frame: RestFrame, one: Cylinder, other: Cylinder) -> float:
    """Free space between two upright columns."""
    across = frame.matrix()[:2] @ np.subtract(one.base_mm, other.base_mm)
    return float(np.linalg.norm(across)) - one.radius_mm - other.radius_mm
