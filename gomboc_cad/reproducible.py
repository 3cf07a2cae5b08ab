"""The same numbers on every run, however many processors there are."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import threadpool_limits


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Keep linear algebra on one thread: how a matrix is divided among threads shows in the last bits."""
    with threadpool_limits(limits=1, user_api="blas"):
        yield
