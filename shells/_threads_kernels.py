"""Loops of compiled code on several threads."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from functools import cache
from typing import Any

from numba import get_num_threads, set_num_threads

__all__ = ["get_num_threads", "over", "set_num_threads"]
PIECES = 8  # a thread: pieces take unequal time, and handing one over takes some 20 us


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
