"""The drill map as a table and as a picture of the whole surface."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.drill_map import DrillLimits, DrillMap, drill_limits
from gomboc_cad.report.canvas import figure_format, new_figure, write_figure
from gomboc_cad.solid.output import write_bytes

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
    longitude = np.linspace(-np.pi, np.pi, _LONGITUDES + 1)
    latitude = np.linspace(-0.5 * np.pi, 0.5 * np.pi, _LATITUDES + 1)
    middle_of = [0.5 * (edges[1:] + edges[:-1]) for edges in (longitude, latitude)]
    turn, rise = (part.ravel() for part in np.meshgrid(*middle_of))
    level = np.cos(rise)
    normals = np.stack([level * np.cos(turn), level * np.sin(turn), np.sin(rise)], axis=-1)
    radius = drill_limits(drilling.body, normals, drilling.com_mm).radius_mm

    figure = new_figure(10.0, 5.6)
    axes = figure.add_subplot(projection="mollweide")
    colors = axes.pcolormesh(longitude, latitude, radius.reshape(_LATITUDES, _LONGITUDES), cmap="viridis")
    figure.colorbar(colors, ax=axes, label="allowed radius / mm", shrink=0.8)
    for places, marker, name in (
        (drilling.best.directions, "o", "best places"),
        (np.array([drilling.rest.direction]), "v", "rest"),
    ):
        x, y, z = places.T
        axes.plot(np.arctan2(y, x), np.arcsin(z), marker, color="white", markeredgecolor="black", label=name)
    axes.grid(True, alpha=0.3)
    axes.legend(loc="lower left", fontsize="small")
    axes.set_title(
        f"{drilling.body.name}: largest hole or flat by the direction of its outward normal\n"
        "(longitude from x to y, latitude towards z)"
    )
    write_figure(figure, path)
