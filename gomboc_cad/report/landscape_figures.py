"""The map of the height over all poses, and how often each height occurs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gomboc_cad.report.landscape import HeightLandscape
from gomboc_cad.report.style import BELOW, BLUE, HEIGHTS, INK, MARK, figure_of, new_axes, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MARKS: dict[str, dict[str, Any]] = {
    "stable": {"marker": "v", "markersize": 9, **MARK},
    "saddle": {"marker": "X", "markersize": 8, **MARK},
    "unstable": {"marker": "^", "markersize": 9, **MARK},
}
_NAMES = {"stable": "stable rest", "saddle": "saddle", "unstable": "unstable equilibrium"}
_CONTOURS = 12
_AXES = ("x", "y", "z")


@styled
def plot_landscape(landscape: HeightLandscape, ax: Axes | None = None, *, unit: str = "mm") -> Axes:
    """Draw the height of the COM over all poses, with the equilibria and the borders of the basins.

    Args:
        landscape: What is drawn.
        ax: Axes of Mollweide's projection to draw on; new ones if not given.
        unit: What a length of 1 is called.

    Returns:
        The axes.
    """
    from matplotlib import patheffects

    ax = new_axes(ax, (8.0, 4.6), "mollweide")
    around: list[patheffects.AbstractPathEffect] = [patheffects.withStroke(linewidth=2.5, foreground="black")]
    longitude, latitude, heights = landscape.longitudes, landscape.latitudes, landscape.heights_mm
    drawn = ax.pcolormesh(longitude, latitude, heights, cmap=HEIGHTS, shading="nearest", rasterized=True)
    lines = ax.contour(longitude, latitude, heights, _CONTOURS, colors="black", linewidths=0.4, alpha=0.5)
    lines.set_rasterized(True)
    for basin in range(1, int(landscape.basins.max()) + 1):
        inside = (landscape.basins == basin).astype(float)
        border = ax.contour(longitude, latitude, inside, [0.5], colors="white", linewidths=1.2)
        border.set_path_effects(around)
    for kind, name in _NAMES.items():
        places = [pose.direction for pose in landscape.poses if pose.kind == kind]
        if places:
            ax.plot(*landscape.place(np.array(places)), label=f"{name} ({len(places)})", **_MARKS[kind])
    for name, axis in zip(_AXES, np.eye(3), strict=True):
        for sign in (1.0, -1.0):
            x, y = landscape.place(sign * axis[None])
            text = f"{'+' if sign > 0.0 else '−'}{name}"
            above = 8 if y[0] < 1.0 else -16
            style: dict[str, Any] = {"textcoords": "offset points", "ha": "center", "color": "white"}
            label = ax.annotate(text, (x[0], y[0]), xytext=(0, above), fontsize="small", **style)
            label.set_path_effects(around)
    ax.set(xticks=[], yticks=[])
    count = len(np.unique(landscape.basins))
    title = f"{count} basin{'s' if count > 1 else ''}; letters: axes of the body"
    ax.legend(title=title, title_fontsize="small", **BELOW | {"borderaxespad": 1.0, "ncols": 3})
    figure_of(ax).colorbar(drawn, ax=ax, label=f"height of the COM / {unit}", shrink=0.8)
    return ax


@styled
def plot_height_histogram(landscape: HeightLandscape, ax: Axes | None = None, *, unit: str = "mm") -> Axes:
    """Draw how often each height occurs among evenly spread orientations.

    Args:
        landscape: What is drawn.
        ax: Axes to draw on; new ones if not given.
        unit: What a length of 1 is called.

    Returns:
        The axes.
    """
    ax = new_axes(ax, (5.0, 3.6))
    heights, shares = landscape.heights_mm.ravel(), landscape.shares.ravel()
    ax.hist(heights, bins=36, weights=shares, density=True, color=BLUE)
    for pose in landscape.poses:
        ax.axvline(pose.height_mm, color=INK, linewidth=0.8, linestyle=(0, (4, 3)))
    ax.set(xlabel=f"height of the COM / {unit}", ylabel="density of the orientations")
    return ax
