"""Studies whose answers are known: yields, percentiles, coverage in closed form; the same bits everywhere."""

from __future__ import annotations

import tracemalloc
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from typing import Any

import numpy as np
import pytest
from scipy.stats import binom, chi
from threadpoolctl import threadpool_info, threadpool_limits

from gomboc_cad.errors import StudyError
from gomboc_cad.tolerance import running
from gomboc_cad.tolerance.judging import COM_ERROR, good_rows, judged_rows
from gomboc_cad.tolerance.requirement import RIGHTS_ITSELF, Requirement
from gomboc_cad.tolerance.sampling import BATCH_ROWS
from gomboc_cad.tolerance.statistics import clopper_pearson
from gomboc_cad.tolerance.study import StudyResult, run_sensitivity, run_study
from gomboc_cad.tolerance.variants import MONOSTABLE
from tests.tolerance.toys import LoadedSphere, Watched

# A ball of COM positions of σ = 0.1 mm per axis in a ball of good places: the chi distribution of 3 degrees.
BALL = LoadedSphere(margin_mm=0.25)
TRUE_YIELD = float(chi(3).cdf(2.5))


def same(a: StudyResult, b: StudyResult) -> bool:
    return a.rows.tobytes() == b.rows.tobytes() and a.yield_tilt == b.yield_tilt and a.tilt_deg == b.tilt_deg


def test_the_yield_of_a_com_ball_in_a_ball_of_good_places() -> None:
    found = run_study(BALL, 20_000, seed=1)
    interval = found.yield_monostable.interval
    assert interval.low < TRUE_YIELD < interval.high
    assert interval.estimate == pytest.approx(TRUE_YIELD, abs=2e-3)
    assert found.yield_tilt == found.yield_monostable
    assert found.com_error_um.p50 == pytest.approx(100.0 * chi(3).median(), rel=5e-3)
    assert found.com_error_um.p95 == pytest.approx(100.0 * chi(3).ppf(0.95), rel=5e-3)
    assert found.s_margin_mm is not None
    assert found.s_margin_mm.count == 20_000
    assert found.s_margin_mm.p05 == 0.0
    assert found.s_margin_mm.p50 == pytest.approx(0.25 - 0.1 * chi(3).median(), rel=5e-3)


def test_the_tilt_of_a_sphere_with_lowered_com() -> None:
    """Errors across alone tilt the rest by the arctangent of a Rayleigh distribution."""
    model = LoadedSphere(lowered_mm=1.0, across_mm=0.1, along_mm=0.0)
    limit = 10.0
    found = run_study(model, 20_000, seed=2, requirement=Requirement(limit))
    assert found.tilt_deg is not None
    assert found.s_margin_mm is not None
    for part, value in ((0.05, found.tilt_deg.p05), (0.5, found.tilt_deg.p50), (0.95, found.tilt_deg.p95)):
        truth = np.degrees(np.arctan(0.1 * chi(2).ppf(part)))
        assert value == pytest.approx(truth, rel=0.01)
    assert found.s_margin_mm.p50 == pytest.approx(np.hypot(1.0, 0.1 * chi(2).median()), rel=1e-4)
    assert found.yield_monostable.interval.estimate == 1.0
    truth = float(chi(2).cdf(10.0 * np.tan(np.radians(limit))))
    assert found.yield_tilt.interval.estimate == pytest.approx(truth, abs=2e-3)


@pytest.mark.parametrize("variants", [1, 700, 4096])
def test_without_tolerances_every_part_is_the_nominal_one(variants: int) -> None:
    model = BALL.scaled({"across": 0.0, "along": 0.0})
    found = run_study(model, variants, seed=3, requirement=Requirement(0.001))
    assert found.yield_monostable.passed == found.yield_tilt.passed == variants
    assert found.yield_tilt.interval.high == 1.0
    assert found.tilt_deg is not None
    assert (found.tilt_deg.largest, found.com_error_um.largest) == (0.0, 0.0)


