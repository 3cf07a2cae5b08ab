"""Yields, sensitivities and form errors: drawn where they are, of objects and of documents alike."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import pytest

from gomboc_cad.report.ballast_figures import plot_ballast
from gomboc_cad.report.study_figures import plot_sobol, plot_yields
from gomboc_cad.report.study_records import (
    FormErrorLimits,
    ProcessYield,
    Share,
    sobol_of_document,
    yields_of_document,
)
from gomboc_cad.report.style import new_axes
from gomboc_cad.tolerance.acceptance import Checked, Rows, Target
from gomboc_cad.tolerance.allowable import FormErrorCurve
from gomboc_cad.tolerance.comparison import ProcessRow
from gomboc_cad.tolerance.judging import ROW
from gomboc_cad.tolerance.requirement import Requirement
from gomboc_cad.tolerance.statistics import Interval, SobolIndex, Yield
from gomboc_cad.tolerance.study import Sensitivity, StudyResult, concluded


def study(good: int, undecided: int, others: int) -> StudyResult:
    """A study with so many good parts, parts without a verdict and parts with two rests."""
    rows = np.zeros(good + undecided + others, ROW)
    rows["verdict"][good : good + undecided] = 2
    rows["verdict"][good + undecided :] = 1
    rows["s_margin_mm"], rows["tilt_deg"], rows["dead_zone_deg"] = 0.1, 0.2, 0.1
    return concluded((), 0, Requirement(1.0, 0.001), rows)


def round_trip(document: Mapping[str, Any]) -> Any:
    return json.loads(json.dumps(document))


def test_a_row_of_a_comparison_is_drawn_from_its_document_as_from_itself() -> None:
    row = ProcessRow("milled", study(60, 20, 20), None, None)
    (read,) = yields_of_document({"processes": [round_trip(row.document())]})
    assert read == ProcessYield.of_row(row)
    assert read.good == Share.of_yield(Yield(60, 20, 100))
    assert read.good.high < 0.8 < read.good.possible


def test_a_study_alone_has_one_row() -> None:
    document = {
        "process": "sla",
        "yield_monostable": {**asdict(Interval(0.9, 0.8, 0.95)), "high_if_undecided_pass": 0.97},
        "yield_tilt": asdict(Interval(0.5, 0.4, 0.6)),
    }
    (row,) = yields_of_document(round_trip(document))
    assert row == ProcessYield("sla", Share(0.9, 0.8, 0.95, 0.97), Share(0.5, 0.4, 0.6, 0.6))


def test_yields_are_drawn_in_percent_with_their_intervals() -> None:
    rows = [ProcessYield.of_study(name, study(good, 20, 80 - good)) for name, good in (("a", 60), ("b", 10))]
    ax = plot_yields(rows, target=0.95, chosen="b")
    good, monostable = ax.containers
    for container, shares in ((good, [r.good for r in rows]), (monostable, [r.monostable for r in rows])):
        points, _, (whiskers,) = container
        np.testing.assert_allclose(points.get_xdata(), [100.0 * share.estimate for share in shares])
        ends = [sorted(segment[:, 0]) for segment in whiskers.get_segments()]
        np.testing.assert_allclose(ends, [[100.0 * share.low, 100.0 * share.high] for share in shares])
    labels = ax.get_yticklabels()
    assert [label.get_text() for label in labels] == ["a", "b"]
    assert [label.get_fontweight() for label in labels] == ["normal", "bold"]
    (target,) = (line for line in ax.lines if line.get_label() == "target, 95 %")
    np.testing.assert_allclose(target.get_xdata(), 95.0)


def test_undecided_parts_are_drawn_as_what_they_could_add() -> None:
    row = ProcessYield.of_study("a", study(60, 20, 20))
    dotted = [c for c in plot_yields([row]).collections if "container" not in str(c.get_label())]
    spans = [segment[:, 0] for collection in dotted for segment in collection.get_segments()]
    assert any(np.allclose(span, [100.0 * row.good.high, 100.0 * row.good.possible]) for span in spans)


INDICES = (
    SobolIndex("form_error", Interval(0.2, 0.1, 0.3), Interval(0.3, 0.2, 0.4)),
    SobolIndex("payload", Interval(0.6, 0.5, 0.7), Interval(0.7, 0.6, 0.8)),
)


def test_indices_are_read_as_they_are_written() -> None:
    assert sobol_of_document(round_trip({"sobol": [asdict(i) for i in INDICES]})["sobol"]) == INDICES


def test_bars_are_as_long_as_the_indices() -> None:
    ax = plot_sobol(INDICES, names={"payload": "mass of the payload"})
    bars = sorted(ax.patches, key=lambda bar: bar.get_y())
    assert [round(bar.get_width()) for bar in bars] == [20, 30, 60, 70]
    assert [label.get_text() for label in ax.get_yticklabels()] == ["form_error", "mass of the payload"]


def test_a_sensitivity_draws_the_largest_first() -> None:
    ax = new_axes(None, (4.0, 3.0))
    found = Sensitivity(samples=8, seed=0, undecided=0, tilt_deg=INDICES, s_margin_mm=INDICES)
    assert found.plot(ax) is ax
    assert [label.get_text() for label in ax.get_yticklabels()] == ["payload", "form_error"]


@pytest.fixture
def curve() -> FormErrorCurve:
    share = Interval(0.99, 0.97, 1.0)
    found = ((2e-3, True), (1e-3, True), (0.0, False))
    return FormErrorCurve(
        degrees=np.array([2, 4, 8]),
        guaranteed_mm=np.array([5e-4, 2e-4, 1e-4]),
        probable=tuple(Checked(value, met, share, Rows(0, 100)) for value, met in found),
        target=Target(Requirement(1.0), 0.95),
        process_mm=np.array([4e-3, 5e-4, 0.0]),
    )


def test_form_errors_are_read_as_they_are_written(curve: FormErrorCurve) -> None:
    direct, read = (
        FormErrorLimits.of_curve(curve),
        FormErrorLimits.of_document(round_trip(curve.document())),
    )
    for name in ("degrees", "guaranteed_um", "allowed_um", "process_um"):
        np.testing.assert_allclose(getattr(read, name), getattr(direct, name))
    assert read.good_share == 0.95
    assert np.isnan(read.allowed_um[2])
    nothing_made = round_trip(curve.document())
    for row in nothing_made["degrees"]:
        row["process_um"] = None
    assert FormErrorLimits.of_document(nothing_made).process_um is None


def test_a_form_error_beyond_the_allowed_one_is_ringed(curve: FormErrorCurve) -> None:
    ax = new_axes(None, (4.0, 3.0))
    assert curve.plot(ax) is ax
    lines = {str(line.get_label()): line for line in ax.lines}
    made = lines["made by the process"].get_ydata()
    np.testing.assert_allclose(made, [4.0, 0.5, np.nan])
    (ring,) = (line for line in ax.lines if line.get_fillstyle() == "none")
    np.testing.assert_allclose(np.column_stack(ring.get_data()), [[2.0, 4.0]])


def test_a_study_draws_its_yield_and_its_tilts() -> None:
    result = study(60, 20, 20)
    for plot in (result.plot_yield, result.plot_tilt):
        ax = new_axes(None, (4.0, 3.0))
        assert plot(ax) is ax
    assert any("limit" in str(line.get_label()) for line in ax.lines)


def test_bodies_against_ballast_are_drawn_as_given() -> None:
    fractions, counts = (0.0, 0.1, 0.2), (("cube", (6, 6, 5)), ("ball", (1, 1, 1)))
    ax = plot_ballast(fractions, counts)
    assert {line.get_label(): tuple(line.get_ydata()) for line in ax.lines} == dict(counts)
    shares = plot_ballast(fractions, [("cube", (0.2, 0.3, 0.4))], counts=False)
    assert shares.get_yscale() == "linear"
