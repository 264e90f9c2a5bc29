"""Compressed matrices and disguised forces: what misses its tolerance says so."""

import pytest

from cases.benchmarks.honesty.matrices import trials


@pytest.mark.parametrize("quick", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_no_silent_failure(quick):
    found = trials(quick)
    broken = [t for t in found if not t["error"] <= t["tolerance"]]
    assert [t for t in broken if not t["refused"]] == []
    assert len(found) >= (50 if quick else 900)
    # refusals are the exception: out of reach of double precision
    assert 0 < len(broken) <= 0.05 * len(found)
