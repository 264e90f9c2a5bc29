"""The benchmark of the integrals keeps its promises on the near-singular rules."""

import pytest

from cases.benchmarks.integrals import eigenvalue_rows, near_rows, triangle_rows


@pytest.mark.slow
def test_near_rules_down_to_a_ten_thousandth():
    """Measured at most 1.1e-6 with the default orders, 2.1e-9 with the fine ones."""
    rows = near_rows(quick=True)
    assert len(rows) == 16
    for row in rows:
        assert row["error"] < (2e-6 if row["orders"] == "default" else 5e-9)
        assert row["error"] < 1e-3 * row["peer_error"]


@pytest.mark.slow
def test_near_rules_of_triangles():
    """Measured to d/h = 1e-3: 4.2e-4 at most with the default orders, 1.9e-5 with the fine ones."""
    rows = triangle_rows(quick=True)
    assert len(rows) == 16
    for row in rows:
        if row["d/h"] >= 1e-3:
            assert row["error"] < (1e-3 if row["orders"] == "default" else 4e-5)


def test_single_layer_is_positive_without_the_normal():
    assert all(row["value"] > 0.0 for row in eigenvalue_rows(quick=True))
