"""Benchmarks: error against time, always both. A benchmark is a folder with ``suite.py``.

A suite has ``run(quick)``, which returns or yields rows: ``case``, ``seconds``, ``error`` and its
parameters by name, ``reference``, ``error_kind`` where the error is not relative, ``tolerance``
where one was requested of that same error, ``expected`` ("fail") where a row is shown because it
fails, ``ratio`` beside ``peer`` where a peer ran. ``report.py`` runs one, ``record.py`` keeps rows
in ``results/``, ``tables.py`` makes the README's tables of them by the ``views.py`` of each folder.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Entry:
    """Path of a benchmark's module and its line in `airfold list`."""

    module: str
    summary: str


BENCHMARKS: Mapping[str, Entry] = {
    "adaptivity": Entry(
        "cases.benchmarks.adaptivity.suite",
        "where Stokes is good enough, against the printed figures",
    ),
    "compression": Entry(
        "cases.benchmarks.compression.suite", "ACA and H2 operators against direct sums and FMM3D"
    ),
    "coupling": Entry(
        "cases.benchmarks.coupling.suite",
        "coupling schemes: contraction, assemblies, seconds, failures",
    ),
    "folds": Entry(
        "cases.benchmarks.folds.suite", "one fluid solve of bags folded 2, 4, 8, 16 times"
    ),
    "integrals": Entry(
        "cases.benchmarks.integrals.suite",
        "single and double layer: exact flows, near rules, speed",
    ),
    "pancake": Entry(
        "cases.benchmarks.pancake.suite", "coupled inflation against statics, schemes compared"
    ),
    "planar": Entry(
        "cases.benchmarks.planar.suite",
        "planar flows, narrow gaps, all planar scenes, models compared",
    ),
    "shells": Entry(
        "cases.benchmarks.shells.suite",
        "roof, locking and large rotations against published figures",
    ),
}
