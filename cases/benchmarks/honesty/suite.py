"""How often each promise of this software was tried, held, broken aloud and broken in silence.

One row a promise. A trial counts as held within its tolerance, as broken where the program said
that it may not be, and as silent otherwise. ``error`` and ``tolerance`` are those of the worst
trial that was not announced. Quantiles of the effectivity, an estimate over the true error, are
those before corrections where there are any; ``least left`` is the smallest afterwards. Where
trials are no more than held or not, the error is the share of silent ones. Seconds are those of
the whole part that a promise belongs to.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np

from ..report import Row

Trial = dict[str, Any]
# module with ``trials(quick)`` of each part, and what its errors are relative to
PARTS = {
    "matrices": "dense sums, same body",
    "flows": "exact or finer",
    "shells": "closed forms",
    "scenes": "none: held or not",
    "folders": "none: held or not",
}
QUANTILES = (0, 5, 50, 95, 100)


def run(quick: bool) -> Iterator[Row]:
    """Rows of all parts, as they come."""
    for part, reference in PARTS.items():
        began = time.perf_counter()
        trials: list[Trial] = import_module(f"{__package__}.{part}").trials(quick)
        seconds = time.perf_counter() - began
        for promise in dict.fromkeys(trial["promise"] for trial in trials):
            tried = [trial for trial in trials if trial["promise"] == promise]
            row = _measured(tried) if "error" in tried[0] else _told(tried)
            if math.isnan(row["error"]):
                row["reference"] = "none: all refused"
            yield {"case": f"{part}: {promise}", "seconds": seconds, "reference": reference} | row


def _told(trials: list[Trial]) -> Row:
    """Trials that were judged where they were made."""
    held, silent = (sum(bool(t[key]) for t in trials) for key in ("held", "silent"))
    tried = len(trials)
    counts = {"tried": tried, "held": held, "broken": tried - held - silent, "silent": silent}
    return {"error": silent / tried, "error_kind": "share of silent", **counts}


def _measured(trials: list[Trial]) -> Row:
    """Trials with an error and a tolerance."""
    over = [t for t in trials if not t["error"] <= t["tolerance"]]
    silent = sum(not t["refused"] for t in over)
    told = [t for t in trials if not t["refused"]]
    worst = max(told, key=lambda t: t["error"] / t["tolerance"], default=None)
    row: Row = {"error": math.nan} if worst is None else {
        "error": worst["error"], "tolerance": worst["tolerance"]
    }  # fmt: skip
    row |= {
        "tried": len(trials),
        "held": len(trials) - len(over),
        "broken": len(over) - silent,
        "silent": silent,
        "worst ratio": math.nan if worst is None else worst["error"] / worst["tolerance"],
    }
    if "estimate" not in trials[0]:
        return row
    left = _finite([t["estimate"] / t["error"] for t in trials])
    effectivity = _finite([t["before"] for t in trials]) or left
    resolved = [t for t in trials if t["resolved"]]
    return row | {
        **{f"effectivity {q}%": _quantile(effectivity, q) for q in QUANTILES},
        "least left": _quantile(left, 0),
        "resolved": len(resolved),
        "violated there": sum(t in over for t in resolved),
    }


def _finite(values: list[float]) -> list[float]:
    return [v for v in values if math.isfinite(v)]


def _quantile(values: list[float], percent: int) -> float:
    return float(np.percentile(values, percent)) if values else math.nan
