"""The figures of the paper, drawn again, with what is true beside what its oracle reads."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gomboc_cad.body import mass_properties
from gomboc_cad.body.sphere import Array
from gomboc_cad.paper.ballast import SHAPES, ballast_series
from gomboc_cad.paper.bodies import exact_census, named_mesh, spoken, unit_body
from gomboc_cad.paper.landscape import heights_and_slopes
from gomboc_cad.report.canvas import new_figure, write_figure

_LINES: dict[str, dict[str, Any]] = {
    "gomboc": {"color": "#1b7a3d", "zorder": 3},
    "sphere": {"color": "#2166ac", "linestyle": (0, (4, 4)), "zorder": 4},
    "ellipsoid": {"color": "#762a83"},
    "capsule": {"color": "#8c510a", "linestyle": (0, (1, 3)), "zorder": 5},
    "cylinder": {"color": "#b3432f"},
    "cube": {"color": "#e08214"},
}
"""Dashed and dotted where lines lie on each other."""

_MARKS: dict[str, dict[str, Any]] = {
    "stable": {"marker": "*", "color": "white", "markersize": 13, "linestyle": "none"},
    "unstable": {"marker": "^", "color": "#d62728", "markersize": 9, "linestyle": "none"},
}
_VIEWS = ((20.0, -60.0), (20.0, 60.0), (90.0, -90.0))
_STEP_DEG = 1.0


class PaperFigure(NamedTuple):
    """A figure of the paper.

    Attributes:
        file: Name of the file.
        table: Table beside which it stands.
        caption: What it shows.
        draw: Draws it to a path.
    """

    file: str
    table: str
    caption: str
    draw: Callable[[Path], None]


def draw_body(path: Path) -> None:
    """The primary from three sides, coloured by its distance from the unit sphere."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import TwoSlopeNorm

    polar, azimuth = np.meshgrid(
        np.linspace(0.0, np.pi, 121), np.linspace(0.0, 2.0 * np.pi, 241), indexing="ij"
    )
    directions = _directions(polar, azimuth)
    radius = unit_body("primary").radius_at(directions.reshape(-1, 3)).reshape(polar.shape)
    x, y, z = np.moveaxis(radius[..., None] * directions, -1, 0)
    scale = TwoSlopeNorm(1.0, radius.min(), radius.max())
    colors = colormaps["RdBu_r"](scale(radius))
    figure = new_figure(12.0, 4.4)
    for index, (elevation, turn) in enumerate(_VIEWS):
        axes = figure.add_subplot(1, 3, index + 1, projection="3d", elev=elevation, azim=turn)
        axes.plot_surface(x, y, z, facecolors=colors, rstride=2, cstride=2, shade=False)
        axes.set_axis_off()
        axes.set_box_aspect((1.0, 1.0, 1.0), zoom=1.4)
        axes.set_title(f"elevation {elevation:g}°, azimuth {turn:g}°", fontsize="medium")
    figure.colorbar(
        ScalarMappable(scale, "RdBu_r"), ax=figure.axes, label="distance from the origin / R₀", shrink=0.7
    )
    write_figure(figure, path)


def draw_landscape(path: Path) -> None:
    """The height of the primary's COM by the direction that points down, and how often each height occurs."""
    half = 0.5 * np.radians(_STEP_DEG)
    latitude = np.arange(-0.5 * np.pi + half, 0.5 * np.pi, 2.0 * half)
    longitude = np.arange(-np.pi + half, np.pi, 2.0 * half)
    # Both equilibria are on the x-axis; with the y-axis in the middle the map shows them whole.
    polar, azimuth = np.meshgrid(0.5 * np.pi - latitude, longitude + 0.5 * np.pi, indexing="ij")
    body = unit_body("primary")
    com = np.array(mass_properties(body).com_mm)
    directions = _directions(polar, azimuth).reshape(-1, 3)
    heights = heights_and_slopes(named_mesh("gomboc").vertices, com, directions)[0]
    figure = new_figure(12.0, 4.6)
    grid = figure.add_gridspec(1, 2, width_ratios=(2.0, 1.0))
    sky = figure.add_subplot(grid[0], projection="mollweide")
    drawn = sky.pcolormesh(longitude, latitude, heights.reshape(polar.shape), cmap="viridis", rasterized=True)
    for pose in exact_census(body).equilibria:
        x, y, z = pose.direction
        sky.plot(np.arctan2(-x, y), np.arcsin(z), label=f"{pose.kind} equilibrium", **_MARKS[pose.kind])
    sky.grid(True, alpha=0.3)
    sky.set(xticklabels=[], yticklabels=[], title="height of the COM / R₀ by the direction that points down")
    sky.legend(loc="lower right", fontsize="small", facecolor="#8888aa")
    figure.colorbar(drawn, ax=sky, orientation="horizontal", shrink=0.7)
    histogram = figure.add_subplot(grid[1])
    histogram.hist(heights, bins=60, weights=np.sin(polar).ravel(), density=True, color="#2166ac")
    histogram.set(xlabel="height of the COM / R₀", ylabel="density of the orientations")
    write_figure(figure, path)


def draw_ballast(path: Path) -> None:
    """Count and largest basin of the oracle against ballast, and the true number of rests."""
    figure = new_figure(12.0, 7.0)
    counts, truths, basins = (figure.add_subplot(2, 2, place) for place in (1, 2, 3))
    for name in SHAPES:
        series = ballast_series(name)
        for axes, values in ((counts, series.ecs), (truths, series.rests), (basins, series.boa)):
            axes.plot(series.fractions, values, label=spoken(name), linewidth=1.8, **_LINES[name])
    for axes, title in ((counts, "ECS, as the oracle counts"), (truths, "true number of stable rests")):
        axes.set(title=title, yscale="symlog", ylim=(-0.2, 60.0), yticks=(0, 1, 2, 3, 6, 10, 20, 50))
        axes.yaxis.set_major_formatter("{x:g}")
    basins.set(title="BOA, as the oracle reads it", ylim=(0.0, 1.05))
    for axes in (counts, truths, basins):
        axes.set_xlabel("ballast fraction w")
        axes.grid(True, alpha=0.3)
    key = figure.add_subplot(2, 2, 4)
    key.axis("off")
    key.legend(*counts.get_legend_handles_labels(), loc="center left", handlelength=4.0)
    write_figure(figure, path)


def _directions(polar: Array, azimuth: Array) -> Array:
    sine = np.sin(polar)
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(polar)], axis=-1)


FIGURES = (
    PaperFigure(
        "paper-body.png",
        "instances",
        "The primary from three sides; colour: distance of the surface from the origin.",
        draw_body,
    ),
    PaperFigure(
        "paper-landscape.png",
        "instances",
        "The height of the primary's centre of mass over the table: one minimum, one maximum.",
        draw_landscape,
    ),
    PaperFigure(
        "paper-ballast.svg",
        "ballast",
        "Against ballast: what the paper's oracle counts, how many rests there are, and the share of its "
        "largest basin. A ring or sphere of neutral rests counts as one.",
        draw_ballast,
    ),
)
