"""What the view in space shows: the outer surface with its colours, the parts, and the place of the COM."""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple, TypeVar

import numpy as np

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.errors import InspectionError
from gomboc_cad.report.folder import REPORT, VERDICT, Results
from gomboc_cad.report.json_values import Value
from gomboc_cad.report.packing import unpacked, unpacked_integers
from gomboc_cad.report.surface_fields import SurfaceFields
from gomboc_cad.report.zone_section import ZoneMesh

Record = TypeVar("Record")

_NAMES = {
    "table": "Table",
    "zone": "Border that the centre of mass must not cross",
    "margin": "S-margin around the centre of mass",
    "com": "Centre of mass",
}
_STOPS = 9
_MOST_PARTS = 400
_MOST_SHAPE_NUMBERS = 1 << 20


class Coloring(NamedTuple):
    """A way to colour the outer surface.

    Attributes:
        field: Name of the field of `SurfaceFields`.
        title: What it is called.
        unit: Its unit.
        map: Matplotlib's name of the colour map.
        zero: Where zero lies on it: anywhere, at its beginning or in its middle.
    """

    field: str
    title: str
    unit: str
    map: str
    zero: Literal["anywhere", "first", "middle"] = "anywhere"


COLORINGS = {
    "deviation": Coloring("deviation_mm", "deviation from the sphere", "mm", "RdBu_r", "middle"),
    "drill": Coloring("drill_radius_mm", "largest hole or flat, radius", "mm", "viridis", "first"),
    "curvature": Coloring("gaussian_curvature_per_mm2", "Gaussian curvature", "per mm²", "cividis"),
}


def read_record(read: Callable[[Mapping[str, Any]], Record], key: str, report: Mapping[str, Any]) -> Record:
    """A record of `report.json`.

    Raises:
        InspectionError: If it is damaged.
    """
    try:
        return read(report[key])
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, OverflowError, MemoryError):
        raise InspectionError(f"{REPORT}: {key} is damaged; write the folder again.") from None


def legend_of(fields: SurfaceFields) -> dict[str, dict[str, Any]]:
    """Range of each colouring with its title and unit, as a JSON document."""
    return {
        name: {"title": coloring.title, "unit": coloring.unit, "low": low, "high": high}
        for name, coloring, values in _colored(fields)
        for low, high in [_range(coloring, values)]
    }


def gradients() -> dict[str, str]:
    """The colour bar of each colouring, as the stops of a CSS gradient."""
    shares = np.linspace(0.0, 1.0, _STOPS)
    return {
        name: ", ".join(f"rgb({r} {g} {b})" for r, g, b in _colors(coloring, shares).tolist())
        for name, coloring in COLORINGS.items()
    }


def scene_of(results: Results) -> dict[str, Any] | None:
    """The scene of a folder, for the page's script; None where the folder has no shapes.

    Raises:
        InspectionError: If a shape is damaged.
    """
    report = results.plain(REPORT) or {}
    if "surface" not in report:
        return None
    fields = read_record(SurfaceFields.of_document, "surface", report)
    _require_shape(fields.positions_mm, fields.faces, "surface")
    if any(values.shape != (len(fields.positions_mm),) for _, _, values in _colored(fields)):
        raise InspectionError(f"{REPORT}: surface has a corner without a value; write the folder again.")
    stored, verdict = report["surface"], results.value(VERDICT)
    margin = verdict["s_margin_mm"]
    com_mm, pose = np.array(fields.com_mm), np.array(fields.pose)
    arms = (fields.positions_mm - com_mm) @ pose[2]
    scene: dict[str, Any] = {
        "names": _NAMES,
        "size_mm": 2.0 * fields.radius_mm,
        "com_mm": com_mm.tolist(),
        "pose": pose.tolist(),
        "height_mm": float(-arms.min()),
        "margin_mm": margin.number if margin.there else None,
        "surface": {
            "name": "Outer surface",
            "positions_mm": stored["positions_mm"],
            "normals": stored["normals"],
            "faces": stored["faces"],
            "tints": {
                name: _packed_colors(_colors(coloring, _shares(coloring, values)))
                for name, coloring, values in _colored(fields)
            },
        },
        "parts": [_part(part) for part in list(results.value(REPORT)["parts"])[:_MOST_PARTS]],
    }
    if "zone_mesh" in report:
        mesh = read_record(ZoneMesh.of_document, "zone_mesh", report)
        _require_shape(mesh.vertices_mm, mesh.faces, "zone_mesh")
        stored = report["zone_mesh"]
        scene["zone"] = {"positions_mm": stored["vertices_mm"], "faces": stored["faces"]}
    return scene


def _colored(fields: SurfaceFields) -> list[tuple[str, Coloring, Array]]:
    """The colourings with a value at each corner; there is no drill map of a body that is not convex."""
    found = [(name, coloring, getattr(fields, coloring.field)) for name, coloring in COLORINGS.items()]
    return [entry for entry in found if entry[2] is not None]


def _part(part: Value) -> dict[str, Any]:
    """A part as it is stored, after a look at it."""
    shape = part.raw
    _shape(part)
    color = part["color"].numbers
    if len(color) != 3 or not all(0.0 <= value <= 1.0 for value in color):
        raise part["color"].refused("three numbers from 0 to 1")
    return {
        "name": part["name"].text,
        "color": color,
        "positions_mm": shape["positions_mm"],
        "faces": shape["faces"],
    }


def _shape(value: Value) -> None:
    for key in ("positions_mm", "faces"):
        if not isinstance(value[key].raw, dict):
            raise value[key].refused("a packed array")
    _require_shape(unpacked(value["positions_mm"].raw), unpacked_integers(value["faces"].raw), value.where)


def _require_shape(points: Array, faces: IntArray, where: str) -> None:
    """Refuse facets whose corners are not there."""
    fits = points.ndim == faces.ndim == 2 and points.shape[1] == faces.shape[1] == 3
    if not fits or not len(points) or points.size > _MOST_SHAPE_NUMBERS or faces.size > _MOST_SHAPE_NUMBERS:
        raise InspectionError(f"{where} is no shape; write the folder again.")
    if faces.size and (faces.min() < 0 or faces.max() >= len(points)):
        raise InspectionError(f"{where} has facets without corners; write the folder again.")


def _range(coloring: Coloring, values: Array) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    reach = max(abs(low), abs(high))
    return {"anywhere": (low, high), "first": (0.0, high), "middle": (-reach, reach)}[coloring.zero]


def _shares(coloring: Coloring, values: Array) -> Array:
    """Where each value lies between the ends of its colouring, from 0 to 1."""
    low, high = _range(coloring, values)
    result: Array = (values - low) / ((high - low) or 1.0)
    return result


def _colors(coloring: Coloring, shares: Array) -> IntArray:
    """Red, green and blue from 0 to 255, shape (n, 3)."""
    from matplotlib import colormaps

    result: IntArray = colormaps[coloring.map](shares, bytes=True)[:, :3]
    return result


def _packed_colors(colors: IntArray) -> dict[str, Any]:
    data = base64.b64encode(np.ascontiguousarray(colors, dtype=np.uint8).tobytes()).decode("ascii")
    return {"dtype": "uint8", "shape": list(colors.shape), "base64": data}
