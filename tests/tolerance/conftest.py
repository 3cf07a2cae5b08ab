"""Optional modules of the study, and a small Dask cluster."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, Queue
from threading import Thread
from types import ModuleType

import pytest

from tests.external import require_module

START_S = 60.0


@pytest.fixture(scope="session")
def pyarrow() -> ModuleType:
    """The module pyarrow."""
    return require_module("pyarrow", "parquet")


@pytest.fixture(scope="session")
def distributed() -> ModuleType:
    """The module distributed."""
    return require_module("distributed", "dask")


@contextmanager
def background(
    command: list[str], folder: Path, wanted: str, *more_modules: Path
) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run a program until the block ends; gives it and what the wanted pattern finds in what it says."""
    # Workers import the toy models of the tests.
    search = os.pathsep.join(map(str, (*more_modules, Path(__file__).parents[2])))
    environment = os.environ | {"PYTHONPATH": search, "OPENBLAS_NUM_THREADS": "2"}
    process = subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
    )
    lines: Queue[str] = Queue()
    assert process.stdout is not None
    reader = Thread(target=lambda: [lines.put(line) for line in process.stdout or ()], daemon=True)
    reader.start()
    said: list[str] = []
    try:
        while not said or not re.search(wanted, said[-1]):
            try:
                said.append(lines.get(timeout=START_S))
            except Empty:
                raise AssertionError(f"{command} says nothing:\n{''.join(said)}") from None
        found = re.search(wanted, said[-1])
        assert found is not None
        yield process, found[0]
    finally:
        process.kill()
        process.wait(timeout=START_S)
        reader.join(timeout=START_S)
        process.stdout.close()


@dataclass(frozen=True)
class Cluster:
    """A Dask scheduler and its workers, each a process of its own on the loopback.

    Attributes:
        name: For `executor_for`.
        scheduler: Process of the scheduler.
        workers: Processes of the workers.
    """

    name: str
    scheduler: subprocess.Popen[str]
    workers: tuple[subprocess.Popen[str], ...]


@contextmanager
def dask_cluster(folder: Path, workers: int, *more_modules: Path, threads: int = 1) -> Iterator[Cluster]:
    """Start a cluster of workers, which look for modules in some folders first."""
    program = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0"]
    web = ["--dashboard-address", "127.0.0.1:0"]
    with ExitStack() as stack:
        scheduler, address = stack.enter_context(
            background([*program, *web], folder, r"tcp://127\.0\.0\.1:\d+")
        )
        program = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--host", "127.0.0.1"]
        options = ["--nthreads", str(threads), "--no-nanny", "--local-directory", str(folder)]
        work = [*program, *options, *web]
        hands = [
            stack.enter_context(background(work, folder, "Registered to", *more_modules))[0]
            for _ in range(workers)
        ]
        yield Cluster(address.replace("tcp://", "dask://"), scheduler, tuple(hands))
