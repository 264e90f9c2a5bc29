"""Damaged scenes: no traceback, an answer within seconds, nothing ignored or accepted silently."""

from __future__ import annotations

import pytest

from cases.benchmarks.honesty.scenes import trials


def broken(rows):
    return [f"{row['promise']}: {row['case']}: {row['detail']}" for row in rows if not row["held"]]


def test_damaged_scenes_are_refused_in_a_message():
    rows = trials(quick=True)
    assert broken(rows) == []
    assert len(rows) > 450


@pytest.mark.slow
def test_damaged_scenes_of_all_sizes_are_refused_in_a_message():
    rows = trials(quick=False)
    assert broken(rows) == []
    assert len(rows) > 9700
