"""Committed results have the format that `cases.benchmarks` states, and README files show them."""

import math

import pytest

from cases.benchmarks import BENCHMARKS
from cases.benchmarks.headline import HEADLINE
from cases.benchmarks.tables import FILES, MARKED, regenerated, views
from cases.benchmarks.view import results, rows_of

ROWS = [(name, row) for name in BENCHMARKS for row in results(name)["rows"]]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.parent.name)
def test_tables_are_those_of_the_results(path):
    text = path.read_text(encoding="utf-8")
    assert regenerated(text) == text, "run python -m cases.benchmarks.tables"


def test_every_view_is_shown():
    shown = {(m["name"], m["view"]) for m in MARKED.finditer(FILES[0].read_text(encoding="utf-8"))}
    wanted = {(name, view) for name in BENCHMARKS for view in [*views(name), "origin"]}
    assert shown == wanted


def test_views_have_rows_in_full_results():
    for name in BENCHMARKS:
        if not results(name)["quick"]:
            for view in views(name).values():
                assert rows_of(name, view.case, view.only)


def test_each_benchmark_has_one_headline():
    assert sorted(line.benchmark for line in HEADLINE) == sorted(BENCHMARKS)
    for line in HEADLINE:
        assert rows_of(line.benchmark, line.case, line.only)[-1]["error"] is not None


def test_results_say_where_they_come_from():
    for name in BENCHMARKS:
        report = results(name)
        assert report["benchmark"] == name
        assert isinstance(report["quick"], bool)
        assert report["date"]
        assert report["commit"]
        assert {"processor", "cores", "load", "dgemm_gflops"} <= set(report["machine"])


def test_rows_have_case_seconds_and_error():
    for name, row in ROWS:
        assert row["case"], name
        assert row["seconds"] >= 0.0, row
        explained = row.get("expected") == "fail" or "none:" in row.get("reference", "")
        assert isinstance(row["error"], float) or explained, row


def test_errors_keep_the_tolerance_that_was_asked():
    """A tolerance stands only beside an error of the same quantity, so the two compare."""
    asked = [row for _, row in ROWS if "tolerance" in row]
    assert asked
    for row in asked:
        if row.get("expected") != "fail":
            assert 0.0 < row["tolerance"] < 1.0
            assert abs(row["error"]) < 2.0 * row["tolerance"], row


def test_ratios_name_their_peer():
    for _, row in ROWS:
        assert "ratio" not in row or row["peer"], row


def test_numbers_have_six_digits():
    for _, row in ROWS:
        for value in row.values():
            if isinstance(value, float):
                assert value == float(f"{value:.6g}")
                assert math.isfinite(value)
