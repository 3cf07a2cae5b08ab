"""Bodies against ballast: what is counted on them as their COM is lowered."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from gomboc_cad.report.style import BLUE, GREEN, INK, PURPLE, VERMILION, new_axes, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LINES: tuple[dict[str, Any], ...] = (
    {"color": GREEN, "linewidth": 2.4, "zorder": 3},
    {"color": BLUE, "linestyle": (0, (4, 4)), "zorder": 4},
    {"color": PURPLE},
    {"color": INK, "linestyle": (0, (1, 3)), "linewidth": 2.4, "zorder": 5},
    {"color": VERMILION},
    {"color": INK, "linestyle": (0, (6, 2))},
)
"""Dashed and dotted, since lines lie on each other."""


@styled
def plot_ballast(
    fractions: Sequence[float],
    values: Sequence[tuple[str, Sequence[float]]],
    ax: Axes | None = None,
    *,
    counts: bool = True,
) -> Axes:
    """Draw a quantity of several bodies against the ballast fraction.

    Args:
        fractions: Parts of the way that the COM is moved towards the lowest point.
        values: Name of each body and its values, at most six bodies.
        ax: Axes to draw on; new ones if not given.
        counts: Whether the values are numbers of rests, or shares.

    Returns:
        The axes.
    """
    ax = new_axes(ax, (6.0, 3.6))
    for (name, series), line in zip(values, _LINES, strict=False):
        ax.plot(fractions, series, label=name, **{"linewidth": 1.8, **line})
    if counts:
        ax.set(yscale="symlog", ylim=(-0.2, 60.0), yticks=(0, 1, 2, 3, 6, 10, 20, 50))
        ax.yaxis.set_major_formatter("{x:g}")
    else:
        ax.set_ylim(0.0, 1.05)
    ax.set_xlabel("ballast fraction w")
    ax.grid(True)
    return ax
