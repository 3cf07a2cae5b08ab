"""The loading zone: the section that decides, and three sections of the whole zone with its margin."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gomboc_cad.body.sphere import Array, fibonacci_directions
from gomboc_cad.equilibria.smooth import smooth_census
from gomboc_cad.equilibria.zone import LoadingZone, margins_towards_rest
from gomboc_cad.report.sections import section_loops
from gomboc_cad.report.style import (
    BELOW,
    BLUE,
    GREEN,
    INK,
    PLAIN,
    PURPLE,
    VERMILION,
    figure_format,
    new_axes,
    new_figure,
    styled,
    write_figure,
)
from gomboc_cad.report.zone_section import Fields, ZoneSection, zone_section

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_AXES = "xyz"
_PLANES = ((0, 1), (0, 2), (1, 2))
_CLOSE_UP = 8.0
"""Half the width of the close-ups, in S-margins of the given COM or of the nearest best one."""

_FILL = 0.35
_CHI_95 = float(np.sqrt(-2.0 * np.log(0.05)))
"""Radius, in standard deviations, of the ellipse that holds 95 % of a normal distribution in a plane."""


@styled
def plot_zone_section(section: ZoneSection, ax: Axes | None = None, *, whole: bool = False) -> Axes:
    """Draw how many rests the body has with the COM elsewhere in a plane, and what is known of the COM.

    Args:
        section: What is drawn.
        ax: Axes to draw on; new ones if not given.
        whole: Whether to show the whole body instead of the surroundings of the COM.

    Returns:
        The axes; lengths on them are in mm from the COM.
    """
    from matplotlib.patches import Patch

    ax = new_axes(ax, (5.8, 6.6))
    fields = section.whole if whole else section.close_up
    _paint(ax, fields)
    for curve in section.curves_mm:
        ax.plot(*np.append(curve, curve[:1], axis=0).T, color=VERMILION, linewidth=0.9)
    ax.plot(*np.append(section.outline_mm, section.outline_mm[:1], axis=0).T, color=INK, linewidth=1.0)
    ax.plot(0.0, 0.0, "+", color=INK, markersize=9, markeredgewidth=1.6, label="centre of mass")
    _draw_margins_of(ax, section)
    if not whole:
        nearest = "nearest place with other rests"
        ax.plot(*section.witness_mm, "o", color=VERMILION, markersize=5, label=nearest)
        if section.com_covariance_mm2 is not None:
            ellipse = _CHI_95 * _deviations(section.com_covariance_mm2)
            style = {"linewidth": 1.8, "linestyle": (0, (4, 2)), "label": "95 % of the COM errors"}
            _draw_ring(ax, (0.0, 0.0), ellipse, PURPLE, **style)
    places = [Patch(facecolor=BLUE, alpha=_FILL, label="one stable rest")]
    places.append(Patch(facecolor=VERMILION, alpha=_FILL, label="more than one"))
    handles = ax.get_legend_handles_labels()[0]
    ax.legend(handles=places + handles, **BELOW)
    reach = fields.reach_mm
    ax.set(aspect="equal", xlim=(-reach, reach), ylim=(-reach, reach))
    ax.set(xlabel="towards the nearest other rest, level / mm", ylabel="up at rest / mm")
    return ax


@styled
def plot_zone(zone: LoadingZone, ax: Axes | None = None) -> Axes:
    """Draw the section of a zone through its COM and the nearest place with other rests.

    Args:
        zone: The zone.
        ax: Axes to draw on; new ones if not given.

    Returns:
        The axes.
    """
    return plot_zone_section(zone_section(zone.body, smooth_census(zone.body, zone.com_mm)), ax)


def _paint(ax: Axes, fields: Fields) -> None:
    from matplotlib.colors import to_rgba

    colors = np.array([(0.0, 0.0, 0.0, 0.0), to_rgba(BLUE, _FILL), to_rgba(VERMILION, _FILL)])
    reach = fields.reach_mm
    image = colors[np.minimum(fields.rests, 2)]
    ax.imshow(image, origin="lower", extent=(-reach, reach, -reach, reach), interpolation="nearest")


def _draw_margins_of(ax: Axes, section: ZoneSection) -> None:
    """Draw the S-margin of the body, and that of the product where openings make it smaller."""
    margin, product = section.s_margin_mm, section.product_margin_mm
    less = product is not None and product < 0.999 * margin
    name = "S-margin without openings" if less else "S-margin"
    line = (0, (2, 2)) if less else "solid"
    reach = margin * np.eye(2)
    _draw_ring(ax, (0.0, 0.0), reach, INK, linestyle=line, label=f"{name}, {margin:.3g} mm")
    if product is not None and less:
        label = f"S-margin of the product, {product:.3g} mm"
        _draw_ring(ax, (0.0, 0.0), product * np.eye(2), GREEN, linewidth=1.8, label=label)


def _draw_ring(ax: Axes, center: tuple[float, float], reach_mm: Array, color: str, **style: Any) -> None:
    """Draw the image of the unit circle under a matrix (2, 2) about a centre."""
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=-1) @ reach_mm.T + center
    ax.plot(*ring.T, color=color, **style)


def _deviations(covariance: Array) -> Array:
    """A square root of a covariance (2, 2)."""
    values, vectors = np.linalg.eigh(covariance)
    result: Array = vectors * np.sqrt(np.maximum(values, 0.0))
    return result


def write_zone(zone: LoadingZone, mesh_path: Path, figure_path: Path) -> None:
    """Write the boundary of a zone as a binary STL file and its sections as a figure.

    Raises:
        OutputError: If a file cannot be written.
    """
    # The writer comes with the kernel, which takes a second to load.
    from gomboc_cad.solid.export import write_stl
    from gomboc_cad.solid.mesh import Mesh

    write_stl(mesh_path, Mesh(zone.vertices_mm, zone.faces), "zone")
    draw_zone(zone, figure_path)


@styled
def draw_zone(zone: LoadingZone, path: Path) -> None:
    """Draw three sections, whole and in close-up, and the margin towards the rest, as PNG or SVG.

    Raises:
        OutputError: If the suffix is neither, or the file cannot be written.
    """
    figure_format(path)
    figure = new_figure(12.0, 11.5)
    grid = figure.add_gridspec(3, 3, height_ratios=(1.0, 1.0, 0.7))
    close = _CLOSE_UP * zone.nearest_best_s_margin_mm
    for column, plane in enumerate(_PLANES):
        loops = section_loops(zone.vertices_mm, zone.faces, np.array(zone.com_mm), plane)
        whole, detail = (figure.add_subplot(grid[row, column]) for row in (0, 1))
        for axes in (whole, detail):
            _draw_section(axes, zone, plane, loops)
        reach = 1.05 * float(np.abs(zone.body.position_mm(fibonacci_directions(500))).max())
        whole.set(xlim=(-reach, reach), ylim=(-reach, reach))
        center = [zone.com_mm[axis] for axis in plane]
        detail.set(xlim=(center[0] - close, center[0] + close), ylim=(center[1] - close, center[1] + close))
        whole.set_title(f"section {_AXES[plane[0]]}{_AXES[plane[1]]} through the given COM")
        detail.set_title("close-up")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    _draw_margins(figure.add_subplot(grid[2, :]), zone)
    figure.suptitle(
        f"{zone.body.name}: COM positions with one stable rest (blue); margin {zone.s_margin_mm:.3g} mm at "
        f"the given COM, {zone.nearest_best_s_margin_mm:.3g} mm at the nearest best one"
    )
    write_figure(figure, path)


def _draw_section(axes: Axes, zone: LoadingZone, plane: tuple[int, int], loops: list[Array]) -> None:
    from matplotlib.colors import to_rgba
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    if loops:
        codes = [
            np.r_[Outline.MOVETO, np.full(len(loop) - 2, Outline.LINETO), Outline.CLOSEPOLY] for loop in loops
        ]
        outline = Outline(np.concatenate(loops), np.concatenate(codes))
        fill = to_rgba(BLUE, _FILL)
        axes.add_patch(PathPatch(outline, facecolor=fill, edgecolor=VERMILION, linewidth=0.6))
    for place, margin, color, name in (
        (zone.com_mm, zone.s_margin_mm, INK, "given COM"),
        (zone.nearest_best_com_mm, zone.nearest_best_s_margin_mm, GREEN, "nearest best COM (projected)"),
    ):
        center = place[plane[0]], place[plane[1]]
        axes.plot(*center, marker="+", color=color, linestyle="none", label=name)
        _draw_ring(axes, center, margin * np.eye(2), color, linewidth=0.8)
    axes.set(aspect="equal", xlabel=f"{_AXES[plane[0]]} / mm", ylabel=f"{_AXES[plane[1]]} / mm")


def _draw_margins(axes: Axes, zone: LoadingZone) -> None:
    """The S-margin with the COM lowered towards the rest."""
    reach = 0.1 * zone.body.radius_mm
    lowered = np.concatenate([[0.0], np.geomspace(0.02 * reach, reach, 31)])
    axes.plot(lowered, margins_towards_rest(zone, lowered), color=BLUE, marker=".", markersize=3)
    axes.set(xlabel="COM lowered towards the rest / mm", ylabel="S-margin / mm", yscale="log")
    axes.yaxis.set_major_formatter(PLAIN)
    axes.grid(True)
