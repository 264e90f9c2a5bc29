"""Threads of compiled code, for all that starts threads beside it."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from typing import Any

from numba import get_num_threads, set_num_threads
from threadpoolctl import threadpool_limits

PIECES = 16  # a thread: pieces take unequal time, and handing one over takes some 20 us


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


def over(count: int, kernel: Callable[..., None], *arguments: Any) -> None:
    """Work off ``kernel((first, last), *arguments)`` over ``range(count)`` on all threads.

    The kernel releases Python's lock and writes only what belongs to its span. Plain loops on
    threads of our own: numba's parallel loops take longer to compile, and no kernel needs more.
    """
    n = get_num_threads()
    if n == 1 or count < 2:
        kernel((0, count), *arguments)
        return
    pieces = min(count, PIECES * n)
    left = iter(range(pieces))  # shared: whoever is free takes the next piece

    def work() -> None:
        for i in left:
            kernel((count * i // pieces, count * (i + 1) // pieces), *arguments)

    helpers = [_helpers(n - 1).submit(work) for _ in range(n - 1)]
    try:
        work()
    finally:
        deque(left, maxlen=0)  # after a failure nobody goes on
        for helper in helpers:
            if not helper.cancel():  # one that never began has nothing left to do
                helper.result()


@cache
def _helpers(count: int) -> Executor:
    return ThreadPoolExecutor(count)


if hasattr(os, "register_at_fork"):  # threads do not live on in a forked process
    os.register_at_fork(after_in_child=_helpers.cache_clear)
