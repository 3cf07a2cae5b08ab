"""One look for all figures, without a screen and with the same bytes each time.

The ground is transparent. Text and lines are drawn so that they can be read on white and on the near-black
`DARK` alike. No colour has a contrast of 4.5 (WCAG 2.2, 1.4.3) to both, since those two are only 18.6 apart,
so the ink lies in the middle, where it has 4.3 to each; in an SVG it is replaced by the colour of the text
around it. The colours of lines have 3 to both (1.4.11). They are those of Okabe and Ito and a purple that is
apart from them, and from the ink, under all three kinds of colour blindness.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from gomboc_cad.errors import OutputError
from gomboc_cad.solid.output import write_bytes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

P = ParamSpec("P")
R = TypeVar("R")

FORMATS = ("png", "svg")
LIGHT, DARK = "#ffffff", "#111318"
INK = "#7a7a7a"
BLUE, VERMILION, GREEN, PURPLE = "#0072b2", "#d55e00", "#009e73", "#9a4fd8"
LINES = (BLUE, VERMILION, GREEN, PURPLE)
"""Colours of lines, each of which can be told from the others and from both grounds."""

HEIGHTS, DEVIATIONS = "viridis", "RdBu_r"
"""Colour maps of one-sided and of signed quantities."""

MARK: dict[str, Any] = {"markerfacecolor": "white", "markeredgecolor": "black", "linestyle": "none"}
"""Marks on a coloured ground."""

PLAIN = "{x:g}"
"""Numbers at a logarithmic axis."""

BELOW: dict[str, Any] = {
    "loc": "upper center",
    "bbox_to_anchor": (0.5, 0.0),
    "borderaxespad": 4.8,
    "ncols": 2,
}
"""Where a legend goes: below the label of the x-axis, however high the axes are."""

_DPI = 150
_STYLE: Any = {
    "figure.facecolor": "none",
    "savefig.facecolor": "none",
    "axes.facecolor": "none",
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.titlesize": "medium",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "grid.color": INK,
    "grid.alpha": 0.3,
    "font.family": ["DejaVu Sans"],
    "font.size": 10.0,
    "legend.facecolor": "none",
    "legend.edgecolor": "none",
    "legend.framealpha": 0.0,
    "legend.fontsize": "small",
}
# Dates, versions and addresses would be in every SVG.
_SVG_METADATA = dict.fromkeys(("Date", "Creator", "Format", "Type"))
_PNG_METADATA = {"Software": None}
_OWN_INK = "<style>svg{color:#3b3b3b}@media(prefers-color-scheme:dark){svg{color:#d4d4d4}}</style>"


def styled(draw: Callable[P, R]) -> Callable[P, R]:
    """Draw in the style of this package, whatever that of the caller is."""

    @wraps(draw)
    def in_style(*args: P.args, **kwargs: P.kwargs) -> R:
        from matplotlib import rc_context

        with rc_context(_STYLE):
            return draw(*args, **kwargs)

    return in_style


@styled
def new_figure(width_in: float, height_in: float) -> Figure:
    """Make an empty figure, which no screen and no global state knows of; matplotlib is loaded only now."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width_in, height_in), layout="constrained")


@styled
def new_axes(ax: Axes | None, size_in: tuple[float, float], projection: str = "rectilinear") -> Axes:
    """Give the axes to draw on: those given, or new ones alone in a figure.

    Raises:
        ValueError: If those given have another projection.
    """
    if ax is None:
        return new_figure(*size_in).add_subplot(projection=projection)
    if ax.name != projection:
        raise ValueError(f"This figure needs axes with projection={projection!r}, not {ax.name!r}.")
    return ax


def figure_of(ax: Axes) -> Figure:
    """The figure that axes are in."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    return figure


def figure_format(path: Path) -> str:
    """Tell the format of a figure by its suffix; asked before a figure that takes long to draw.

    Raises:
        OutputError: If it is neither PNG nor SVG.
    """
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise OutputError(f"{path.name}: figures are written as .png or .svg; change the suffix.")
    return kind


def write_figure(figure: Figure, path: Path) -> None:
    """Write a figure as PNG or SVG, by the suffix, whole or not at all.

    Raises:
        OutputError: If the suffix is another one, or the file cannot be written.
    """
    write_bytes(path, figure_bytes(figure, figure_format(path)))


def figure_bytes(figure: Figure, kind: str) -> bytes:
    """A figure as a PNG or SVG file."""
    if kind == "svg":
        opening, rest = _svg(figure, "figure", "none").split(">", 1)
        return f'<?xml version="1.0" encoding="utf-8"?>\n{opening}>{_OWN_INK}{rest}'.encode()
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=_DPI, metadata=_PNG_METADATA)
    return stream.getvalue()


def svg_text(figure: Figure, name: str) -> str:
    """A figure as an element of a page, in the colour of the text around it; its text is drawn as outlines.

    Args:
        figure: The figure.
        name: What its identifiers begin with, so that several figures go into one page.
    """
    return _svg(figure, name, "path")


@styled
def _svg(figure: Figure, name: str, fonts: str) -> str:
    from matplotlib import rc_context

    stream = io.StringIO()
    # Without a salt the identifiers are random.
    with rc_context({"svg.hashsalt": name, "svg.fonttype": fonts}):
        figure.savefig(stream, format="svg", dpi=_DPI, metadata=_SVG_METADATA)
    text = stream.getvalue()
    text = text[text.index("<svg") :].replace(INK, "currentColor")
    return re.sub(r'(\bid="|url\(#|href="#)', rf"\g<1>{name}-", text)
