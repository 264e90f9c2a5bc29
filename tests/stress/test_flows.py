"""Tractions that say how wrong they are: above their tolerance only with a word."""

import math

import numpy as np
import pytest

from cases.benchmarks.honesty.flows import trials
from cases.benchmarks.honesty.flows.exact import approaching, following, spheroid_moving
from cases.geometry.bodies import spheroid
from hbem import StokesFlow

# trials of each share at least, quick and whole
SHARES = {"compression": (4, 215), "quadrature": (4, 224), "mesh": (4, 150)}


@pytest.mark.parametrize("quick", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_no_silent_failure(quick):
    found = trials(quick)
    over = [t for t in found if not t["error"] <= t["tolerance"]]
    assert [t for t in over if not t["refused"]] == []
    tried = {share: [t for t in found if t["share"] == share] for share in SHARES}
    assert all(len(tried[share]) >= least[not quick] for share, least in SHARES.items())
    # where the operator is all that counts and the film is resolved
    resolved = [t for s in ("compression", "quadrature") for t in tried[s] if t["resolved"]]
    assert sum(t in over for t in resolved) <= 0.02 * len(resolved)
    # estimates before corrections
    assert all(0.5 < t["before"] < 2.0 for t in resolved)
    assert any(not t["refused"] for t in tried["mesh"])


def test_series_of_two_spheres():
    """Lubrication near contact, no interaction far away."""
    for gap in (1e-3, 1e-5):
        film = 0.5 / gap - 0.45 * math.log(gap) + 1.346
        assert approaching(gap) == pytest.approx(film, rel=2e-4)
    assert following(1e-6) == pytest.approx(0.645, abs=1e-3)
    assert approaching(1e4) == pytest.approx(1.0, abs=2e-4)
    assert following(1e4) == pytest.approx(1.0, abs=2e-4)


def test_exact_traction_of_a_spheroid():
    """Nearly a sphere: 3/2 U, and nearly a disc: force 16 U along the axis."""
    n = np.eye(3)
    for axis in n:
        near = spheroid_moving(1.0 - 1e-6, axis, n, n)
        assert near == pytest.approx(np.tile(1.5 * axis, (3, 1)), abs=1e-3)
    flow = StokesFlow(spheroid(6, 6, c=0.2, grading=0.5), measure="none")
    along = flow.weights @ spheroid_moving(0.2, n[2], flow.points, flow.normals)
    assert 16.0 < along[2] < 6.0 * np.pi
