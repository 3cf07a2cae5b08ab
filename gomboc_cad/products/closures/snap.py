"""An annular snap: a tongue with a bead on the upper part that clicks into a groove of the lower one.

The bead is the belt of a flat spheroid around the tongue, so it leads in and out with a gentle slope. While
it passes the mouth of the groove, tongue or rim give way by the radial interference y. The strain around the
circumference is `y / r`, so the diameters may interfere by `ε d` (Bayer, "Snap-Fit Joints for Plastics: A
Design Guide", on annular snap joints). All of it is reckoned to one of the two, as if the other were rigid.
"""

from __future__ import annotations

import math

from gomboc_cad.errors import GeometryError
from gomboc_cad.products.closures.annular import AXIS, land, outer_radius_mm
from gomboc_cad.products.closures.elasticity import load_elasticity
from gomboc_cad.products.closures.records import ClosureLayout, ClosureSite
from gomboc_cad.products.closures.spec import SnapSpec
from gomboc_cad.solid.hollow.tools import Ellipsoid, Tool


def lay_out_snap(spec: SnapSpec, site: ClosureSite) -> ClosureLayout:
    """Find the diameter and the undercut of a snap.

    Raises:
        SpecError: If nothing is known about the elasticity of the shell's material.
        GeometryError: If it does not fit, strains the material too much, or does not hold.
    """
    limit = _strain_limit(spec, site)
    if spec.bead_mm >= spec.height_mm:
        raise GeometryError(
            f"closure.bead_mm = {spec.bead_mm:g} must be less than closure.height_mm = {spec.height_mm:g}."
        )
    root = 2.0 * spec.tongue_wall_mm
    room = site.widest_ring_mm(spec.height_mm, root, site.shell.wall_mm)
    radius, undercut = _radius_and_undercut_mm(spec, site, room, limit)
    _check_strain(spec, site, radius, undercut, limit)

    middle = spec.height_mm - 0.5 * spec.bead_mm
    belt = radius + undercut
    half_axis = 0.5 * spec.bead_mm / math.sqrt(1.0 - (radius / belt) ** 2)
    inner = radius - spec.tongue_wall_mm
    below = spec.height_mm if site.bore_radius_mm is None else middle + half_axis + 2.0 * spec.clearance_mm
    bosses, holes = land(site, inner, below, root)

    def tongue(clearance: float) -> tuple[Tool, ...]:
        wide, high = belt + clearance, half_axis + clearance
        frame = (site.frame.first, site.frame.second, site.frame.up)
        bead = Ellipsoid(site.point(*AXIS, -middle), frame, (wide, wide, high))
        return site.upright(AXIS, middle, 0.5 * root, radius + clearance), bead

    strain = (undercut - spec.clearance_mm) / radius
    slope = math.degrees(math.atan(0.5 * spec.bead_mm * (belt / half_axis) ** 2 / radius))
    return ClosureLayout(
        site=site,
        seam=site.seam(tongue(0.0), tongue(spec.clearance_mm)),
        bosses=bosses,
        holes=holes,
        notes=(
            f"The snap of diameter {2.0 * radius:.4g} mm has an undercut of {undercut:.3g} mm; closing it "
            f"strains the {site.shell.material} by {100.0 * strain:.2g} % where {100.0 * limit:.2g} % are "
            f"permissible once, over a slope of {slope:.0f}°.",
        ),
    )


def _strain_limit(spec: SnapSpec, site: ClosureSite) -> float:
    if spec.strain_limit_percent is not None:
        return 0.01 * spec.strain_limit_percent
    return load_elasticity(site.shell.material).strain_limit


def _radius_and_undercut_mm(
    spec: SnapSpec, site: ClosureSite, room: float, limit: float
) -> tuple[float, float]:
    """Outer radius of the tongue and height of the bead over it."""
    clearance, thickest = spec.clearance_mm, 0.5 * spec.tongue_wall_mm
    if spec.undercut_mm != "auto":
        strained = spec.undercut_mm - clearance
    else:
        strained = min(thickest, limit * (room - 2.0 * clearance) / (1.0 + limit))
    wanted = None if spec.diameter_mm == "auto" else 0.5 * spec.diameter_mm
    margin = strained + 2.0 * clearance
    radius = outer_radius_mm(site, "snap", wanted, room, spec.tongue_wall_mm, margin)
    if spec.undercut_mm == "auto":
        strained = min(strained, limit * radius)
    return radius, strained + clearance


def _check_strain(spec: SnapSpec, site: ClosureSite, radius: float, undercut: float, limit: float) -> None:
    strained = undercut - spec.clearance_mm
    if strained <= 0.0:
        raise GeometryError(
            f"closure.undercut_mm = {undercut:g} is not more than closure.clearance_mm = "
            f"{spec.clearance_mm:g}, so the snap would not hold; make it larger or the clearance smaller."
        )
    if strained > limit * radius * (1.0 + 1e-9):
        allowed = spec.clearance_mm + limit * radius
        raise GeometryError(
            f"closure.undercut_mm = {undercut:g} strains the {site.shell.material} by "
            f"{100.0 * strained / radius:.3g} % while the snap closes, and {100.0 * limit:.3g} % is "
            f"permissible; take at most {allowed:.3g} mm, a larger diameter or a tougher material."
        )
