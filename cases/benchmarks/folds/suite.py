"""Folded bags that open (`openings`), then one fluid solve of many folds (`ladder`)."""

from __future__ import annotations

from collections.abc import Iterator

from ..compression.suite import pairs
from ..report import Row
from . import ladder, openings

__all__ = ["pairs", "run"]


def run(quick: bool) -> Iterator[Row]:
    """Rows of both, as they come; small sizes only with ``quick``."""
    yield from openings.run(quick)
    yield from ladder.run(quick)
