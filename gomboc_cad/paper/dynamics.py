"""What the paper calls dynamics: four averages over the landscape of heights."""

from __future__ import annotations

from gomboc_cad.body.catalogue import named_body
from gomboc_cad.body.sphere import fibonacci_directions
from gomboc_cad.dynamics import Resistance, RollingBody, righting
from gomboc_cad.paper.bodies import exact_census, reading, spoken, unit_body
from gomboc_cad.paper.landscape import mean_height, mean_slope
from gomboc_cad.paper.published import published
from gomboc_cad.paper.records import Evidence, Row, Table, judged, shown
from gomboc_cad.paper.solids import Solid, solid
from gomboc_cad.paper.truths import true_rests
from gomboc_cad.progress import Progress

_UNKNOWN_SIZE = 0.05
"""A length that is further off than this part of it is not explained by an unknown size."""

_MISSED = 0.01

_DIAMETER_MM = 100.0
_RELEASES = 6
_RESISTANCE = Resistance(rolling_mm=0.01, damping_per_s=0.2)
_TOLERANCE = 1e-5
"""Tilts and times as they are printed are the same from 1e-7 on."""

_SECANT = (
    "The table has the mean of (h − h_min) over the angle to the rest, not the mean gradient that its note "
    "names, which is about twice as large."
)
_BASIN: dict[str, str] = {
    "gomboc": "Every orientation but the unstable one ends in the one rest.",
    "ellipsoid": "Half of the orientations end on either end of the shortest axis; the merge makes them one.",
    "capsule": "Every orientation but the two on end rolls down to the ring, though to no one pose of it.",
    "cylinder": "It falls on its side from all but a share of 1 − 2/√5 of the orientations.",
    "cube": "A sixth ends on each face; what is given is the share of several faces together.",
}


def dynamics(progress: Progress) -> Table:
    """Count, mean drop, height range, mean slope and largest basin of five bodies."""
    rows: list[Row] = []
    for name, figures in published()["dynamics"].items():
        progress(f"dynamics: {name}")
        rows += _rows(name, figures)
    progress("dynamics: rolling")
    rolled = _rolled()
    progress("dynamics: ratios")
    figures = published()["dynamics"]
    rows += [_ratio(figures, other, claimed) for other, claimed in (("capsule", 27), ("ellipsoid", 14))]
    return Table(
        "dynamics",
        "Self-righting dynamics",
        (
            "None of these is dynamics: they are averages of the height h over the orientations. How long a "
            f"body takes, and where it comes to lie, follows from its rolling. {rolled}",
            "ECS: rests. SRE: mean height above the lowest. BOA: share of the largest cluster. Lengths are "
            "those of bodies with the volume of the unit ball, of the Gömböc with R₀ = 1.",
        ),
        tuple(rows),
    )


def _rolled() -> str:
    """What a primary does in time, by `gomboc_cad.dynamics`."""
    body = RollingBody.homogeneous(named_body("primary", _DIAMETER_MM))
    found = righting(body, fibonacci_directions(_RELEASES), _RESISTANCE, tolerance=_TOLERANCE)
    first, last = (round(float(time)) for time in (found.righting_time_s.min(), found.righting_time_s.max()))
    return (
        f"A primary of {_DIAMETER_MM:g} mm that rolls without slip, with a rolling-resistance length of "
        f"{_RESISTANCE.rolling_mm:g} mm and a damping of {_RESISTANCE.damping_per_s:g} per s, released at "
        f"rest from {_RELEASES} orientations, is within {found.upright_deg:g}° of its rest for good after "
        f"{first} to {last} s and stops {found.tilt_deg.max():.1f}° from it at most (`gomboc_cad.dynamics`)."
    )


def _solid(name: str) -> Solid:
    """What is true of a row; of the primary by its census."""
    if name != "gomboc":
        return solid(name)
    census = exact_census(unit_body("primary"))
    drop = mean_height("primary") - census.rest.height_mm
    return Solid(census.stable, "", census.height_range_mm, drop, 1.0)


def _rows(name: str, figures: list[float]) -> list[Row]:
    found, exact, label = reading(name), _solid(name), spoken(name)
    rests = true_rests(name, int(figures[0]))
    primary = name == "gomboc"
    evidence: Evidence = "smooth census" if primary else "closed form"
    slope = mean_slope(name)

    def length(what: str, index: int, reproduced: float, truth: float | None, kind: Evidence) -> Row:
        why = _length_reason(figures[index], reproduced, truth)
        return judged(f"{label}: {what}", figures[index], reproduced, truth, kind, why)

    return [
        judged(
            f"{label}: ECS",
            int(figures[0]),
            found.ecs,
            rests.shown,
            rests.evidence,
            "Not the number of its rests." if rests.refutes else "The number of its rests.",
            refuted=rests.refutes,
        ),
        length("SRE", 1, found.sre_mm, exact.sre, "quadrature" if primary else evidence),
        length("h-range", 2, found.height_range_mm, exact.height_range, evidence),
        judged(
            f"{label}: steepness",
            figures[3],
            found.steepness_mm_per_rad,
            slope,
            "quadrature",
            _SECANT,
            refuted=abs(slope / figures[3] - 1.0) > _UNKNOWN_SIZE,
        ),
        judged(
            f"{label}: BOA",
            figures[4],
            found.boa,
            exact.boa,
            evidence,
            _BASIN[name],
            refuted=abs(exact.boa - figures[4]) > 5e-4,
        ),
    ]


def _length_reason(paper: float, reproduced: float, truth: float | None) -> str:
    if shown(paper, 3) == shown(reproduced, 3):
        return "The same in its digits."
    apart = 100.0 * abs(reproduced / paper - 1.0)
    reason = f"{apart:.2g} % apart, as the size that the paper does not give may make it"
    if truth is not None and abs(reproduced / truth - 1.0) > _MISSED:
        return f"{reason}; no sampled direction meets the lowest or the highest pose, so the truth is higher."
    return f"{reason}."


def _ratio(figures: dict[str, list[float]], other: str, claimed: int) -> Row:
    truth = (_solid(other).sre or 0.0) / (_solid("gomboc").sre or 1.0)
    return judged(
        f"SRE of the {other} over that of the Gömböc",
        claimed,
        round(reading(other).sre_mm / reading("gomboc").sre_mm),
        truth,
        "quadrature",
        "The ratio of two mean drops; that a body drops less does not say that its rest is reached: what it "
        "rolls over on the way counts too.",
        digits=1,
    )
