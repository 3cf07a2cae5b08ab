"""What thread rings, snap and press fits share: a land around the vertical that they are cut into."""

from __future__ import annotations

from gomboc_cad.errors import GeometryError
from gomboc_cad.products.closures.records import ClosureSite
from gomboc_cad.solid.hollow.tools import Cylinder

AXIS = (0.0, 0.0)


def land(
    site: ClosureSite, inner_radius_mm: float, below_mm: float, above_mm: float
) -> tuple[tuple[Cylinder, ...], tuple[Cylinder, ...]]:
    """Bosses and holes that leave material from a radius outwards to the wall, over a range of heights.

    A hollow body gets a flange on its wall, a solid one a bore.
    """
    if site.bore_radius_mm is None:
        # It starts outside: only what lies in the cavity counts.
        far = 1.5 * site.body.radius_mm
        return (site.upright(AXIS, below_mm, above_mm, far, inner_radius_mm),), ()
    return (), (site.upright(AXIS, below_mm, above_mm, inner_radius_mm),)


def outer_radius_mm(
    site: ClosureSite, what: str, wanted_mm: float | None, room_mm: float, wall_mm: float, margin_mm: float
) -> float:
    """Outer radius of a tongue.

    Args:
        site: Where the closure goes.
        what: What it is called.
        wanted_mm: Radius that was asked for; None for the best.
        room_mm: Largest radius that leaves the wall outside.
        wall_mm: Thickness of the tongue.
        margin_mm: What a bead and clearances need beyond the tongue.

    Returns:
        The wanted one; around the bore of a solid body, or as far out as the wall of a hollow one allows.

    Raises:
        GeometryError: If it is too large for the body or leaves no bore.
    """
    largest = room_mm - margin_mm
    bore = site.bore_radius_mm or 0.0
    if wanted_mm is None:
        radius = bore + wall_mm if site.bore_radius_mm is not None else largest
    else:
        radius = wanted_mm
    if radius > largest + 1e-9:
        raise GeometryError(
            f"The {what} of diameter {2.0 * radius:.4g} mm leaves less than a wall of "
            f"{site.shell.wall_mm:g} mm outside of it; at the seam there is room for {2.0 * largest:.4g} "
            "mm. Make it smaller or the body larger."
        )
    if radius - wall_mm < max(bore, 1e-6) - 1e-9:
        raise GeometryError(
            f"The {what} of diameter {2.0 * radius:.4g} mm with a wall of {wall_mm:g} mm leaves a bore of "
            f"{2.0 * max(0.0, radius - wall_mm):.4g} mm where {2.0 * bore:.4g} mm are needed; make it wider "
            "or thinner."
        )
    return radius
