"""Coupled runs that ask for trouble end in a named result with whole files, killed ones too."""

from __future__ import annotations

import pytest

from cases.benchmarks.coupling.stress import CASES, KILLED, kill_row, stress_row

LONG = [name for name in CASES if "round" in name or "antisymmetric" in name or "30 times" in name]


def _check(case, folder):
    row = stress_row(case, folder / "run")
    assert row["named"]
    assert row["damaged files"] == 0
    assert row["error"] < 1e-8  # the prescribed volume holds in every accepted state
    return row


@pytest.mark.parametrize("case", ["m = 5e-06", "m = 5", "dt 100 times too long"])
def test_planar_troubles(case, tmp_path):
    assert _check(case, tmp_path)["steps"] > 0


@pytest.mark.slow
@pytest.mark.parametrize("case", LONG)
def test_long_troubles(case, tmp_path):
    row = _check(case, tmp_path)
    if "implicit" in case or "auto" in case or "m = 5e-6" in case:
        assert row["result"] == "completed"


@pytest.mark.slow
@pytest.mark.parametrize(("integrator", "scheme"), KILLED)
def test_kill_and_resume_repeats_the_history(integrator, scheme, tmp_path):
    row = kill_row(integrator, scheme, tmp_path)
    assert row["rows when killed"] < row["rows"]
    assert row["exit codes"] == "0, -9, 0"
    assert row["error"] == 0.0
