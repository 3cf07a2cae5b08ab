"""Executors by name, and workers that die in the midst of a study."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType

import pytest

from gomboc_cad.errors import StudyError
from gomboc_cad.tolerance.executors import executor_for
from gomboc_cad.tolerance.sampling import BATCH_ROWS
from gomboc_cad.tolerance.study import run_sensitivity, run_study
from tests.tolerance.conftest import dask_cluster
from tests.tolerance.toys import LoadedSphere, Mortal, Watched

MODEL = LoadedSphere(margin_mm=0.25)
SLOW = LoadedSphere(margin_mm=0.25, pause_s=0.05)


@pytest.mark.parametrize(
    "name", ["", "loca", "local:", "local:0", "local:-1", "local:x", "dask://", "dask://host", "tcp://host:1"]
)
def test_an_unknown_executor_is_refused(name: str) -> None:
    with pytest.raises(StudyError, match=r"name local, local:4 or dask://HOST:PORT"), executor_for(name):
        pass


def test_local_processes() -> None:
    here = run_study(MODEL, 2000, seed=1)
    for name in ("local", "local:2"):
        with executor_for(name) as executor:
            there = run_study(MODEL, 2000, seed=1, executor=executor)
        assert there.rows.tobytes() == here.rows.tobytes()


def test_a_local_process_that_dies_is_told_and_the_study_goes_on(tmp_path: Path) -> None:
    model = Mortal(margin_mm=0.25, maker=os.getpid(), marker=tmp_path / "died")
    store = tmp_path / "rows.csv"
    with pytest.raises(StudyError, match="A process of the study died"), executor_for("local:1") as executor:
        run_study(model, 3000, seed=2, executor=executor, store=store)
    assert not store.exists()
    with executor_for("local:1") as executor:
        found = run_study(model, 3000, seed=2, executor=executor, store=store)
    assert found.rows.tobytes() == run_study(MODEL, 3000, seed=2).rows.tobytes()


SCRIPT = """
import sys
from pathlib import Path
from gomboc_cad.tolerance.executors import executor_for
from gomboc_cad.tolerance.sampling import BATCH_ROWS
from gomboc_cad.tolerance.study import run_study
from tests.tolerance.toys import LoadedSphere

def tell(stage):
    print(stage, flush=True)

try:
    with executor_for("local:2") as executor:
        model = LoadedSphere(margin_mm=0.25, pause_s=0.05)
        run_study(model, 20_000, 5, executor=executor, store=Path(sys.argv[1]), progress=tell)
except KeyboardInterrupt:
    sys.exit(130)
"""


def test_an_interrupt_from_the_keyboard_ends_all_processes_quietly(tmp_path: Path) -> None:
    """The terminal sends it to all of them at once."""
    store = tmp_path / "rows.csv"
    child = subprocess.Popen(
        [sys.executable, "-c", SCRIPT, str(store)],
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        start_new_session=True,
    )
    with child:
        assert child.stdout is not None
        while not child.stdout.readline().startswith("batch 5 "):
            assert child.poll() is None
        os.killpg(child.pid, signal.SIGINT)
        _, errors = child.communicate(timeout=60)
    assert (child.returncode, errors) == (130, "")
    model = LoadedSphere(margin_mm=0.25, pause_s=0.05)
    with executor_for("local:2") as executor:
        resumed = run_study(model, 20_000, seed=5, executor=executor, store=store)
    assert resumed.rows.tobytes() == run_study(MODEL, 20_000, seed=5).rows.tobytes()


def test_a_scheduler_that_does_not_answer_is_given_up(distributed: ModuleType) -> None:
    begun = time.monotonic()
    with (
        pytest.raises(StudyError, match=r"No Dask scheduler answers at 127\.0\.0\.1:1 within 1 s"),
        executor_for("dask://127.0.0.1:1", connect_s=1.0),
    ):
        pass
    # No measurement: an unbounded wait would be minutes.
    assert time.monotonic() - begun < 60.0


def test_a_cluster_without_workers_is_refused(distributed: ModuleType, tmp_path: Path) -> None:
    with dask_cluster(tmp_path, workers=0) as cluster:
        refused = pytest.raises(StudyError, match="has no workers; start some")
        with refused, executor_for(cluster.name, connect_s=1.0):
            pass


def test_linear_algebra_has_one_thread_in_a_worker_with_several(
    distributed: ModuleType, tmp_path: Path
) -> None:
    """In between the worker is idle, which is when a limit would be lifted."""
    with dask_cluster(tmp_path, 1, threads=3) as cluster, executor_for(cluster.name) as executor:
        for seed in range(10):
            found = run_study(Watched(), 4 * BATCH_ROWS, seed, executor=executor)
            assert found.rows["stable"].max() == 1


@pytest.mark.filterwarnings("ignore:Mismatched versions found")
def test_a_worker_with_another_numpy_is_refused(distributed: ModuleType, tmp_path: Path) -> None:
    """It says so itself; the last bits of its numbers would not be those of this process."""
    other = tmp_path / "modules" / "numpy-1.0.dist-info"
    other.mkdir(parents=True)
    (other / "METADATA").write_text("Metadata-Version: 2.1\nName: numpy\nVersion: 1.0\n")
    with dask_cluster(tmp_path, 1, other.parent) as cluster:
        refused = pytest.raises(
            StudyError, match=r"has numpy 1\.0 instead of 2\..*; install the same packages"
        )
        with refused, executor_for(cluster.name):
            pass


@pytest.mark.slow
def test_a_dask_worker_killed_in_mid_study_changes_nothing(distributed: ModuleType, tmp_path: Path) -> None:
    here = run_study(MODEL, 20_000, seed=3)
    with dask_cluster(tmp_path, workers=2) as cluster, executor_for(cluster.name) as executor:
        assert run_sensitivity(MODEL, 512, seed=4, executor=executor) == run_sensitivity(MODEL, 512, seed=4)

        def kill(stage: str) -> None:
            if stage == "batch 6 of 40":
                cluster.workers[0].kill()

        there = run_study(SLOW, 20_000, seed=3, executor=executor, store=tmp_path / "rows.csv", progress=kill)
        assert cluster.workers[0].wait(timeout=30.0) != 0
        assert cluster.workers[1].poll() is None
    assert there.rows.tobytes() == here.rows.tobytes()
    assert there.yield_monostable == here.yield_monostable
    assert (tmp_path / "rows.csv").read_text().count("\n") == 20_001


@pytest.mark.slow
def test_a_scheduler_that_dies_in_mid_study_leaves_what_was_done(
    distributed: ModuleType, tmp_path: Path
) -> None:
    store = tmp_path / "rows.csv"
    lost = pytest.raises(StudyError, match="lost its workers or its scheduler")
    with (
        dask_cluster(tmp_path, workers=1) as cluster,
        lost,
        executor_for(cluster.name, connect_s=2.0) as executor,
    ):

        def kill(stage: str) -> None:
            if stage == "batch 6 of 40":
                cluster.scheduler.kill()

        run_study(SLOW, 20_000, seed=3, executor=executor, store=store, progress=kill)
    told: list[str] = []
    again = run_study(SLOW, 20_000, seed=3, store=store, cancelled=lambda: False, progress=told.append)
    assert again.rows.tobytes() == run_study(MODEL, 20_000, seed=3).rows.tobytes()
