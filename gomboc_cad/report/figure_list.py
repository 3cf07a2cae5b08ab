"""Which figures a report has, drawn from its documents alone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from gomboc_cad.errors import InspectionError
from gomboc_cad.hydrostatics.righting import RightingCurve
from gomboc_cad.report.body_figures import Field, plot_body
from gomboc_cad.report.floating_figures import Waterline, plot_righting, plot_waterline
from gomboc_cad.report.landscape import HeightLandscape
from gomboc_cad.report.landscape_figures import plot_landscape
from gomboc_cad.report.study_figures import plot_form_error, plot_sobol, plot_yields
from gomboc_cad.report.study_records import FormErrorLimits, sobol_of_document, yields_of_document
from gomboc_cad.report.style import figure_of, new_figure, styled
from gomboc_cad.report.surface_fields import SurfaceFields
from gomboc_cad.report.tilt import TiltHistogram, TiltSensitivity
from gomboc_cad.report.tilt_figures import plot_tilt, plot_tilt_histogram
from gomboc_cad.report.zone_figures import plot_zone_section
from gomboc_cad.report.zone_section import ZoneSection

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Document = Mapping[str, Any]

_MOST_SOURCES = 10
_BODIES: tuple[tuple[str, str, Field], ...] = (
    ("surface", "its deviation from the sphere", "deviation"),
    ("curvature", "Gaussian curvature", "curvature"),
    ("drill", "the radius allowed to drill", "drill"),
)


class NamedFigure(NamedTuple):
    """A figure of a report.

    Attributes:
        name: Name of its files, without suffix.
        title: What it shows, for those who do not see it.
        figure: The figure.
    """

    name: str
    title: str
    figure: Figure


def report_figures(
    report: Document,
    *,
    verdict: Document | None = None,
    calibration: Document | None = None,
    hydrostatics: Document | None = None,
    tolerance: Document | None = None,
) -> list[NamedFigure]:
    """The figures of a folder; those whose data are not there are left out.

    Args:
        report: `report.json`.
        verdict: `verdict.json`, of a build.
        calibration: `calibration.json`, of a housing.
        hydrostatics: `hydrostatics.json`, of a buoy.
        tolerance: `tolerance.json`, of a study.

    Raises:
        InspectionError: If a document is damaged.
    """
    try:
        tilt = TiltSensitivity.of_documents(report.get("tilt"), verdict, calibration, tolerance)
        return [
            *_pose_figures(report, tilt),
            *_study_figures(report, tolerance or {}),
            *_floating_figures(report, hydrostatics or {}),
        ]
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        raise InspectionError(
            f"A document of the report is damaged ({type(error).__name__}: {error}); build or study again."
        ) from error


def _pose_figures(report: Document, tilt: TiltSensitivity | None) -> Iterator[NamedFigure]:
    """Body, poses, loading zone and tilt."""
    if "surface" in report:
        fields = SurfaceFields.of_document(report["surface"])
        for name, title, field in _BODIES:
            if field != "drill" or fields.drill_radius_mm is not None:
                yield _named(
                    name, f"The body at rest from three sides, coloured by {title}", plot_body(fields, field)
                )
    if "landscape" in report:
        landscape = HeightLandscape.of_document(report["landscape"])
        yield _named("landscape", "Height of the centre of mass over all poses", plot_landscape(landscape))
    if "zone_section" in report:
        figure = _zone_figure(ZoneSection.of_document(report["zone_section"]))
        yield NamedFigure("zone", "Where the centre of mass may be: section of the loading zone", figure)
    if tilt is not None:
        yield _named("tilt", "Tilt of the rest against the error of the centre of mass", plot_tilt(tilt))


@styled
def _zone_figure(section: ZoneSection) -> Figure:
    figure = new_figure(10.6, 5.8)
    whole, close_up = (figure.add_subplot(1, 2, place) for place in (1, 2))
    plot_zone_section(section, whole, whole=True)
    plot_zone_section(section, close_up)
    # The close-up shows all that the other shows.
    both, own = whole.get_legend(), close_up.get_legend()
    assert both is not None
    assert own is not None
    texts = [text.get_text() for text in own.get_texts()]
    handles = [handle for handle in own.legend_handles if handle is not None]
    figure.legend(handles, texts, loc="outside lower center", ncols=4)
    both.remove()
    own.remove()
    return figure


def _study_figures(report: Document, tolerance: Document) -> Iterator[NamedFigure]:
    """What a tolerance study found."""
    if "tilt_histogram" in report:
        histogram = TiltHistogram.of_document(report["tilt_histogram"])
        drawn = plot_tilt_histogram(histogram, limit_deg=tolerance.get("max_tilt_deg"))
        yield _named("tilts", "Tilts of the parts of the study", drawn)
    if "yield_tilt" in tolerance:
        rows = yields_of_document(tolerance)
        drawn = plot_yields(rows, target=tolerance.get("good_share"), chosen=tolerance.get("process"))
        yield _named("yields", "Share of good parts by process", drawn)
    if tolerance.get("sobol"):
        texts = {source["name"]: source["text"] for source in tolerance.get("sources", ())}
        indices = sobol_of_document(tolerance["sobol"])[:_MOST_SOURCES]
        yield _named("sobol", "Sources of the scatter of the tilt", plot_sobol(indices, names=texts))
    if tolerance.get("form_error"):
        drawn = plot_form_error(FormErrorLimits.of_document(tolerance["form_error"]))
        yield _named("form-error", "Allowable form error against its undulations", drawn)


def _floating_figures(report: Document, hydrostatics: Document) -> Iterator[NamedFigure]:
    """How a buoy floats."""
    if "righting" not in hydrostatics:
        return
    curve = RightingCurve.of_document(hydrostatics["righting"])
    yield _named("righting", "Righting arms against the heel", plot_righting(curve))
    if "surface" in report:
        positions = SurfaceFields.of_document(report["surface"]).positions_mm
        floating = Waterline.of_document(hydrostatics, positions)
        yield _named("floating", "The part afloat, from the side", plot_waterline(floating))


def _named(name: str, title: str, ax: Axes) -> NamedFigure:
    return NamedFigure(name, title, figure_of(ax))
