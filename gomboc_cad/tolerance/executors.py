"""Where the batches are judged: processes of this machine, or an existing Dask cluster."""

from __future__ import annotations

import os
import re
import signal
import sys
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Executor, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing import get_context
from typing import TYPE_CHECKING

from gomboc_cad.errors import StudyError

if TYPE_CHECKING:
    from distributed import Client

CONNECT_S = 10.0
_LOCAL = re.compile(r"local(?::([1-9]\d*))?")
_DASK = re.compile(r"dask://([^/\s]+:\d+)/?")
_DECISIVE = ("gomboc-cad", "numpy", "scipy")
"""Packages on which the last bits of a number depend."""


@contextmanager
def executor_for(name: str, *, connect_s: float = CONNECT_S) -> Iterator[Executor]:
    """Give the executor that a name stands for, for the time of a block.

    Local processes are started anew and import the program that uses them, so that its own work has to stand
    behind `if __name__ == "__main__":`.

    Args:
        name: `local` for as many processes as there are processors, `local:4` for four, `dask://HOST:PORT`
            for the cluster of that scheduler.
        connect_s: How long to wait for a scheduler.

    Raises:
        StudyError: If there is no such executor, the scheduler cannot be reached or has no fit workers, or
            workers die in the midst of the work.
    """
    if match := _LOCAL.fullmatch(name):
        processes = int(match[1] or _processors())
        with _local(processes) as executor:
            yield executor
    elif match := _DASK.fullmatch(name):
        with _dask(match[1], connect_s) as executor:
            yield executor
    else:
        raise StudyError(f"There is no executor {name!r}; name local, local:4 or dask://HOST:PORT.")


def _processors() -> int:
    """Processors that this process may use, where the system tells."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def _local(processes: int) -> Iterator[Executor]:
    # Forked processes would inherit the locks of whatever threads there are.
    pool = ProcessPoolExecutor(processes, get_context("spawn"), initializer=_leave_interrupts_to_parent)
    try:
        yield pool
    except BrokenExecutor as error:
        raise StudyError(
            "A process of the study died, perhaps for want of memory; run it again with fewer processes, and "
            "with the same file it goes on where it was."
        ) from error
    finally:
        pool.shutdown(cancel_futures=True)


def _leave_interrupts_to_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _dask(address: str, connect_s: float) -> Iterator[Executor]:
    try:
        from distributed import Client, KilledWorker
    except ModuleNotFoundError as error:
        raise StudyError(
            "Dask is not installed: install gomboc-cad[dask], or use local processes."
        ) from error
    try:
        client = Client(f"tcp://{address}", timeout=connect_s, set_as_default=False)
    except (OSError, ValueError) as error:
        raise StudyError(
            f"No Dask scheduler answers at {address} within {connect_s:g} s; start one, or use local "
            "processes."
        ) from error
    with client:
        _require_equal_workers(client, address, connect_s)
        executor = client.get_executor(pure=False)
        try:
            yield executor
        except (KilledWorker, CancelledError) as error:
            raise StudyError(
                f"The Dask cluster at {address} lost its workers or its scheduler; run the study again, and "
                "with the same file it goes on where it was."
            ) from error
        finally:
            executor.shutdown(wait=False)


def _require_equal_workers(client: Client, address: str, connect_s: float) -> None:
    """Raise StudyError if there are no workers, or one that would give other numbers."""

    # A function within a function is sent as code, so that a worker needs nothing to run it.
    def versions() -> dict[str, str]:
        from importlib.metadata import PackageNotFoundError, version

        found = dict.fromkeys(_DECISIVE, "none")
        for name in _DECISIVE:
            with suppress(PackageNotFoundError):
                found[name] = version(name)
        return found

    try:
        client.wait_for_workers(1, timeout=connect_s)
    except TimeoutError as error:
        raise StudyError(f"The Dask scheduler at {address} has no workers; start some.") from error
    mine = versions()
    for worker, theirs in client.run(versions).items():
        differ = [
            f"{name} {theirs[name]} instead of {mine[name]}" for name in mine if theirs[name] != mine[name]
        ]
        if differ:
            raise StudyError(
                f"The Dask worker {worker} has {', '.join(differ)}; install the same packages there."
            )
