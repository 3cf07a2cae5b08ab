"""The loading zone in sections through the centre of mass, and the margin along the way to the rest."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gomboc_cad.body.sphere import Array, IntArray, fibonacci_directions
from gomboc_cad.equilibria.zone import LoadingZone, margins_towards_rest
from gomboc_cad.report.canvas import figure_format, new_figure, write_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_AXES = "xyz"
_PLANES = ((0, 1), (0, 2), (1, 2))
_CLOSE_UP = 8.0
"""Half the width of the close-ups, in S-margins of the given COM or of the nearest best one."""

_ZONE, _FORBIDDEN, _GIVEN, _BEST = "#cfe3f4", "#b3432f", "#1a1a1a", "#1b7a3d"


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
    figure.axes[0].legend(loc="lower left", fontsize="small")
    _draw_margins(figure.add_subplot(grid[2, :]), zone)
    figure.suptitle(
        f"{zone.body.name}: COM positions with one stable rest (blue); margin {zone.s_margin_mm:.3g} mm at "
        f"the given COM, {zone.nearest_best_s_margin_mm:.3g} mm at the nearest best one"
    )
    write_figure(figure, path)


def section_loops(
    vertices_mm: Array, faces: IntArray, point_mm: Array, plane: tuple[int, int]
) -> list[Array]:
    """Cut a closed mesh by a coordinate plane through a point.

    Args:
        vertices_mm: Shape (n, 3).
        faces: Outward oriented triangles, shape (m, 3).
        point_mm: A point of the plane, shape (3,).
        plane: The two axes that span it.

    Returns:
        Closed loops in those axes, shape (k, 2) each; outer ones turn against holes.
    """
    normal = 3 - sum(plane)
    height = vertices_mm[:, normal] - point_mm[normal]
    above = height >= 0.0
    start, end = faces, np.roll(faces, -1, axis=1)
    rising, falling = ~above[start] & above[end], above[start] & ~above[end]
    # A face that is cut has one rising and one falling edge, which are falling and rising in its neighbours.
    cut = rising.any(axis=1)
    entry, leave = (_edge_keys(start, end, kind, cut, len(vertices_mm)) for kind in (rising, falling))
    following = dict(zip(entry.tolist(), leave.tolist(), strict=True))
    loops = []
    while following:
        first, key = following.popitem()
        keys = [first, key]
        while key != first:
            key = following.pop(key)
            keys.append(key)
        low, high = np.divmod(np.array(keys), len(vertices_mm))
        share = height[low] / (height[low] - height[high])
        points = vertices_mm[low] + share[:, None] * (vertices_mm[high] - vertices_mm[low])
        loops.append(points[:, list(plane)])
    return loops


def _edge_keys(start: IntArray, end: IntArray, kind: Array, cut: Array, count: int) -> IntArray:
    """Key of the edge of one kind in each face that is cut, the same seen from both its faces."""
    place = kind[cut].argmax(axis=1)[:, None]
    ends = (np.take_along_axis(part[cut], place, axis=1)[:, 0] for part in (start, end))
    a, b = ends
    result: IntArray = np.minimum(a, b) * count + np.maximum(a, b)
    return result


def _draw_section(axes: Axes, zone: LoadingZone, plane: tuple[int, int], loops: list[Array]) -> None:
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    if loops:
        codes = [
            np.r_[Outline.MOVETO, np.full(len(loop) - 2, Outline.LINETO), Outline.CLOSEPOLY] for loop in loops
        ]
        outline = Outline(np.concatenate(loops), np.concatenate(codes))
        axes.add_patch(PathPatch(outline, facecolor=_ZONE, edgecolor=_FORBIDDEN, linewidth=0.6))
    for place, margin, color, name in (
        (zone.com_mm, zone.s_margin_mm, _GIVEN, "given COM"),
        (zone.nearest_best_com_mm, zone.nearest_best_s_margin_mm, _BEST, "nearest best COM (projected)"),
    ):
        _draw_ball(axes, [place[axis] for axis in plane], margin, color, name)
    axes.set(aspect="equal", xlabel=f"{_AXES[plane[0]]} / mm", ylabel=f"{_AXES[plane[1]]} / mm")


def _draw_ball(axes: Axes, center: list[float], radius: float, color: str, name: str) -> None:
    from matplotlib.patches import Circle

    axes.plot(*center, marker="+", color=color, linestyle="none", label=name)
    axes.add_patch(Circle((center[0], center[1]), radius, fill=False, color=color, linewidth=0.8))


def _draw_margins(axes: Axes, zone: LoadingZone) -> None:
    """The S-margin with the COM lowered towards the rest."""
    reach = 0.1 * zone.body.radius_mm
    lowered = np.concatenate([[0.0], np.geomspace(0.02 * reach, reach, 31)])
    axes.plot(lowered, margins_towards_rest(zone, lowered), color=_GIVEN, marker=".", markersize=3)
    axes.set(xlabel="COM lowered towards the rest / mm", ylabel="S-margin / mm", yscale="log")
    axes.grid(True, alpha=0.3)
