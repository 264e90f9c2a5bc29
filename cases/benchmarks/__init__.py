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


_SUMMARIES = {
    "adaptivity": "where Stokes is good enough, against the printed figures",
    "compression": "ACA and H2 operators against direct sums and FMM3D",
    "coupling": "coupling schemes: contraction, assemblies, seconds, failures",
    "folds": "folded bags open; one fluid solve of 2, 4, 8, 16 folds",
    "honesty": "promises tried: held, broken aloud, broken in silence",
    "integrals": "single and double layer: exact flows, near rules, speed",
    "meshes": "raw triangulations: bending, roof, rotations, spheres, speed, flows",
    "pancake": "coupled inflation against statics, schemes compared",
    "pareto": "error over seconds: pancake, torus, film, folded bag, roof",
    "planar": "planar flows, narrow gaps, all planar scenes, models compared",
    "shells": "roof, locking and large rotations against published figures",
    "speed": "where users wait: now, before, and the limit",
}
BENCHMARKS: Mapping[str, Entry] = {
    name: Entry(f"{__name__}.{name}.suite", summary) for name, summary in _SUMMARIES.items()
}
