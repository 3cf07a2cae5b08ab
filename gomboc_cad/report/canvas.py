"""Matplotlib without a screen, and figures that are the same bytes each time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gomboc_cad.errors import OutputError
from gomboc_cad.solid.output import atomic_path

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("png", "svg")
_DATELESS = {"png": {"Software": None}, "svg": {"Date": None}}


def new_figure(width_in: float, height_in: float) -> Figure:
    """Make an empty figure; matplotlib is loaded only now."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width_in, height_in), layout="constrained")


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
    from matplotlib import rc_context

    kind = figure_format(path)
    # Without a salt the identifiers inside an SVG are random.
    with rc_context({"svg.hashsalt": "gomboc-cad"}), atomic_path(path) as part:
        figure.savefig(part, format=kind, dpi=150, metadata=_DATELESS[kind])
