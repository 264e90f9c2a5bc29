"""Runs benchmarks and keeps their rows as ``results/NAME.json``, then rewrites the tables.

``python -m cases.benchmarks.record [--full] [NAME ...]``: small sizes unless ``--full``, all
benchmarks unless named, each in a process of its own. Kept numbers have six digits; what only
pictures need is left out. ``... record --runs DIR ...`` takes rows of ``folds`` from run folders of
folded bags; they stay until they are taken anew.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from . import BENCHMARKS, tables
from .report import HIDDEN
from .view import RESULTS

DIGITS = 6


def kept(value: Any) -> Any:
    """A report with rounded numbers, null for those that are not finite."""
    if isinstance(value, dict):
        return {k: kept(v) for k, v in value.items() if not k.startswith("_") and k not in HIDDEN}
    if isinstance(value, list):
        return [kept(item) for item in value]
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None
    return value


def keep(file: Path, name: str) -> None:
    """Write a report of `airfold bench --json` into the results, one row a line.

    Rows that were taken from run folders stay.
    """
    report = kept(json.loads(file.read_text(encoding="utf-8")))
    cases = {row["case"] for row in report["rows"]}
    old = RESULTS / f"{name}.json"
    before = json.loads(old.read_text(encoding="utf-8"))["rows"] if old.exists() else []
    taken = [row for row in before if "commit" in row and row["case"] not in cases]
    _write(name, {**report, "rows": [*report["rows"], *taken]})


def take(folders: Sequence[Path], commit: str) -> None:
    """Put rows of run folders into the results of ``folds``, in the place of their former ones."""
    from .folds.opened import rows_of_runs

    report = json.loads((RESULTS / "folds.json").read_text(encoding="utf-8"))
    new = {row["case"]: row for row in kept(rows_of_runs(folders, commit))}
    rows = [new.pop(row["case"], row) for row in report["rows"]]
    _write("folds", {**report, "rows": [*rows, *new.values()]})


def _write(name: str, report: Mapping[str, Any]) -> None:
    rows = ",\n".join(json.dumps(row) for row in report["rows"])
    head = json.dumps({k: v for k, v in report.items() if k != "rows"}, indent=1)[:-2]
    (RESULTS / f"{name}.json").write_text(f'{head},\n "rows": [\n{rows}\n]\n}}\n', encoding="utf-8")


def record(name: str, full: bool) -> bool:
    """Run one benchmark and keep its rows; whether it ran to its end."""
    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / "report.json"
        quick = [] if full else ["--quick"]
        command = [sys.executable, "-m", "cases.cli", "bench", name, "--json", str(file), *quick]
        if subprocess.run(command, check=False).returncode:
            return False
        keep(file, name)
    return True


def main() -> int:
    """Record what is asked for; the number of benchmarks that failed."""
    parser = argparse.ArgumentParser(prog="python -m cases.benchmarks.record")
    parser.add_argument("names", nargs="*", choices=[[], *BENCHMARKS], metavar="NAME")
    parser.add_argument("--full", action="store_true", help="all sizes")
    parser.add_argument("--runs", nargs="+", type=Path, metavar="DIR", help="rows of run folders")
    parser.add_argument("--commit", default="", help="of the code that made them")
    options = parser.parse_args()
    if options.runs:
        take(options.runs, options.commit)
        tables.main()
        return 0
    done = [record(name, options.full) for name in options.names or BENCHMARKS]
    tables.main()
    return done.count(False)


if __name__ == "__main__":
    sys.exit(main())
