"""Yields, sensitivities and the allowable form error of a tolerance study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.report.study_records import FormErrorLimits, ProcessYield, Share
from gomboc_cad.report.style import BELOW, BLUE, GREEN, INK, PLAIN, PURPLE, VERMILION, new_axes, styled
from gomboc_cad.tolerance.statistics import Interval, SobolIndex

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ROW_IN, _HEAD_IN = 0.42, 1.5
_NAME_WIDTH = 36


@styled
def plot_yields(
    rows: Sequence[ProcessYield],
    ax: Axes | None = None,
    *,
    target: float | None = None,
    chosen: str | None = None,
) -> Axes:
    """Draw the yields of processes with their intervals, and what undecided variants could add.

    Args:
        rows: The processes, the best first.
        ax: Axes to draw on; new ones if not given.
        target: Share that has to be good.
        chosen: Name of the process that is asked about, which is set off.

    Returns:
        The axes.
    """
    ax = new_axes(ax, (7.4, _HEAD_IN + _ROW_IN * len(rows)))
    places = np.arange(float(len(rows)))
    good = "good: one rest, and within the limit"
    _draw_shares(ax, places - 0.14, [row.good for row in rows], BLUE, "o", good)
    _draw_shares(ax, places + 0.14, [row.monostable for row in rows], GREEN, "s", "one rest")
    if target is not None:
        ax.axvline(100.0 * target, color=VERMILION, linewidth=1.4, label=f"target, {100.0 * target:g} %")
    ax.set_yticks(places, [row.name for row in rows])
    for label, row in zip(ax.get_yticklabels(), rows, strict=True):
        label.set_fontweight("bold" if row.name == chosen else "normal")
    ax.set(xlim=(-1.0, 101.0), ylim=(len(rows) - 0.5, -0.5), xlabel="share of the parts / %")
    ax.grid(True, axis="x")
    ax.legend(**BELOW)
    return ax


def _draw_shares(
    ax: Axes, places: Array, shares: Sequence[Share], color: str, marker: str, name: str
) -> None:
    rows = [(share.estimate, share.low, share.high, share.possible) for share in shares]
    estimate, low, high, possible = 100.0 * np.reshape(rows, (-1, 4)).T
    # What undecided variants could add, where it is wide enough to be seen.
    more = possible - high > 0.05
    ax.hlines(places[more], high[more], possible[more], color=color, linestyle=(0, (1, 1)), linewidth=1.4)
    _draw_whiskers(ax, places, (estimate, low, high), fmt=marker, color=color, markersize=5, label=name)


def _draw_whiskers(ax: Axes, places: Array, ends: tuple[Array, Array, Array], **style: Any) -> None:
    """Draw estimates with their intervals."""
    estimate, low, high = ends
    whiskers = np.maximum(0.0, [estimate - low, high - estimate])
    ax.errorbar(estimate, places, xerr=whiskers, capsize=3, elinewidth=1.4, **style)


@styled
def plot_sobol(
    indices: Sequence[SobolIndex], ax: Axes | None = None, *, names: Mapping[str, str] | None = None
) -> Axes:
    """Draw the share of the variance that each source has alone, and with the others.

    Args:
        indices: Of the sources, in the order of the bars.
        ax: Axes to draw on; new ones if not given.
        names: What the sources are called.

    Returns:
        The axes.
    """
    ax = new_axes(ax, (7.4, _HEAD_IN + _ROW_IN * len(indices)))
    places = np.arange(float(len(indices)))
    for shift, color, name, parts in (
        (-0.19, BLUE, "alone (first order)", [index.first for index in indices]),
        (0.19, PURPLE, "with the others (total)", [index.total for index in indices]),
    ):
        _draw_bars(ax, places + shift, parts, color, name)
    texts = [(names or {}).get(index.source, index.source) for index in indices]
    ax.set_yticks(places, [fill(text, _NAME_WIDTH) for text in texts])
    ax.axvline(0.0, color=INK, linewidth=0.8)
    ax.set(ylim=(len(indices) - 0.5, -0.5), xlabel="share of the variance / %")
    ax.grid(True, axis="x")
    ax.legend(**BELOW)
    return ax


def _draw_bars(ax: Axes, places: Array, parts: Sequence[Interval], color: str, name: str) -> None:
    rows = [(part.estimate, part.low, part.high) for part in parts]
    estimate, low, high = 100.0 * np.reshape(rows, (-1, 3)).T
    ax.barh(places, estimate, 0.36, color=color, alpha=0.75, label=name)
    _draw_whiskers(ax, places, (estimate, low, high), fmt="none", ecolor=INK)


@styled
def plot_form_error(limits: FormErrorLimits, ax: Axes | None = None) -> Axes:
    """Draw the allowable form error against its undulations, with what the process makes.

    Args:
        limits: What is drawn.
        ax: Axes to draw on; new ones if not given.

    Returns:
        The axes.
    """
    ax = new_axes(ax, (7.4, 4.4))
    ax.set(xscale="log", yscale="log")
    degrees = limits.degrees
    share = f"{100.0 * limits.good_share:g} %"
    line: dict[str, Any] = {"linewidth": 1.8, "markersize": 5}
    for amplitude, form, color, name in (
        (limits.allowed_um, "o-", BLUE, f"allowed: {share} of the parts are good with this alone"),
        (limits.guaranteed_um, "s--", GREEN, "guaranteed: no such form adds a rest"),
        (limits.process_um, "^-", VERMILION, "made by the process"),
    ):
        if amplitude is not None:
            # A spectrum ends where it is zero, which has no place on the axis.
            ax.plot(
                degrees, np.where(amplitude > 0.0, amplitude, np.nan), form, color=color, label=name, **line
            )
    if limits.process_um is not None:
        over = limits.process_um > limits.allowed_um
        ax.plot(degrees[over], limits.process_um[over], "o", color=VERMILION, markersize=13, fillstyle="none")
    ax.set_xticks(degrees, [f"{degree}" for degree in degrees])
    ax.minorticks_off()
    ax.yaxis.set_major_formatter(PLAIN)
    ax.grid(True)
    ax.set(xlabel="undulations around the part", ylabel="rms amplitude / µm")
    ax.legend(**BELOW)
    return ax
