"""Tolerances from the traction error: the measured tables, monotone, and honest at their ends."""

from __future__ import annotations

import numpy as np
import pytest

from hbem.accuracy import (
    RULES,
    at_gap,
    budget,
    compression_error,
    film_error,
    matrix_tolerance,
)
from hbem.traction_error import Verdict


@pytest.mark.parametrize(
    ("method", "eps", "traction", "tolerance"),
    [
        ("aca", 0.05, 1e-3, 5e-5),
        ("aca", 0.01, 1e-3, 1.2e-6),
        ("h2", 0.05, 1e-3, 3.6e-4),
        ("h2", 0.01, 1e-3, 1.4e-4),
    ],
)
def test_tolerances_are_the_measured_ones(method, eps, traction, tolerance):
    assert matrix_tolerance(method, traction, eps) == pytest.approx(tolerance, rel=0.2)
    assert compression_error(method, tolerance, eps) == pytest.approx(traction, rel=0.3)


@pytest.mark.parametrize("method", ["aca", "h2"])
def test_thinner_gaps_and_smaller_errors_ask_for_more(method):
    thin = [matrix_tolerance(method, 1e-3, eps) for eps in np.geomspace(1e-3, 0.5, 30)]
    assert np.all(np.diff(thin) >= 0.0)
    small = [matrix_tolerance(method, t, 0.02) for t in np.geomspace(1e-9, 0.3, 30)]
    assert np.all(np.diff(small) >= 0.0)
    # below the table: the law eps^-2.6
    ratio = matrix_tolerance(method, 1e-3, 0.005) / matrix_tolerance(method, 1e-3, 0.01)
    assert ratio == pytest.approx(0.5**2.6)


def test_fat_bodies_keep_the_default_rules():
    found = budget(1e-3, 2.0, 10.0)
    assert found.met
    assert found.orders is RULES[0][0]
    assert found.total < 1e-3


def test_rules_follow_the_gap():
    fat, thin = budget(1e-3, 0.2, 1.0), budget(1e-3, 0.04, 1.0)
    assert fat.orders != thin.orders
    assert thin.met
    assert thin.krylov < fat.krylov
    assert (fat.preconditioner, budget(1e-3, 1.0, 1.0).preconditioner) == ("schwarz", "mass")


def test_what_cannot_be_met_is_said_with_numbers_and_remedy():
    found = budget(1e-4, 0.02, 1.0)
    assert not found.met
    assert "fluid.tolerance = 0.0001 cannot be met" in found.warnings[0]
    remedy = float(found.warnings[0].split("set fluid.tolerance to ")[1].split(",")[0])
    assert budget(remedy, 0.02, 1.0).met
    assert "extrapolated" in budget(0.5, 0.002, 1.0).warnings[-1]


def test_a_gap_that_closes_lets_residuals_weigh_more():
    asked = budget(1e-3, 0.2, 1.0)
    closed = at_gap(asked, 0.02, 1.0)
    assert closed.thinness == pytest.approx(0.1 * asked.thinness)
    assert closed.krylov_error(1e-6) > 5.0 * asked.krylov_error(1e-6)


def test_the_mesh_counts_where_the_film_tells():
    unknown = budget(1e-2, 0.2, 1.0)
    assert np.isnan(unknown.mesh)
    assert unknown.expected.verdict is Verdict.CANNOT_TELL
    assert budget(1e-2, 0.2, 1.0, film=0.5).expected.verdict is Verdict.MET
    coarse = budget(1e-2, 0.2, 1.0, film=3.2)
    assert coarse.mesh == pytest.approx(0.27)
    assert coarse.expected.verdict is Verdict.MISSED
    assert budget(1e-2, 0.2, 1.0, film=1e3).mesh == 1.0
    grows = [film_error(film) for film in np.geomspace(0.01, 100, 50)]
    assert np.all(np.diff(grows) >= 0.0)


@pytest.mark.parametrize(("traction", "gap"), [(0.0, 1.0), (1.0, 1.0), (1e-3, 0.0)])
def test_nonsense_is_refused(traction, gap):
    with pytest.raises(ValueError, match="must"):
        budget(traction, gap, 1.0)
