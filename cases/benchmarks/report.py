"""Runs a benchmark and reports it: calibration of the machine first, then a table and JSON.

Machines are noisy and differ; seconds are given also in units of the calibration, as the work a
dgemm (GFLOP) or the far kernel (pairs of points) does in that time.
"""

from __future__ import annotations

import json
import os
import subprocess
import time
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from importlib import import_module
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from ..machine import machine, versions
from ..output.atomic import replacing

Row = dict[str, Any]
NEEDED = ("case", "seconds", "error")
HIDDEN = ("gflop", "pairs")  # seconds in units of the calibration: in the JSON only


def execute(name: str, module: str, quick: bool, file: Path | None = None) -> list[Row]:
    """Run one benchmark, print its table and write JSON if a file is given.

    The file is valid from the first row on: it is written anew after each row of a benchmark that
    yields them one by one.
    """
    load = round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else -1.0
    benchmark = import_module(module)
    speed = calibrate(getattr(benchmark, "pairs", None))
    rows: list[Row] = []
    report = {
        "benchmark": name,
        "quick": quick,
        "date": datetime.now(UTC).date().isoformat(),
        "commit": revision(),
        "machine": {**machine(), "load": load, **versions(), **speed},
        "rows": rows,
    }
    for row in benchmark.run(quick):
        rows += calibrated([row], speed)
        if file is not None:
            _write(report, file)
    show(name, rows, speed)
    draw = getattr(benchmark, "draw", None)
    if file is not None and draw is not None:
        picture = file.with_suffix(".png")
        draw(rows, picture)
        print(f"picture: {picture}")
    return rows


def revision() -> str:
    """Git revision of the code, with ``+`` if it was changed since; its version without git."""
    home = Path(__file__).parent

    def git(*words: str) -> str:
        run = subprocess.run(
            ["git", "-C", home, *words], capture_output=True, text=True, check=True
        )
        return run.stdout.strip()

    try:
        changed = git("status", "--porcelain", "--untracked-files=no", "--", ":/*.py")
        return git("rev-parse", "--short=7", "HEAD") + ("+" if changed else "")
    except (OSError, subprocess.CalledProcessError):
        return versions()["airfold"]


def _write(report: Mapping[str, Any], file: Path) -> None:
    with replacing(file) as stream:
        json.dump(report, stream, indent=2, default=_plain)
        stream.write("\n")


def calibrate(pairs: Callable[[], int] | None = None, size: int = 1000) -> dict[str, float]:
    """Speed of the machine now: dgemm in GFLOP/s and, if possible, kernel pairs in 1/s.

    Parameters
    ----------
    pairs : callable, optional
        Evaluates a kernel once (compiled before) and returns how many pairs of points it did.
    """
    a = np.random.default_rng(0).standard_normal((size, size))
    speed = {"dgemm_gflops": 2e-9 * size**3 / best(lambda: a @ a)}
    if pairs is not None:
        count = pairs()
        speed["stokeslet_pairs_per_s"] = count / best(pairs)
    return speed


def calibrated(rows: Sequence[Row], speed: Mapping[str, float]) -> list[Row]:
    """Rows with their seconds also in units of the calibration.

    Raises
    ------
    KeyError
        A row without ``case``, ``seconds`` or ``error``.
    """
    full = []
    for row in rows:
        if missing := [key for key in NEEDED if key not in row]:
            raise KeyError(f"benchmark row lacks {', '.join(missing)}: {dict(row)}")
        units = {"gflop": row["seconds"] * speed["dgemm_gflops"]}
        if "stokeslet_pairs_per_s" in speed:
            units["pairs"] = row["seconds"] * speed["stokeslet_pairs_per_s"]
        full.append({**row, **units})
    return full


def show(name: str, rows: Sequence[Row], speed: Mapping[str, float]) -> None:
    """Print the rows: one table for each run of rows with the same columns."""
    from rich.box import SIMPLE
    from rich.console import Console
    from rich.table import Table

    # in a pipe nothing is cut: files and logs want whole tables
    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=240)
    figures = ", ".join(f"{key} {value:.3g}" for key, value in speed.items())
    console.print(f"{name} ({figures})", markup=False)
    for columns, group in groupby(rows, key=lambda row: tuple(key for key in row)):
        shown = [c for c in columns if c not in HIDDEN and not c.startswith("_")]
        table = Table(box=SIMPLE)
        for column in shown:
            table.add_column(column, justify="left" if column == "case" else "right")
        for row in group:
            table.add_row(*(_cell(row[column]) for column in shown))
        console.print(table)


def best(function: Callable[[], Any], repeats: int = 5) -> float:
    """Shortest of several timings in seconds, after one warm-up."""
    function()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def _cell(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float | np.floating) else str(value)


def _plain(value: Any) -> Any:
    """JSON for numpy scalars and arrays."""
    return value.tolist() if hasattr(value, "tolist") else str(value)
