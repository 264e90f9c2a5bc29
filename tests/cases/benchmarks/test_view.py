"""Templates, pivots and what is kept of a report."""

import math

from cases.benchmarks import view
from cases.benchmarks.record import kept
from cases.benchmarks.view import View, filled, table

ROWS = [
    {"case": "wall, n = 4", "seconds": 1.0, "error": 1.23e-4, "d/h": 0.1},
    {"case": "wall, n = 8", "seconds": 2.0, "error": 1.5, "d/h": 0.1},
    {"case": "wall, n = 8", "seconds": 3.0, "error": None, "d/h": 0.2, "expected": "fail"},
]


def report(monkeypatch, quick=True):
    monkeypatch.setattr(view, "results", lambda name: {"rows": ROWS, "quick": quick})


def test_templates():
    row = {"error": 1.23e-4, "d/h": 1.0, "rate, t <= 0.75": 2.0, "name": "h2", "none": None}
    assert filled("{error:.1e}", row) == "1.2e-4"
    assert filled("{d/h:.1e} {name}", row) == "1.0 h2"
    assert filled("{rate, t <= 0.75:.2f}", row) == "2.00"
    assert filled("{none:.1e} {absent}", row) == "- -"
    assert filled("{large:.0e}", {"large": 3e12}) == "3e12"
    assert filled("{seconds:.2g} s", {"seconds": 123.4}) == "123 s"


def test_rows_that_agree_share_a_line(monkeypatch):
    report(monkeypatch)
    shown = View(r"wall, n = (?P<n>\d+)", {"d/h": "{d/h}"}, ("n = {n}", "{error:.1e}"))
    assert table("toy", shown).splitlines() == [
        "| d/h | n = 4 | n = 8 |",
        "| --- | --- | --- |",
        "| 0.1 | 1.2e-4 | 1.5 |",
        "| 0.2 | - | fails |",
    ]


def test_what_small_sizes_leave_out_is_said(monkeypatch):
    report(monkeypatch)
    assert table("toy", View("door", {"": "{case}"})) == "Only with full sizes.\n"


def test_reports_are_kept_rounded_and_finite():
    row = {"error": 1.23456789, "rate": math.nan, "_curve": [1.0], "pairs": 1.0, "n": 3}
    assert kept({"rows": [row]}) == {"rows": [{"error": 1.23457, "rate": None, "n": 3}]}
