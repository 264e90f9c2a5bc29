"""Loops on threads: every piece once, failures told, as many threads as asked for."""

import threading

import numpy as np
import pytest

from hbem import _threads_kernels


@pytest.fixture
def over(monkeypatch):
    monkeypatch.setattr(_threads_kernels, "get_num_threads", lambda: 3)
    return _threads_kernels.over


@pytest.mark.parametrize("count", [0, 1, 7, 1000])
def test_every_piece_once(over, count):
    found = np.zeros(count, int)

    def add(span, step):
        found[span[0] : span[1]] += step

    over(count, add, 2)
    assert np.all(found == 2)


def test_threads_work_side_by_side(over):
    meet = threading.Barrier(3)
    over(3, lambda span: meet.wait(timeout=10.0))


def test_a_failure_is_told_and_ends_the_loop(over):
    begun = []

    def fail(span):
        begun.append(span)
        raise ValueError("of a kernel")

    with pytest.raises(ValueError, match="of a kernel"):
        over(1000, fail)
    assert len(begun) <= 3
