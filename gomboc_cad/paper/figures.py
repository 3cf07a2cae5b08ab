"""The figures of the paper, drawn again, with what is true beside what its oracle reads."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from gomboc_cad.equilibria import Census
from gomboc_cad.paper.ballast import SHAPES, ballast_series
from gomboc_cad.paper.bodies import exact_census, spoken, unit_body
from gomboc_cad.report.ballast_figures import plot_ballast
from gomboc_cad.report.body_figures import plot_body
from gomboc_cad.report.landscape import HeightLandscape, height_landscape
from gomboc_cad.report.landscape_figures import plot_height_histogram, plot_landscape
from gomboc_cad.report.style import figure_of, new_figure, styled, write_figure
from gomboc_cad.report.surface_fields import surface_fields

_UNIT = "R₀"


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
    """The primary at rest from three sides, coloured by its deviation from the unit sphere."""
    census = _primary()
    fields = surface_fields(unit_body("primary"), census.com_mm, census.rest)
    write_figure(figure_of(plot_body(fields, unit=_UNIT)), path)


@styled
def draw_landscape(path: Path) -> None:
    """The height of the primary's COM by the direction that points down, and how often each height occurs."""
    landscape = _primary_landscape()
    figure = new_figure(12.0, 4.6)
    grid = figure.add_gridspec(1, 2, width_ratios=(2.0, 1.0))
    plot_landscape(landscape, figure.add_subplot(grid[0], projection="mollweide"), unit=_UNIT)
    plot_height_histogram(landscape, figure.add_subplot(grid[1]), unit=_UNIT)
    write_figure(figure, path)


@styled
def draw_ballast(path: Path) -> None:
    """Count and largest basin of the oracle against ballast, and the true number of rests."""
    figure = new_figure(12.0, 7.0)
    series = [(spoken(name), ballast_series(name)) for name in SHAPES]
    fractions = series[0][1].fractions
    counts, truths, basins, key = (figure.add_subplot(2, 2, place) for place in (1, 2, 3, 4))
    plot_ballast(fractions, [(name, found.ecs) for name, found in series], counts)
    plot_ballast(fractions, [(name, found.rests) for name, found in series], truths)
    plot_ballast(fractions, [(name, found.boa) for name, found in series], basins, counts=False)
    counts.set_title("ECS, as the oracle counts")
    truths.set_title("true number of stable rests")
    basins.set_title("BOA, as the oracle reads it")
    key.axis("off")
    key.legend(*counts.get_legend_handles_labels(), loc="center left", handlelength=4.0, fontsize="medium")
    write_figure(figure, path)


@lru_cache(maxsize=1)
def _primary() -> Census:
    return exact_census(unit_body("primary"))


@lru_cache(maxsize=1)
def _primary_landscape() -> HeightLandscape:
    return height_landscape(_primary())


FIGURES = (
    PaperFigure(
        "paper-body.png",
        "instances",
        "The primary at rest from three sides; colour: deviation from the sphere of radius R₀.",
        draw_body,
    ),
    PaperFigure(
        "paper-landscape.png",
        "instances",
        "The height of the primary's centre of mass over the table: one minimum, one maximum, one basin.",
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
