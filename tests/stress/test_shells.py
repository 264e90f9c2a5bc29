"""Shells over degrees, knots, cuts and limit points: right, or refused."""

from __future__ import annotations

import numpy as np
import pytest

from cases.benchmarks.honesty.shells import trials


def _check(quick: bool, least: int) -> None:
    rows = trials(quick)
    assert len(rows) >= least
    silent = [r["case"] for r in rows if r["error"] > r["tolerance"] and not r["refused"]]
    assert silent == []
    # neither of both is the whole answer: much is right, and much cannot be
    assert 0.3 < np.mean([r["refused"] for r in rows]) < 0.7
    plain = [r for r in rows if "knot of multiplicity 1" in r["case"] and "p = 1" not in r["case"]]
    assert not any(r["refused"] for r in plain)


def test_a_sample_of_shells() -> None:
    _check(True, 20)


@pytest.mark.slow
def test_all_shells() -> None:
    _check(False, 150)
