"""The figures that the paper gives for its applications: the IMU housing and the seed pod."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gomboc_cad.equilibria.margin import s_margin_mm
from gomboc_cad.equilibria.records import Rest
from gomboc_cad.paper.bodies import exact_census, reading, unit_body
from gomboc_cad.paper.published import published
from gomboc_cad.paper.records import Row, Table, judged
from gomboc_cad.paper.solids import solid
from gomboc_cad.paper.truths import true_rests
from gomboc_cad.progress import Progress

_ARCSEC = 3600.0
_FIELD_ERROR_DEG = 2.0
"""The paper's "2–3°" of mounting error; its ratio takes the lower end."""


def imu(progress: Progress) -> Table:
    """Orientation precision as the paper has it, and the true tilt per error of the COM."""
    # The room of products loads the CAD kernel, which takes a second or two.
    from gomboc_cad.products.imu_housing.calibration import tilt_cone_rad

    progress("imu")
    figures = published()["imu"]
    size, tolerance = figures["size_mm"], figures["tolerance_mm"]
    rest = _rest(size)
    soft, stiff = rest.tilt_deg_per_um
    tilt = soft * 1e3 * tolerance
    precision = math.degrees(math.atan(tolerance / size))
    allowed_um = precision / soft
    rows = [
        judged(
            "Orientation precision (arcsec)",
            figures["angular_precision_arcsec"],
            _ARCSEC * precision,
            _ARCSEC * tilt,
            "smooth census",
            "arctan(0.01/100) is no tilt of a body that balances: a COM error of 10 µm along the soft "
            f"direction tilts the rest by {tilt:.1f}°, and the paper's figure needs the COM within "
            f"{1e3 * allowed_um:.0f} nm.",
            refuted=True,
            digits=1,
        ),
        judged(
            "Improvement over 2–3° of mounting error",
            figures["improvement"],
            round(_FIELD_ERROR_DEG / precision),
            _FIELD_ERROR_DEG / tilt,
            "smooth census",
            "Against 2°, the lower end; 3° would give 524. With the true tilt a COM error of 10 µm is worse "
            "than the mounting error.",
            refuted=True,
            digits=1,
        ),
        *(_grade(grade, limit, tilt, soft) for grade, limit in figures["grade_limits_deg"].items()),
    ]
    cone = math.degrees(tilt_cone_rad(np.diag(np.radians([soft, stiff]) ** 2)))
    return Table(
        "imu",
        "IMU calibration housing",
        (
            f"At the rest the tilt is δu = −(∇²h)⁻¹ δ∇h. For the homogeneous primary of {size:g} mm nominal "
            f"diameter, in degrees per µm of COM error, along its soft and stiff directions: [[{soft:.3f}, "
            f"0], [0, {stiff:.5f}]].",
            "A COM error with a standard deviation of 1 µm along each direction gives a 95 % cone of "
            f"{cone:.2f}°.",
        ),
        tuple(rows),
    )


def _rest(diameter_mm: float) -> Rest:
    return exact_census(unit_body("primary").with_diameter(diameter_mm)).rest


def _grade(grade: str, limit_deg: float, tilt_deg: float, soft: float) -> Row:
    met = tilt_deg < limit_deg
    return judged(
        f"{grade.capitalize()} grade, below {limit_deg:g}°",
        "met",
        "met",
        "met" if met else "missed",
        "smooth census",
        f"The tilt is {tilt_deg:.1f}°; the grade needs the COM within {limit_deg / soft:.2g} µm along the "
        "soft direction.",
        refuted=not met,
    )


def seed_pod(progress: Progress) -> Table:
    """Share of correct landings, what that saves, and the tolerance of the shape."""
    progress("seed-pod")
    figures = published()["seed_pod"]
    side = solid("cylinder").boa
    body = unit_body("primary").with_diameter(figures["size_mm"])
    gomboc = true_rests("gomboc", 1)
    return Table(
        "seed-pod",
        "Seed pod",
        (
            "Shares are those of quasi-static releases onto a flat table, evenly over the orientations. A "
            "body that rolls has more energy, and soil is no table.",
        ),
        (
            judged(
                "Cylinder: share of correct landings",
                figures["cylinder_correct"],
                reading("cylinder").boa,
                side,
                "closed form",
                "It comes to lie on its side from a share of 2/√5 of the orientations.",
                refuted=abs(side - figures["cylinder_correct"]) > 5e-4,
            ),
            judged(
                "Gömböc: share of correct landings",
                figures["gomboc_correct"],
                reading("gomboc").boa,
                1.0 if gomboc.shown == 1 else None,
                gomboc.evidence,
                "One rest, on a rigid level table and with the COM within its margin; how far from it the "
                "body stops is a matter of rolling resistance.",
            ),
            _germination(figures["germination_loss_range"], figures["cylinder_correct"], side),
            *_shape_tolerances(figures, s_margin_mm(body, exact_census(body).com_mm)),
        ),
    )


def _germination(losses: list[float], claimed: float, side: float) -> Row:
    """Mean loss of a pod that lies wrongly as often as a cylinder does."""

    def saved(correct: float) -> str:
        return "–".join(f"{100.0 * loss * (1.0 - correct):.1f}" for loss in losses) + " %"

    return judged(
        "Germination loss that the shape eliminates",
        "–".join(f"{100.0 * loss:.0f}" for loss in losses) + " %",
        saved(claimed),
        saved(side),
        "arithmetic",
        "The loss is that of a seed which lies wrongly; against the paper's own cylinder only the share "
        "that does is gained. The germination figures are from the literature and were not checked.",
        refuted=True,
    )


def _shape_tolerances(figures: dict[str, Any], s_margin: float) -> list[Row]:
    """A form error with n undulations around the body changes `∇²h` by up to n² times its amplitude."""
    margin = s_margin / figures["size_mm"]
    shape, (finest, _) = figures["shape_tolerance"], figures["moulding_tolerance"]
    longest, shortest = (f"{100.0 * margin / n**2:.2g} %" for n in (2, 10))
    return [
        judged(
            "Shape tolerance needed, part of the size",
            f"{100.0 * shape:g} %",
            None,
            f"{longest} to {shortest}",
            "smooth census",
            f"The S-margin allows an amplitude of margin/n² to n undulations, here for n = 2 to 10: "
            f"{100.0 * shape:g} % is enough up to n = {math.isqrt(int(margin / shape))} only.",
        ),
        judged(
            "Injection moulding, 0.05 to 0.1 %",
            "may be insufficient",
            None,
            "insufficient" if finest > margin / 4.0 else "may suffice",
            "smooth census",
            f"Even two undulations may have {longest} only.",
            within=finest > margin / 4.0,
        ),
    ]
