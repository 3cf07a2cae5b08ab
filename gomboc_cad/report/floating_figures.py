"""How a part floats: the waterline with its centres, and the curve of righting arms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from scipy.spatial import ConvexHull

from gomboc_cad.body.sphere import Array, unit
from gomboc_cad.hydrostatics.righting import RightingCurve
from gomboc_cad.report.style import BELOW, BLUE, GREEN, INK, PURPLE, VERMILION, new_axes, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class Waterline:
    """A floating part seen from the side along its easier heel axis; lengths are in mm over the water.

    Attributes:
        outline_mm: What is seen of the outer surface, to the right from the COM and upwards, shape (n, 2).
        water: Name of the water.
        com_mm: Height of the COM.
        buoyancy_mm: Height of the centre of buoyancy.
        metacentre_mm: Height of the metacentre for the easier heel axis.
    """

    outline_mm: Array
    water: str
    com_mm: float
    buoyancy_mm: float
    metacentre_mm: float

    @classmethod
    def of_document(cls, hydrostatics: Mapping[str, Any], positions_mm: Array) -> Self:
        """Of `hydrostatics.json`, and of points of the outer surface, shape (n, 3)."""
        upright, com = hydrostatics["upright"], np.array(hydrostatics["com_mm"], dtype=float)
        up = unit(np.array(upright["up"], dtype=float))
        heights = positions_mm @ up
        level = float(heights.min()) + float(upright["draft_mm"])
        axis = np.array(hydrostatics["righting"]["axes"][0], dtype=float)
        seen = np.stack([(positions_mm - com) @ np.cross(up, axis), heights - level], axis=-1)
        buoyancy = float(np.dot(upright["center_of_buoyancy_mm"], up)) - level
        return cls(
            outline_mm=seen[ConvexHull(seen).vertices],
            water=str(hydrostatics["water"]["name"]),
            com_mm=float(com @ up) - level,
            buoyancy_mm=buoyancy,
            metacentre_mm=buoyancy + float(upright["bm_mm"][0]),
        )


@styled
def plot_waterline(floating: Waterline, ax: Axes | None = None) -> Axes:
    """Draw a floating part from the side: the water, the COM, the centre of buoyancy and the metacentre.

    Args:
        floating: What is drawn.
        ax: Axes to draw on; new ones if not given.

    Returns:
        The axes.
    """
    ax = new_axes(ax, (5.4, 5.4))
    x, y = floating.outline_mm.T
    reach = 1.25 * float(np.abs(x).max())
    low = 1.12 * float(y.min())
    ax.fill_between([-reach, reach], low, 0.0, color=BLUE, alpha=0.2, linewidth=0.0, label=floating.water)
    ax.plot([-reach, reach], [0.0, 0.0], color=BLUE, linewidth=1.4)
    ax.fill(x, y, facecolor="none", edgecolor=INK, linewidth=1.6)
    for height, color, mark, name in (
        (floating.metacentre_mm, GREEN, "^", "metacentre M (easier heel)"),
        (floating.com_mm, VERMILION, "o", "centre of mass G"),
        (floating.buoyancy_mm, PURPLE, "v", "centre of buoyancy B"),
    ):
        text = f"{name}, {height:+.3g} mm"
        ax.plot(0.0, height, mark, color=color, markersize=8, linestyle="none", label=text)
    ax.axvline(0.0, color=INK, linewidth=0.6, linestyle=(0, (2, 3)))
    ax.set(aspect="equal", xlim=(-reach, reach), ylim=(low, 1.08 * float(y.max())))
    ax.set(xlabel="across / mm", ylabel="height over the water / mm")
    ax.legend(**BELOW)
    return ax


@styled
def plot_righting(curve: RightingCurve, ax: Axes | None = None) -> Axes:
    """Draw the righting arms against the angle of heel.

    Args:
        curve: What is drawn.
        ax: Axes to draw on; new ones if not given.

    Returns:
        The axes.
    """
    ax = new_axes(ax, (7.4, 4.0))
    lines = (("about the easier axis", BLUE, "solid"), ("about the other axis", GREEN, (0, (5, 2))))
    for arms, (name, color, style) in zip(curve.righting_arm_mm, lines, strict=True):
        ax.plot(curve.heel_deg, arms, color=color, linestyle=style, linewidth=1.8, label=name)
    ax.axhline(0.0, color=INK, linewidth=1.0)
    ax.grid(True)
    ax.set(xlim=(0.0, 180.0), xticks=range(0, 181, 30), xlabel="heel / °", ylabel="righting arm GZ / mm")
    ax.legend(**BELOW)
    return ax