def test_intervals_from_independent_rows_cover_the_truth_at_their_nominal_rate() -> None:
    """As often as the binomial distribution says of just this truth, which is a little more than 95 %."""
    studies, variants = 400, 512
    intervals = [clopper_pearson(passed, variants) for passed in range(variants + 1)]
    covering = np.array([interval.low <= TRUE_YIELD <= interval.high for interval in intervals])
    rate = binom.pmf(np.flatnonzero(covering), variants, TRUE_YIELD).sum()
    covered = 0
    for seed in range(studies):
        rows = judged_rows(BALL, np.random.default_rng(seed).random((variants, 3)), RIGHTS_ITSELF)
        covered += covering[np.count_nonzero(rows["verdict"] == MONOSTABLE)]
    assert 0.95 <= rate < 0.97
    assert binom.ppf(0.001, studies, rate) <= covered <= binom.ppf(0.999, studies, rate)


def test_intervals_from_sobol_points_never_cover_the_truth_more_rarely() -> None:
    """And a false truth is found out."""
    studies, variants = 400, BATCH_ROWS
    covered = refuted = 0
    for seed in range(studies):
        interval = run_study(BALL, variants, seed).yield_monostable.interval
        covered += interval.low <= TRUE_YIELD <= interval.high
        refuted += not interval.low <= TRUE_YIELD - 0.06 <= interval.high
    assert covered >= binom.ppf(0.001, studies, 0.95)
    assert refuted > 0.9 * studies


def test_more_variants_go_on_where_fewer_ended() -> None:
    few, many = (run_study(BALL, variants, seed=4) for variants in (700, 2000))
    np.testing.assert_array_equal(many.rows[:700], few.rows)


def test_seeds_are_different_samples_and_repeat_themselves() -> None:
    a, b, other = (run_study(BALL, 600, seed) for seed in (5, 5, 6))
    assert same(a, b)
    assert not same(a, other)


@pytest.mark.parametrize("workers", [1, 2, 3])
def test_the_bits_do_not_depend_on_the_executor(workers: int) -> None:
    here = run_study(BALL, 3000, seed=7)
    indices_here = run_sensitivity(BALL, 512, seed=7)
    pool: Executor
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        assert same(run_study(BALL, 3000, seed=7, executor=pool), here)
        assert run_sensitivity(BALL, 512, seed=7, executor=pool) == indices_here
    with ThreadPoolExecutor(workers) as pool:
        assert same(run_study(BALL, 3000, seed=7, executor=pool), here)


def test_linear_algebra_has_one_thread_while_any_batch_is_in_work() -> None:
    with threadpool_limits(2, "blas"):
        before = threadpool_info()
        with ThreadPoolExecutor(2) as pool:
            found = run_study(Watched(), 40 * BATCH_ROWS, seed=1, executor=pool)
        assert threadpool_info() == before
    assert found.rows["stable"].max() == 1


def test_undecided_variants_count_as_bad_and_are_told() -> None:
    model = LoadedSphere(margin_mm=0.2, doubt_mm=0.3)
    found = run_study(model, 4096, seed=8).yield_monostable
    assert found.interval.estimate == pytest.approx(chi(3).cdf(2.0), abs=0.01)
    assert found.undecided == pytest.approx(4096 * chi(3).sf(3.0), rel=0.15)
    assert found.possible == clopper_pearson(found.passed + found.undecided, 4096)


def test_columns_of_undecided_variants_do_not_enter_the_distributions() -> None:
    found = run_study(LoadedSphere(doubt_mm=0.15), 1024, seed=8)
    assert found.tilt_deg is not None
    assert found.s_margin_mm is not None
    assert found.tilt_deg.count == found.s_margin_mm.count == 1024 - found.yield_tilt.undecided
    assert np.isfinite([found.tilt_deg.largest, found.s_margin_mm.mean]).all()
    hopeless = run_study(LoadedSphere(doubt_mm=0.0), 64, seed=8)
    assert hopeless.tilt_deg is hopeless.s_margin_mm is hopeless.dead_zone_deg is None
    assert hopeless.yield_tilt.interval.estimate == 0.0


