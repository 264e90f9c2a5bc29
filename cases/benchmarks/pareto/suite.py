"""Error over seconds for degrees, rules, tolerances and meshes, and where the defaults lie."""

from __future__ import annotations

from collections.abc import Iterator

from ..integrals.suite import pairs
from ..report import Row
from .bags import pancake_rows, roof_rows
from .flows import problems
from .picture import draw

__all__ = ["draw", "pairs", "run"]


def run(quick: bool) -> Iterator[Row]:
    """Rows of the five problems, each with a warm-up that compiles its kernels."""
    yield from pancake_rows(quick)
    for problem in problems(quick):
        for degree in problem.degrees:
            problem.row("warm-up", "", problem.sizes[0], degree)
        yield from problem.rows(quick)
    yield from roof_rows(quick)
