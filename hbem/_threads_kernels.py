"""Threads of compiled code, for all that starts threads beside it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from numba import get_num_threads, set_num_threads


def threads() -> int:
    """Number of threads that compiled code may use."""
    return get_num_threads()


@contextmanager
def limited(count: int) -> Iterator[int]:
    """Compiled code on ``count`` threads meanwhile; gives the number before."""
    before = get_num_threads()
    set_num_threads(count)
    try:
        yield before
    finally:
        set_num_threads(before)
