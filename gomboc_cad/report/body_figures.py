"""The outer surface from three sides, coloured by one of its fields."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.report.style import DEVIATIONS, HEIGHTS, INK, figure_of, new_axes, styled
from gomboc_cad.report.surface_fields import SurfaceFields

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize

Field = Literal["deviation", "curvature", "drill"]

_APART = 2.35
"""Distance between the views, in units of R₀."""

_AMBIENT = 0.72
"""Brightness where the light does not fall; colours have to be read from the scale."""


class _View(NamedTuple):
    """The axes of a view in the resting frame: to the right, upwards and to the eye."""

    name: str
    right: tuple[float, float, float]
    up: tuple[float, float, float]


_VIEWS = (
    _View("along the stiff direction", (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    _View("along the soft direction", (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    _View("from above", (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
)


@styled
def plot_body(
    fields: SurfaceFields, field: Field = "deviation", ax: Axes | None = None, *, unit: str = "mm"
) -> Axes:
    """Draw the body at rest from two sides and from above, coloured by a field.

    Args:
        fields: The surface.
        field: `deviation` from the nominal sphere, Gaussian `curvature`, or the radius allowed to `drill`.
        ax: Axes to draw on; new ones if not given.
        unit: What a length of 1 is called.

    Returns:
        The axes; lengths on them are in mm.

    Raises:
        ValueError: If the drill map of a body is asked for that is not strictly convex.
    """
    from matplotlib.cm import ScalarMappable

    ax = new_axes(ax, (9.0, 3.6))
    values, label, scale = _values(fields, field, unit)
    shown = ScalarMappable(scale, DEVIATIONS if field == "deviation" else HEIGHTS)
    colors = shown.to_rgba(values)
    corners = fields.positions_mm - np.array(fields.com_mm)
    table = float((corners @ np.array(fields.pose[2])).min())
    apart = _APART * fields.radius_mm
    for number, view in enumerate(_VIEWS):
        right, up = (np.array(axis) @ np.array(fields.pose) for axis in (view.right, view.up))
        shift = np.array([number * apart, 0.0])
        points = corners @ np.stack([right, up], axis=-1) + shift
        _draw_view(ax, fields, points, np.cross(right, up), colors)
        ax.text(number * apart, -1.35 * fields.radius_mm, view.name, ha="center", fontsize="small")
    ax.plot([-0.45 * apart, 1.45 * apart], [table, table], color=INK, linewidth=1.2)
    high = 1.05 * float(np.linalg.norm(corners, axis=1).max())
    ax.set(aspect="equal", xlim=(-0.48 * apart, 2.48 * apart), ylim=(-1.4 * fields.radius_mm, high))
    ax.set_axis_off()
    bar = figure_of(ax).colorbar(shown, ax=ax, orientation="horizontal", shrink=0.6, aspect=40, pad=0.02)
    bar.set_label(label)
    return ax


def _values(fields: SurfaceFields, field: Field, unit: str) -> tuple[Array, str, Normalize]:
    """The values at the corners, what they are, and their scale."""
    from matplotlib.colors import Normalize

    if field == "deviation":
        most = float(np.abs(fields.deviation_mm).max()) or 1.0
        return fields.deviation_mm, f"deviation from the sphere of radius R₀ / {unit}", Normalize(-most, most)
    if field == "curvature":
        values = fields.gaussian_curvature_per_mm2 * fields.radius_mm**2
        scale = Normalize(float(values.min()), float(values.max()))
        return values, "Gaussian curvature / R₀⁻² (sphere: 1)", scale
    radius = fields.drill_radius_mm
    if radius is None:
        raise ValueError("The body is not strictly convex, so it has no drill map.")
    scale = Normalize(0.0, float(radius.max()))
    return radius, f"radius of the largest hole or flat that adds no rest / {unit}", scale


def _draw_view(ax: Axes, fields: SurfaceFields, points: Array, eye: Array, colors: Array) -> None:
    """Draw the triangles that face the eye, the farthest first, at points (n, 2) of the paper."""
    from matplotlib.collections import TriMesh
    from matplotlib.tri import Triangulation

    facing = fields.normals[fields.faces].sum(axis=1) @ eye > 0.0
    faces = fields.faces[facing]
    faces = faces[np.argsort((fields.positions_mm[faces] @ eye).sum(axis=1), kind="stable")]
    light = _AMBIENT + (1.0 - _AMBIENT) * np.maximum(0.0, fields.normals @ eye)
    shaded = np.column_stack([colors[:, :3] * light[:, None], colors[:, 3]])
    x, y = points.T
    mesh = TriMesh(Triangulation(x, y, faces), facecolors=shaded, rasterized=True)
    ax.add_collection(mesh, autolim=False)
