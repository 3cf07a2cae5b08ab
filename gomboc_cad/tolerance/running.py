"""All batches of a sample, in order, in this process or by any executor of the kind of `concurrent.futures`.

A model is pickled once; each process unpickles it once and keeps it, and with it all that it has computed for
itself. A task is otherwise no more than the number of a batch. Only so many tasks are given out ahead of the
batch that is waited for, which bounds the memory.
"""

from __future__ import annotations

import pickle
import threading
from collections import deque
from collections.abc import Callable, Generator
from concurrent.futures import Executor, Future, wait
from contextlib import closing
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, cast

from threadpoolctl import threadpool_info, threadpool_limits

from gomboc_cad.errors import StudyError
from gomboc_cad.progress import Progress, silent
from gomboc_cad.reproducible import one_blas_thread
from gomboc_cad.tolerance.judging import RowArray, judged_rows
from gomboc_cad.tolerance.requirement import Requirement
from gomboc_cad.tolerance.sampling import Sample

if TYPE_CHECKING:
    from gomboc_cad.tolerance.model import StudyModel

Cancelled = Callable[[], bool]

_IN_FLIGHT = 128
_LOOK_EVERY_S = 0.2


def never() -> bool:
    """Nobody cancels."""
    return False


@dataclass(frozen=True)
class Job:
    """What is the same for all batches of a sample.

    Attributes:
        model: What is judged.
        sample: The quantiles.
        requirement: What a dead zone follows from.
    """

    model: StudyModel
    sample: Sample
    requirement: Requirement

    def batch(self, index: int) -> RowArray:
        """Make and judge one batch."""
        return judged_rows(self.model, self.sample.batch(index), self.requirement)


def run_batches(
    job: Job,
    executor: Executor | None = None,
    *,
    first: int = 0,
    progress: Progress = silent,
    cancelled: Cancelled = never,
) -> Generator[RowArray]:
    """Judge the batches from `first` on, and give their rows in order.

    Args:
        job: What is judged, and on which sample.
        executor: Where; in this process if there is none.
        first: Index of the first batch.
        progress: Told of each batch as it is begun, or waited for.
        cancelled: Asked again and again whether to stop.

    Raises:
        KeyboardInterrupt: If it is cancelled; what has not begun is given up.
    """
    total = job.sample.batches
    batches = _here(job, first) if executor is None else _elsewhere(job, first, executor, cancelled)
    # An executor of threads computes in this process, where only one thread can set the limit.
    with one_blas_thread(), closing(batches):
        for index in range(first, total):
            if cancelled():
                raise KeyboardInterrupt
            progress(f"batch {index + 1} of {total}")
            yield next(batches)


def _here(job: Job, first: int) -> Generator[RowArray]:
    for index in range(first, job.sample.batches):
        yield job.batch(index)


def _elsewhere(job: Job, first: int, executor: Executor, cancelled: Cancelled) -> Generator[RowArray]:
    packed = pickle.dumps(job)
    waiting: deque[Future[RowArray]] = deque()
    try:
        for index in range(first, job.sample.batches):
            waiting.append(executor.submit(_batch, packed, index))
            if len(waiting) == _IN_FLIGHT:
                yield _next(waiting, cancelled)
        while waiting:
            yield _next(waiting, cancelled)
    finally:
        for future in waiting:
            future.cancel()


def _next(waiting: deque[Future[RowArray]], cancelled: Cancelled) -> RowArray:
    """Wait for the first of them, and take it away."""
    while not wait([waiting[0]], timeout=_LOOK_EVERY_S).done:
        if cancelled():
            raise KeyboardInterrupt
    return waiting.popleft().result()


def _batch(packed: bytes, index: int) -> RowArray:
    job = _unpacked(packed)
    _require_one_blas_thread()
    return job.batch(index)


@lru_cache(maxsize=1)
def _require_one_blas_thread() -> None:
    """Hold the linear algebra of a worker to one thread for as long as the worker lives.

    Of several threads only the first that sets a limit can change it, so it must not be lifted in between.

    Raises:
        StudyError: If somebody else in this process holds it to more.
    """
    if threading.current_thread() is not threading.main_thread():
        threadpool_limits(1, "blas")
        if any(pool["num_threads"] > 1 for pool in threadpool_info() if pool["user_api"] == "blas"):
            raise StudyError("A worker computes with several threads; start it with OPENBLAS_NUM_THREADS=1.")


@lru_cache(maxsize=2)
def _unpacked(packed: bytes) -> Job:
    return cast("Job", pickle.loads(packed))
