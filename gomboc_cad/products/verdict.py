"""The verdict on an assembly: does it right itself, by what margin, and what does an error do to it?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from gomboc_cad.body import Body
from gomboc_cad.equilibria import Census, smooth_census
from gomboc_cad.equilibria.records import Rest, Vector
from gomboc_cad.errors import CensusError, NotConvexError

if TYPE_CHECKING:
    from gomboc_cad.products.recheck import Recheck


@dataclass(frozen=True)
class Verdict:
    """PASS or FAIL, with every reason in words.

    Attributes:
        verdict: PASS when the outer surface, and the hull of the parts as made, have exactly one stable
            rest about the assembled centre of mass and nothing else is wrong.
        reasons: Sentences, the deciding ones first.
        census: The census behind it; None where there can be none.
        s_margin_mm: How far the centre of mass may be off before a second rest appears, on the surface or
            in an opening; None where that is not known.
    """

    verdict: Literal["PASS", "FAIL"]
    reasons: tuple[str, ...]
    census: Census | None
    s_margin_mm: float | None = None

    @property
    def passed(self) -> bool:
        """Whether the verdict is PASS."""
        return self.verdict == "PASS"


def judge(
    body: Body,
    com_mm: Vector,
    problems: tuple[str, ...] = (),
    again: Recheck | None = None,
) -> Verdict:
    """Take the census of the outer surface about a centre of mass and say what follows.

    Args:
        body: The outer surface.
        com_mm: Centre of mass of the assembly.
        problems: What else was found wrong, one sentence each; any makes the verdict FAIL.
        again: The census of the hull of the parts as exported; unless that has one rest, the verdict is FAIL
            too. The margin is then that of its openings as well.
    """
    try:
        census = smooth_census(body, com_mm)
    except (NotConvexError, CensusError) as error:
        return Verdict("FAIL", (*problems, str(error)), None)
    count = f"{census.stable} stable, {census.saddles} saddle and {census.unstable} unstable equilibria"
    if census.stable != 1:
        reason = (
            f"The centre of mass ({com_mm[0]:.3f}, {com_mm[1]:.3f}, {com_mm[2]:.3f}) mm is outside the "
            f"loading zone: the outer surface has {count} about it, so the part can come to rest in "
            f"{census.stable} ways; move the centre of mass nearer to the homogeneous centroid or to the "
            "rest point."
        )
        return Verdict("FAIL", (*problems, reason), census)
    if again is not None and again.verdict != "monostable":
        return Verdict("FAIL", (*problems, *again.reasons), census)
    assert census.margin is not None  # a smooth census has one
    of_surface = census.margin.s_margin_mm
    margin, where = of_surface, ""
    for rim in () if again is None else again.rims:
        if rim.com_clearance_mm is not None and rim.com_clearance_mm < margin:
            margin, where = rim.com_clearance_mm, f" on {rim.name}"
    said = (
        f"The outer surface has {count} about the centre of mass: the part rights itself to one pose.",
        *(() if again is None else again.reasons),
        f"The centre of mass may be off by less than {margin:.4g} mm in any direction before a second rest "
        f"can appear{where}, the same margin as that of a sphere whose centre of mass is lowered by "
        f"{margin:.4g} mm.",
        "Each micrometre of centre-of-mass error tilts the rest by up to "
        f"{census.rest.tilt_deg_per_um[0]:.3g}° along its soft axis and "
        f"{census.rest.tilt_deg_per_um[1]:.2g}° along its stiff one.",
        "This is the nominal geometry: waviness of n undulations per revolution uses the margin of the "
        f"surface up at an amplitude of about {1e3 * of_surface:.3g} µm / n², {1e3 * of_surface / 16:.2g} µm "
        "at n = 4; compare that with what your process holds.",
    )
    return Verdict("FAIL" if problems else "PASS", (*problems, *said), census, margin)


def tilt_from_com_error_deg(rest: Rest, error_mm: Vector) -> float:
    """Tilt of the rest for a centre-of-mass error given in the body's frame, to first order.

    `δu = (∇²h)⁻¹ v_T`: only the part of the error across the vertical counts.
    """
    across = np.array([np.dot(rest.soft_direction, error_mm), np.dot(rest.stiff_direction, error_mm)])
    return float(np.linalg.norm(across * 1e3 * np.array(rest.tilt_deg_per_um)))