def test_rolling_resistance_widens_the_rest_by_its_dead_zone() -> None:
    """A sphere with its COM lowered by s stops where s·sin(tilt) is below b, to first order b/s."""
    model = LoadedSphere(lowered_mm=2.0, across_mm=0.0, along_mm=0.0)
    found = run_study(model, 16, seed=9, requirement=Requirement(1.0, rolling_mm=0.02))
    assert found.dead_zone_deg is not None
    assert found.dead_zone_deg.p50 == pytest.approx(np.degrees(np.arcsin(0.01)), rel=1e-4)
    assert found.yield_tilt.passed == 16
    assert run_study(model, 16, seed=9, requirement=Requirement(0.5, rolling_mm=0.02)).yield_tilt.passed == 0


def test_a_sphere_that_rolling_resistance_holds_everywhere_does_not_right_itself() -> None:
    """The largest slope of such a sphere is s: with b above it, it stops wherever it is put."""
    for lowered, stalls in ((0.051, False), (0.049, True)):
        model = LoadedSphere(lowered_mm=lowered, across_mm=0.0, along_mm=0.0)
        found = run_study(model, 8, seed=1, requirement=Requirement(rolling_mm=0.05))
        assert found.may_stall == (8 if stalls else 0)
        assert found.yield_tilt.passed == (0 if stalls else 8)
        assert found.yield_monostable.passed == 8


def test_the_rows_say_which_are_good() -> None:
    requirement = Requirement(6.0, rolling_mm=0.01)
    found = run_study(BALL, 1500, seed=2, requirement=requirement)
    assert good_rows(found.rows, requirement).sum() == found.yield_tilt.passed
    error = np.sqrt(sum(found.rows[name] ** 2 for name in COM_ERROR))
    np.testing.assert_array_equal(error < 250.0, found.rows["verdict"] == 0)


class Recorder(ThreadPoolExecutor):
    """Threads that note how many tasks are not done yet when another comes."""

    def __init__(self) -> None:
        super().__init__(3)
        self.given: list[Future[Any]] = []
        self.most = 0

    def submit(self, *task: Any, **more: Any) -> Future[Any]:
        self.given.append(super().submit(*task, **more))
        self.most = max(self.most, sum(not future.done() for future in self.given))
        return self.given[-1]


def test_few_batches_are_given_out_at_a_time_and_come_back_in_order(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "_IN_FLIGHT", 4)
    with Recorder() as pool:
        there = run_study(LoadedSphere(pause_s=0.01), 30 * BATCH_ROWS, seed=7, executor=pool)
    assert len(pool.given) == 30
    assert pool.most <= 4
    assert there.rows.tobytes() == run_study(LoadedSphere(), 30 * BATCH_ROWS, seed=7).rows.tobytes()


def test_progress_names_every_batch() -> None:
    told: list[str] = []
    run_study(BALL, 1200, seed=1, progress=told.append)
    assert told == ["batch 1 of 3", "batch 2 of 3", "batch 3 of 3"]


def test_a_cancelled_study_stops_at_once() -> None:
    told: list[str] = []
    with pytest.raises(KeyboardInterrupt):
        run_study(BALL, 10**6, seed=1, progress=told.append, cancelled=lambda: len(told) == 2)
    assert len(told) == 2
    slow = LoadedSphere(pause_s=0.3)
    with ThreadPoolExecutor(1) as pool, pytest.raises(KeyboardInterrupt):
        run_study(slow, 10**5, 1, executor=pool, progress=told.append, cancelled=lambda: len(told) > 2)


def test_memory_grows_by_the_bare_rows() -> None:
    """A million variants take 60 MB, of which Python and numpy know 53."""
    variants = 2**17
    tracemalloc.start()
    found = run_study(LoadedSphere(), variants, seed=1)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert found.rows.nbytes == 53 * variants
    assert peak < 2.5 * found.rows.nbytes


def test_senseless_demands_are_refused() -> None:
    with pytest.raises(StudyError, match="not 0"):
        run_study(BALL, 0, seed=1)
    with pytest.raises(StudyError, match="tilt must be above 0"):
        Requirement(0.0)
    with pytest.raises(StudyError, match="tilt must be above 0"):
        Requirement(float("nan"))
    with pytest.raises(StudyError, match="rolling-resistance length"):
        Requirement(1.0, rolling_mm=-1.0)
    with pytest.raises(StudyError, match="power of two"):
        run_sensitivity(BALL, 1000, seed=1)
