"""How to accept the made part: what to measure and how far it may be off, and what a number of drops says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.special import betaincinv

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, unit
from gomboc_cad.body.support import support_height_mm
from gomboc_cad.report.json_values import Value

CONFIDENCE = 0.95
"""Of what the drops say."""

LIMITS_DEG = {"tactical": 0.05, "industrial": 1.0, "consumer": 3.0}
"""Usual limits of the tilt by class of use."""

_DROPS, _MISSES = (10, 20, 30, 59, 100, 300), (0, 1, 2)
_UNDULATIONS = (2, 3, 4, 6, 8)
MARGIN_SHARE = 0.25
"""Share of the S-margin that the mass error of one part may take."""


def protocol_document(
    body: Body, com_mm: Array, verdict: Value, tolerance: Value, surface_margin: Value, limit_deg: float
) -> dict[str, Any]:
    """What the acceptance of a part needs, as a JSON document.

    Args:
        body: The outer shape.
        com_mm: Centre of mass, shape (3,).
        verdict: `verdict.json`, or absent.
        tolerance: `tolerance.json`, or absent.
        surface_margin: S-margin of the outer surface in mm, which openings do not lower; or absent.
        limit_deg: Largest tilt of a good part.
    """
    document: dict[str, Any] = {
        "limit_deg": limit_deg,
        "drops": [_drops(count) for count in _DROPS],
        "form": _form(surface_margin, tolerance),
    }
    rest = verdict["rest"]
    if rest:
        frame = [unit(_vector(rest[key])) for key in ("direction", "soft_direction", "stiff_direction")]
        document["widths"] = _widths(body, np.array(frame))
        document["com"] = {"height_mm": rest["height_mm"].number, **_com_limits(verdict, limit_deg)}
        if verdict["s_margin_mm"]:
            document["masses"] = _masses(verdict, com_mm)
    return document


def share_at_least(drops: int, misses: int, confidence: float = CONFIDENCE) -> float:
    """Share of good drops that is exceeded with the given confidence, if so many of them missed.

    One end of the interval of Clopper and Pearson, Biometrika 26 (1934) 404; without a miss it is
    `(1 − confidence)^(1/n)`.
    """
    good = drops - misses
    return float(betaincinv(good, misses + 1, 1.0 - confidence)) if good > 0 else 0.0


def _drops(count: int) -> dict[str, Any]:
    return {
        "drops": count,
        "at_least": [
            {"misses": misses, "share": share_at_least(count, misses)} for misses in _MISSES if misses < count
        ],
    }


def _vector(value: Value) -> Array:
    result = np.array(value.numbers, dtype=float)
    if result.shape != (3,):
        raise value.refused("three numbers")
    return result


def _widths(body: Body, frame: Array) -> list[dict[str, Any]]:
    """Distance of two parallel jaws along the axes of the resting pose."""
    heights = support_height_mm(body, np.concatenate([frame, -frame]))
    axes = ("along the vertical of the resting pose", "along its soft axis", "along its stiff axis")
    return [
        {"axis": axis, "direction": direction.tolist(), "width_mm": float(low + high)}
        for axis, direction, low, high in zip(axes, frame, heights[:3], heights[3:], strict=True)
    ]


def _form(margin: Value, tolerance: Value) -> list[dict[str, Any]]:
    """Form error by undulations: what the study allows, else the margin over n²."""
    degrees = tolerance["form_error"]["degrees"]
    if degrees:
        return [
            {
                "undulations": int(degree["degree"].number),
                "guaranteed_um": degree["guaranteed_um"].number,
                "allowed_um": degree["allowed_um"].number if degree["allowed_um"].there else None,
            }
            for degree in degrees
        ]
    if not margin:
        return []
    margin_um = 1e3 * margin.number
    return [{"undulations": n, "guaranteed_um": margin_um / n**2, "allowed_um": None} for n in _UNDULATIONS]


def _com_limits(verdict: Value, limit_deg: float) -> Mapping[str, float | None]:
    """How far the centre of mass may be off: to right itself, and to point well enough."""
    soft = verdict["rest"]["tilt_deg_per_um"][0].number
    margin = verdict["s_margin_mm"]
    return {
        "self_righting_um": 1e3 * margin.number if margin else None,
        "pointing_um": limit_deg / soft if soft > 0.0 else None,
        "tilt_deg_per_um": soft,
    }


def _masses(verdict: Value, com_mm: Array) -> list[dict[str, Any]]:
    """How far each part's mass may be off until it takes its share of the S-margin: `δc = δm (p − c) / M`."""
    total = verdict["assembly"]["mass_g"].number
    allowed_um = MARGIN_SHARE * 1e3 * verdict["s_margin_mm"].number
    masses = []
    for part in verdict["parts"]:
        arm_mm = float(np.linalg.norm(_vector(part["com_mm"]) - com_mm))
        um_per_g = 1e3 * arm_mm / total if total > 0.0 else 0.0
        masses.append(
            {
                "name": part["name"].text,
                "mass_g": part["mass_g"].number,
                "com_um_per_g": um_per_g,
                "limit_g": allowed_um / um_per_g if um_per_g > 1e-9 else None,
                "made": bool(part["made"]),
            }
        )
    return masses
