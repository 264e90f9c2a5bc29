"""Threads of compiled code, for all that starts threads beside it."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager

from numba import get_num_threads, set_num_threads
from threadpoolctl import threadpool_limits


def threads() -> int:
    """Number of threads that compiled code may use."""
    return get_num_threads()


@contextmanager
def workers() -> Iterator[Executor]:
    """A pool of `threads` workers; BLAS keeps to one thread each meanwhile.

    BLAS' own threads in every worker would wait for each other: ten times slower and worse.
    """
    with threadpool_limits(1, "blas"), ThreadPoolExecutor(threads()) as pool:
        yield pool


@contextmanager
def limited(count: int) -> Iterator[int]:
    """Compiled code on ``count`` threads meanwhile; gives the number before."""
    before = get_num_threads()
    set_num_threads(count)
    try:
        yield before
    finally:
        set_num_threads(before)
