"""Processes in one table, against closed forms."""

from __future__ import annotations

import pytest
from scipy.stats import chi

from gomboc_cad.tolerance.acceptance import Target
from gomboc_cad.tolerance.comparison import compare_processes
from gomboc_cad.tolerance.requirement import Requirement
from tests.tolerance.margin_ball import MarginBall

SURE = float(chi(3).ppf(0.95))
PROCESSES = {
    "coarse": MarginBall({"payload": 0.05, "shell": 0.5}),
    "precise": MarginBall({"payload": 0.05, "shell": 0.01}),
    "middle": MarginBall({"payload": 0.05, "shell": 0.1}),
}


def test_the_table_has_the_true_yields_and_the_highest_comes_first() -> None:
    rows = compare_processes(PROCESSES, Target(Requirement()))
    assert [row.process for row in rows] == ["precise", "middle", "coarse"]
    for row in rows:
        found = row.result.yield_tilt.interval
        assert found.low < PROCESSES[row.process].true_yield < found.high


def test_the_dominating_source_is_that_which_uses_most_of_what_it_may_have_alone() -> None:
    rows = {row.process: row for row in compare_processes(PROCESSES, Target(Requirement()), variants=512)}
    for name, source, size in (
        ("coarse", "shell", 0.5),
        ("middle", "shell", 0.1),
        ("precise", "payload", 0.05),
    ):
        assert rows[name].dominating == source
        assert rows[name].use == pytest.approx(size * SURE / 0.2, rel=0.2)


def test_a_design_that_is_not_good_is_no_fault_of_a_source() -> None:
    models = {"any": MarginBall({"payload": 0.1}, margin_mm=0.0)}
    (row,) = compare_processes(models, Target(Requirement()), variants=512)
    assert row.dominating is None
    assert row.use is None
    assert row.result.yield_tilt.passed == 0
    document = row.document()
    assert document["tilt_deg"] is None
    assert document["yield_tilt"]["high"] < 0.01


def test_a_source_that_is_never_good_alone_dominates_without_a_figure() -> None:
    models = {"any": MarginBall({"payload": 1e9})}
    (row,) = compare_processes(models, Target(Requirement()), variants=512)
    assert row.dominating == "payload"
    assert row.use is None
