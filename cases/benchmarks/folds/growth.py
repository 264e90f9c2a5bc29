"""Growth of seconds and memory with the number of unknowns, from row to row of a ladder."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from ..report import Row


def growth(rows: list[Row]) -> Iterator[Row]:
    """Exponents of seconds and bytes between neighbouring rows of the ladder, beside N log N."""
    for a, b in pairwise(rows):
        step = np.log(b["unknowns"] / a["unknowns"])
        loglog = np.log(np.log(b["unknowns"]) / np.log(a["unknowns"])) / step
        memory = [r["bytes/unknown"] * r["unknowns"] for r in (a, b)]
        yield {
            "case": f"growth from {a['folds']} to {b['folds']} folds",
            "seconds": b["seconds"],
            "error": b["error"],
            "exponent of seconds": np.log(b["seconds"] / a["seconds"]) / step,
            "exponent of bytes": np.log(memory[1] / memory[0]) / step,
            "exponent of N log N": 1.0 + loglog,
        }
