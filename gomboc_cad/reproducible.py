"""The same numbers on every run, however many processors there are."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import threadpool_limits

_LOCK = threading.Lock()
_limits: list[threadpool_limits] = []
_users = 0


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Keep linear algebra on one thread: how a matrix is divided among threads shows in the last bits.

    The limit is the process's, so it lasts until the last of several threads has left the block.
    """
    global _users
    with _LOCK:
        if _users == 0:
            _limits.append(threadpool_limits(limits=1, user_api="blas"))
        _users += 1
    try:
        yield
    finally:
        with _LOCK:
            _users -= 1
            if _users == 0:
                _limits.pop().restore_original_limits()
