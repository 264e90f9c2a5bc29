"""Runs a benchmark and reports it: calibration of the machine first, then a table and JSON.

Machines are noisy and differ; seconds are given also in units of the calibration, as the work a
dgemm (GFLOP) or the far kernel (pairs of points) does in that time.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ..machine import machine, versions
from ..output.atomic import replacing

Row = Mapping[str, Any]
NEEDED = ("case", "seconds", "error")


def execute(name: str, module: str, quick: bool, file: Path | None = None) -> list[Row]:
    """Run one benchmark, print its table and write JSON if a file is given."""
    benchmark = import_module(module)
    speed = calibrate(getattr(benchmark, "pairs", None))
    rows = calibrated(benchmark.run(quick), speed)
    report = {"benchmark": name, "machine": {**machine(), **versions(), **speed}, "rows": rows}
    show(name, rows, speed)
    if file is not None:
        with replacing(file) as stream:
            json.dump(report, stream, indent=2, default=_plain)
            stream.write("\n")
    return rows


def calibrate(pairs: Callable[[], int] | None = None, size: int = 1000) -> dict[str, float]:
    """Speed of the machine now: dgemm in GFLOP/s and, if possible, kernel pairs in 1/s.

    Parameters
    ----------
    pairs : callable, optional
        Evaluates a kernel once (compiled before) and returns how many pairs of points it did.
    """
    a = np.random.default_rng(0).standard_normal((size, size))
    speed = {"dgemm_gflops": 2e-9 * size**3 / _best(lambda: a @ a)}
    if pairs is not None:
        count = pairs()
        speed["stokeslet_pairs_per_s"] = count / _best(pairs)
    return speed


def calibrated(rows: Sequence[Row], speed: Mapping[str, float]) -> list[dict[str, Any]]:
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
    """Print the rows as one table, a column for every key that occurs."""
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False)
    figures = ", ".join(f"{key} {value:.3g}" for key, value in speed.items())
    table = Table(title=f"{name} ({figures})")
    columns = list(dict.fromkeys(key for row in rows for key in row))
    for column in columns:
        table.add_column(column, justify="left" if column == "case" else "right")
    for row in rows:
        table.add_row(*(_cell(row.get(column, "")) for column in columns))
    console.print(table)


def _best(function: Callable[[], Any], repeats: int = 5) -> float:
    """Shortest of several timings in seconds, after one warm-up."""
    function()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def _cell(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, float | np.floating) else str(value)


def _plain(value: Any) -> Any:
    """JSON for numpy scalars and arrays."""
    return value.tolist() if hasattr(value, "tolist") else str(value)
