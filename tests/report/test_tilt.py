"""Tilt against COM error, held against moved censuses; and the histogram of a study."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from gomboc_cad.body import catalog
from gomboc_cad.equilibria import Census, smooth_census
from gomboc_cad.report.style import new_axes
from gomboc_cad.report.tilt import TiltHistogram, TiltSensitivity
from gomboc_cad.report.tilt_figures import plot_tilt, plot_tilt_histogram
from gomboc_cad.tolerance.judging import ROW


@pytest.fixture(scope="module")
def census() -> Census:
    return smooth_census(catalog()["primary"], (-0.411, 0.0, 0.0))


@pytest.fixture(scope="module")
def tilt(census: Census) -> TiltSensitivity:
    assert census.margin is not None
    return TiltSensitivity.of_rest(census.rest, census.margin.s_margin_mm)


def lines_of(ax: object) -> dict[str, np.ndarray]:
    return {str(line.get_label()): np.column_stack(line.get_data()) for line in ax.lines}  # type: ignore[attr-defined]


def test_the_lines_are_what_a_moved_centre_of_mass_does(census: Census, tilt: TiltSensitivity) -> None:
    lines = lines_of(plot_tilt(tilt))
    error_um = 1.0
    for name, direction in (
        ("along the soft direction", census.rest.soft_direction),
        ("along the stiff direction", census.rest.stiff_direction),
    ):
        moved = np.array(census.com_mm) + 1e-3 * error_um * np.array(direction)
        rest = np.array(smooth_census(catalog()["primary"], moved).rest.direction)
        true = np.degrees(np.arcsin(np.linalg.norm(np.cross(rest, census.rest.direction))))
        drawn = np.exp(np.interp(np.log(error_um), *np.log(lines[name]).T))
        assert drawn == pytest.approx(true, rel=0.01)


def test_only_what_is_known_is_drawn(tilt: TiltSensitivity) -> None:
    bare = {name for name in lines_of(plot_tilt(replace(tilt, s_margin_um=None))) if name[0] != "_"}
    assert bare == {"along the soft direction", "along the stiff direction"}
    known = replace(tilt, cone_95_deg=2.4, study_95_deg=2.7, limit_deg=0.5)
    lines = lines_of(plot_tilt(known))
    for name in (
        "95 % cone of the calibration, 2.4°",
        "95 % of the parts of the study, 2.7°",
        "your limit, 0.5°",
    ):
        angle = float(name.rsplit(" ", 1)[1].rstrip("°"))
        np.testing.assert_allclose(lines[name][:, 1], angle)


def test_the_grades_of_sensors_are_marked(tilt: TiltSensitivity) -> None:
    texts = {text.get_text() for text in plot_tilt(tilt).texts}
    assert texts == {"tactical 0.05°", "industrial 1°", "consumer 3°"}


def test_documents_give_what_objects_give(census: Census, tilt: TiltSensitivity) -> None:
    assert census.margin is not None
    verdict = {
        "rest": {"tilt_deg_per_um": list(census.rest.tilt_deg_per_um)},
        "s_margin_mm": census.margin.s_margin_mm,
    }
    assert TiltSensitivity.of_documents(None, verdict) == tilt
    stored = json.loads(json.dumps(tilt.document()))
    assert TiltSensitivity.of_documents(stored) == tilt
    full = TiltSensitivity.of_documents(
        stored, None, {"cone_95_deg": 2.0}, {"tilt_deg": {"p95": 3.0}, "max_tilt_deg": 1.0}
    )
    assert full == replace(tilt, cone_95_deg=2.0, study_95_deg=3.0, limit_deg=1.0)
    assert TiltSensitivity.of_documents(None, {"rest": None}) is None


@pytest.fixture(scope="module")
def histogram() -> TiltHistogram:
    rows = np.zeros(8, ROW)
    rows["tilt_deg"] = (1e-7, 0.5, 0.5, 0.7, 2.0, 90.0, np.nan, np.nan)
    rows["verdict"][6:] = 1, 2
    return TiltHistogram.of_rows(rows)


def test_every_variant_is_in_one_class(histogram: TiltHistogram) -> None:
    assert histogram.variants == 8
    assert histogram.others == 2
    assert histogram.counts.sum() == 6
    assert histogram.counts[0] == 1  # below the first edge
    width = histogram.edges_deg[1:] / histogram.edges_deg[:-1]
    assert width.max() < 2.0
    back = TiltHistogram.of_document(json.loads(json.dumps(histogram.document())))
    np.testing.assert_array_equal(back.counts, histogram.counts)
    np.testing.assert_array_equal(back.edges_deg, histogram.edges_deg)
    assert back.others == 2


def test_the_line_is_the_share_of_all_parts(histogram: TiltHistogram) -> None:
    ax = new_axes(None, (4.0, 3.0))
    assert plot_tilt_histogram(histogram, ax, limit_deg=1.0) is ax
    share = lines_of(ax)["share of all parts below"]
    assert np.interp(1.0, *share.T) == pytest.approx(50.0)
    assert share[-1, 1] == pytest.approx(75.0)
    assert "2 of 8 have several rests or no verdict" in lines_of(ax)


def test_a_study_without_a_good_part_is_drawn() -> None:
    rows = np.zeros(3, ROW)
    rows["verdict"] = 1
    plot_tilt_histogram(TiltHistogram.of_rows(rows))
