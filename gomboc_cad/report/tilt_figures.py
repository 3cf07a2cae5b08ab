"""Tilt against the error of the COM, and the tilts of the parts of a study."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gomboc_cad.report.style import BELOW, BLUE, GREEN, INK, PLAIN, PURPLE, VERMILION, new_axes, styled
from gomboc_cad.report.tilt import GRADES, TiltHistogram, TiltSensitivity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ERRORS_UM = (0.1, 1000.0)
_CUT = 0.002
"""Share of the parts with the smallest and the largest tilts that the axis need not reach."""

_LEAST_DEG, _MOST_DEG = 1e-4, 90.0


@styled
def plot_tilt(tilt: TiltSensitivity, ax: Axes | None = None) -> Axes:
    """Draw the tilt of the rest against the error of the COM, with the limits that it is compared with.

    Args:
        tilt: What is drawn.
        ax: Axes to draw on; new ones if not given.

    Returns:
        The axes.
    """
    ax = new_axes(ax, (7.4, 4.4))
    low, high = _ERRORS_UM
    high = max(high, 1.5 * (tilt.s_margin_um or 0.0))
    ax.set(xscale="log", yscale="log", xlim=(low, high), ylim=(_LEAST_DEG, _MOST_DEG))
    errors = np.geomspace(low, high, 61)
    soft, stiff = (np.degrees(np.arctan(np.radians(rate) * errors)) for rate in tilt.tilt_deg_per_um)
    ax.fill_between(errors, stiff, soft, color=BLUE, alpha=0.2, linewidth=0.0)
    ax.plot(errors, soft, color=BLUE, linewidth=1.8, label="along the soft direction")
    ax.plot(errors, stiff, color=GREEN, linewidth=1.8, label="along the stiff direction")
    _draw_grades(ax)
    for value, color, style, name in (
        (tilt.cone_95_deg, PURPLE, (0, (4, 2)), "95 % cone of the calibration"),
        (tilt.study_95_deg, VERMILION, (0, (1, 1)), "95 % of the parts of the study"),
        (tilt.limit_deg, VERMILION, "solid", "your limit"),
    ):
        if value is not None:
            ax.axhline(value, color=color, linestyle=style, linewidth=1.6, label=f"{name}, {value:.3g}°")
    if tilt.s_margin_um is not None:
        margin = (
            f"{1e-3 * tilt.s_margin_um:.3g} mm" if tilt.s_margin_um >= 1e3 else f"{tilt.s_margin_um:.3g} µm"
        )
        text = f"S-margin, {margin}: beyond it other rests"
        ax.axvline(tilt.s_margin_um, color=INK, linewidth=1.4, linestyle=(0, (6, 2, 1, 2)), label=text)
    ax.set(xlabel="error of the centre of mass / µm", ylabel="tilt of the rest / °")
    ax.xaxis.set_major_formatter(PLAIN)
    ax.yaxis.set_major_formatter(PLAIN)
    ax.legend(**BELOW)
    return ax


@styled
def plot_tilt_histogram(
    histogram: TiltHistogram, ax: Axes | None = None, *, limit_deg: float | None = None
) -> Axes:
    """Draw how many parts of a study tilt by how much, and the share that stays below each tilt.

    Args:
        histogram: What is drawn.
        ax: Axes to draw on; new ones if not given.
        limit_deg: The user's limit.

    Returns:
        The axes.
    """
    ax = new_axes(ax, (7.4, 4.0))
    edges, counts, total = histogram.edges_deg, histogram.counts, max(1, histogram.variants)
    first, last = np.searchsorted(np.cumsum(counts), np.array([_CUT, 1.0 - _CUT]) * counts.sum())
    shown = edges[max(0, first - 1)], edges[min(len(edges) - 1, last + 3)]
    ax.set(xscale="log", xlim=shown, ylim=(0.0, 102.0))
    shares, parts = 100.0 * counts / max(1, counts.max(initial=0)), "parts (tallest class: 100)"
    ax.stairs(shares, edges, fill=True, color=BLUE, alpha=0.3, label=parts)
    below = 100.0 * np.cumsum(counts) / total
    ax.plot(edges[1:], below, color=BLUE, linewidth=1.8, label="share of all parts below")
    _draw_grades(ax, upright=True)
    if limit_deg is not None:
        ax.axvline(limit_deg, color=VERMILION, linewidth=1.6, label=f"your limit, {limit_deg:.3g}°")
    if histogram.others:
        top = 100.0 * (1.0 - histogram.others / total)
        text = f"{histogram.others} of {histogram.variants} have several rests or no verdict"
        ax.axhline(top, color=INK, linewidth=0.8, linestyle=(0, (1, 2)), label=text)
    ax.set(xlabel="tilt of the rest / °", ylabel="%")
    ax.xaxis.set_major_formatter(PLAIN)
    ax.legend(**BELOW)
    return ax


def _draw_grades(ax: Axes, upright: bool = False) -> None:
    """Thin lines at the grades of sensors, with their names."""
    style: dict[str, Any] = {"color": INK, "linewidth": 0.8, "linestyle": (0, (2, 2))}
    for name, angle in GRADES:
        text = f"{name} {angle:g}°"
        if upright:
            ax.axvline(angle, **style)
            across = ax.get_xaxis_transform()
            beside: dict[str, Any] = {"rotation": 90, "ha": "right", "va": "top", "clip_on": True}
            ax.text(angle, 0.98, text, fontsize="x-small", transform=across, **beside)
        else:
            ax.axhline(angle, **style)
            ax.text(0.01, angle, text, fontsize="x-small", transform=ax.get_yaxis_transform(), va="bottom")
