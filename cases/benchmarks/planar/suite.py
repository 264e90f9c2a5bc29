"""The planar systems: exact flows, convergence, coupled runs of all scenes, models compared.

Seconds of coupled runs are the processor's; ``quick`` shortens them, their full lengths are those
of the thesis.
"""

from __future__ import annotations

from ..report import Row
from . import convergence as planar_convergence
from . import layers as planar_layers
from . import load as planar_load
from . import models as planar_models
from . import runs as planar_runs
from .picture import draw

__all__ = ["draw", "run"]


def run(quick: bool) -> list[Row]:
    """Rows of the benchmark."""
    rows = planar_layers.rows(quick) + planar_load.rows(quick)
    rows += planar_convergence.in_space(quick) + planar_convergence.in_time(quick)
    inflation, pancake = planar_runs.pancake(quick)
    folding, fold = planar_runs.fold(quick)
    rows += inflation + planar_runs.contact_rows(quick)
    rows += planar_runs.deflation_rows(quick) + folding
    rows += planar_runs.potential_rows(quick) + planar_convergence.folded(quick)
    return rows + planar_models.rows(quick, pancake, fold)
