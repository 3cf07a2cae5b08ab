"""The drill map as a table and as a picture of the whole surface."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.body.support import touching_directions
from gomboc_cad.equilibria.drill_map import DrillLimits, DrillMap, safe_radius_mm
from gomboc_cad.report.style import (
    BELOW,
    HEIGHTS,
    MARK,
    figure_format,
    figure_of,
    new_axes,
    styled,
    write_figure,
)
from gomboc_cad.solid.output import write_bytes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LATITUDES, _LONGITUDES = 36, 72


def write_drill_table(drilling: DrillMap, path: Path) -> None:
    """Write the best places and then all sites as CSV, one line each.

    Raises:
        OutputError: If the file cannot be written.
    """
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    head = ("kind", "normal_x", "normal_y", "normal_z", "x_mm", "y_mm", "z_mm")
    writer.writerow((*head, "radius_mm", "refined_radius_mm", "flat_depth_mm"))
    for kind, limits in (("best", drilling.best), ("site", drilling.sites)):
        for row in _rows(limits):
            writer.writerow([kind, *(f"{value:.6g}" for value in row)])
    write_bytes(path, stream.getvalue().encode())


def _rows(limits: DrillLimits) -> Array:
    return np.column_stack(
        [
            limits.directions,
            limits.positions_mm,
            limits.radius_mm,
            limits.refined_radius_mm,
            limits.flat_depth_mm,
        ]
    )


def draw_drill_map(drilling: DrillMap, path: Path) -> None:
    """Draw the allowed radius over all outward directions in Mollweide's projection, as PNG or SVG.

    Raises:
        OutputError: If the suffix is neither, or the file cannot be written.
    """
    figure_format(path)
    write_figure(figure_of(plot_drill_map(drilling)), path)


@styled
def plot_drill_map(drilling: DrillMap, ax: Axes | None = None) -> Axes:
    """Draw the allowed radius over all outward directions, by longitude from x to y and latitude towards z.

    Args:
        drilling: What is drawn.
        ax: Axes of Mollweide's projection to draw on; new ones if not given.

    Returns:
        The axes.
    """
    ax = new_axes(ax, (9.0, 5.2), "mollweide")
    longitude = np.linspace(-np.pi, np.pi, _LONGITUDES + 1)
    latitude = np.linspace(-0.5 * np.pi, 0.5 * np.pi, _LATITUDES + 1)
    middle_of = [0.5 * (edges[1:] + edges[:-1]) for edges in (longitude, latitude)]
    turn, rise = (part.ravel() for part in np.meshgrid(*middle_of))
    level = np.cos(rise)
    normals = np.stack([level * np.cos(turn), level * np.sin(turn), np.sin(rise)], axis=-1)
    touching = touching_directions(drilling.body, normals)
    radius = safe_radius_mm(drilling.body, touching, drilling.com_mm)
    cells = radius.reshape(_LATITUDES, _LONGITUDES)
    colors = ax.pcolormesh(longitude, latitude, cells, cmap=HEIGHTS, rasterized=True)
    bar = figure_of(ax).colorbar(colors, ax=ax, shrink=0.8)
    bar.set_label("radius of the largest hole or flat / mm")
    for places, marker, name in (
        (drilling.best.directions, "o", "best places"),
        (np.array([drilling.rest.direction]), "v", "rest"),
    ):
        x, y, z = places.T
        ax.plot(np.arctan2(y, x), np.arcsin(z), marker, label=name, **MARK)
    ax.grid(True)
    ax.tick_params(labelsize="small")
    ax.legend(**BELOW | {"borderaxespad": 1.0})
    ax.set_title(f"{drilling.body.name}: largest hole or flat by the direction of its outward normal")
    return ax
