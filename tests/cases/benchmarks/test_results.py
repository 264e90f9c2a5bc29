"""Committed results have the format that `cases.benchmarks` states, and README files show them."""

import math

import pytest

from cases.benchmarks import BENCHMARKS
from cases.benchmarks.folds.like import PREFIX
from cases.benchmarks.headline import HEADLINE
from cases.benchmarks.tables import FILES, MARKED, regenerated, views
from cases.benchmarks.view import results, rows_of

# what a tolerance is asked of: the entry of the same row that must keep it
TOLERANCES = {
    "tolerance": "error",
    "coupling tolerance": "error",
    "matrix tolerance": "error random",
    "residual tolerance": "residual",
}
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


def test_what_was_asked_was_kept():
    """Error above tolerance in a row that is not there to show it is a defect, anywhere."""
    asked = [(row, k) for _, row in ROWS for k in TOLERANCES if row.get(k)]
    assert {k for _, k in asked} == set(TOLERANCES)
    broken = []
    for row, kind in asked:
        assert 0.0 < row[kind] < 1.0
        measured = row[TOLERANCES[kind]]
        if row.get("expected") != "fail" and (measured is None or abs(measured) > row[kind]):
            broken.append((row["case"], kind, row[kind], measured))
    assert broken == []


def test_every_tolerance_has_its_quantity():
    named = {key for _, row in ROWS for key in row if key.endswith("tolerance")}
    assert named == set(TOLERANCES)


def test_what_is_shown_to_fail_fails():
    marked = [row for _, row in ROWS if "expected" in row]
    assert marked
    assert {row["expected"] for row in marked} == {"fail"}
    for row in marked:
        kept = all(
            row[measured] is not None and abs(row[measured]) <= row[kind]
            for kind, measured in TOLERANCES.items()
            if kind in row
        )
        stopped = row.get("result", "").startswith("failed") or row.get("iterations", 0) >= 100
        assert stopped or not kept or row.get("converged") is False, row


def test_no_frame_of_a_folded_bag_crosses():
    opened = [row for name, row in ROWS if name == "folds" and row["case"].startswith(PREFIX)]
    assert [row["case"] for row in opened if row.get("crossing")] == []


def test_ratios_name_their_peer():
    for _, row in ROWS:
        assert "ratio" not in row or row["peer"], row


def test_numbers_have_six_digits():
    for _, row in ROWS:
        for value in row.values():
            if isinstance(value, float):
                assert value == float(f"{value:.6g}")
                assert math.isfinite(value)
