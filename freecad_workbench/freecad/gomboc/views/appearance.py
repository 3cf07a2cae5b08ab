"""Colours, transparency and display modes by the kind of an object and by what was found for it."""

from __future__ import annotations

from typing import Any, Sequence, Tuple

from freecad.gomboc import jobs

from . import camera, marks
from .provider import PARTS_MODE

Rgb = Tuple[float, float, float]

PRODUCTS = ("imu-housing", "seed-pod", "buoy")

ZONE_COLOR, ZONE_TRANSPARENCY = (0.40, 0.90, 0.45), 65
PASS_COLOR, FAIL_COLOR = (0.18, 0.62, 0.25), (0.84, 0.20, 0.18)

# From dark to bright as the value grows; the colour-blind and grey prints can tell them apart.
_SCALE: Sequence[tuple[float, Rgb]] = (
    (0.00, (0.27, 0.00, 0.33)),
    (0.25, (0.23, 0.32, 0.55)),
    (0.50, (0.13, 0.57, 0.55)),
    (0.75, (0.37, 0.79, 0.38)),
    (1.00, (0.99, 0.91, 0.14)),
)


def begin(document_object: Any) -> None:
    """The look of a new object."""
    kind, view = marks.kind(document_object), document_object.ViewObject
    if kind == "zone":
        view.ShapeColor, view.Transparency = ZONE_COLOR, ZONE_TRANSPARENCY
    elif kind == "drillmap":
        view.DisplayMode = "Shaded"
    elif kind == "check":
        # It is all lines, which "Shaded" does not draw.
        view.DisplayMode = "Flat Lines"
        view.LineWidth, view.PointSize = 4.0, 8.0
    elif marks.kind(document_object) in PRODUCTS:
        view.DisplayMode = PARTS_MODE


def show_results(document_object: Any) -> None:
    """The look of an object that was computed."""
    if document_object.Status != jobs.DONE:
        return
    kind, view = marks.kind(document_object), document_object.ViewObject
    if kind == "drillmap":
        _color_map(document_object)
    elif kind == "check":
        _color_poses(document_object)
    if not view.Proxy.was_seen:
        view.Proxy.was_seen = True
        if kind in ("zone", "drillmap"):
            # Both lie on the surface of their subject, or around it.
            document_object.Subject.ViewObject.Visibility = False
        elif _is_alone(document_object):
            camera.view_at_rest(document_object)


def scale_color(share: float) -> Rgb:
    """The colour of a value between 0 and 1 of the largest."""
    share = min(max(share, 0.0), 1.0)
    for (low, first), (high, second) in zip(_SCALE, _SCALE[1:]):
        if share <= high:
            weight = (share - low) / (high - low)
            red, green, blue = ((1 - weight) * a + weight * b for a, b in zip(first, second))
            return (red, green, blue)
    raise ValueError(share)


def scale(document_object: Any) -> list[tuple[str, str]]:
    """What the colours of an object mean, as (colour, value); empty where they mean nothing."""
    if marks.kind(document_object) != "drillmap" or not document_object.Radii:
        return []
    largest = max(document_object.Radii)
    return [(_html(color), f"{share * largest:.2g}") for share, color in _SCALE]


def _html(color: Rgb) -> str:
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in color)


def _color_map(drill_map: Any) -> None:
    radii: list[float] = list(drill_map.Radii)
    largest = max(radii, default=0.0)
    if largest > 0:
        drill_map.ViewObject.DiffuseColor = [scale_color(radius / largest) for radius in radii]


def _color_poses(check: Any) -> None:
    color = PASS_COLOR if marks.mark(check) == marks.PASS else FAIL_COLOR
    check.ViewObject.LineColor = check.ViewObject.PointColor = color


def _is_alone(document_object: Any) -> bool:
    family = {document_object.Name, *(each.Name for each in document_object.OutListRecursive)}
    return all(other.Name in family for other in document_object.Document.Objects)
