"""Error in the goal against seconds: models, indicators, adjoints and markings side by side."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace

from coupling.model_adaptivity.adaptive_loop import Strategy, adapt, full_model
from coupling.navier_stokes.newton import solve_robustly

from ...kinds.adaptive_flow import build
from ...kinds.adaptive_flow.geometry import channel_cavity
from ..report import Row
from .partitions import vorticity


def cost_rows(cells: int) -> list[Row]:
    """All strategies at two Reynolds numbers, beside either model everywhere."""
    rows = []
    for reynolds in (10.0, 1000.0):
        flow = build.flow_on(channel_cavity(cells), reynolds)
        goal = vorticity(flow)
        case = f"Re = {reynolds:g}, h = 1/{cells}"
        began = time.process_time()
        reference, _ = full_model(flow, goal)
        full = time.process_time() - began
        rows.append(_cost(f"{case}, Navier-Stokes everywhere", full, 0.0, 1.0, 1, full))
        began = time.process_time()
        value = goal.value(solve_robustly(flow, flow.nowhere).x)
        seconds = time.process_time() - began
        error = (reference - value) / value
        rows.append(_cost(f"{case}, Stokes everywhere", seconds, error, 0.0, 1, full))
        for name, strategy in strategies().items():
            began = time.process_time()
            steps = list(adapt(flow, goal, strategy, reference=reference))
            seconds, last = time.process_time() - began, steps[-1]
            row = _cost(
                f"{case}, {name}",
                seconds,
                last.error_rel_j0,
                last.element_fraction,
                len(steps),
                full,
            )
            rows.append(row | {"tolerance": strategy.tolerance})
    return rows


def strategies(tolerance: float = 1e-3) -> Mapping[str, Strategy]:
    """Indicators, adjoints and markings side by side, all to one bound."""
    plain = Strategy(tolerance=tolerance, max_steps=40)
    return {
        **{kind: replace(plain, indicator=kind) for kind in ("integral", "counting", "exact")},
        "integral, enriched adjoint": replace(plain, adjoint="enriched", layers=2),
        "integral, mixed adjoint": replace(plain, adjoint="mixed"),
        "integral, doerfler 0.9": replace(plain, marking="doerfler", parameter=0.9),
        "integral, fixed fraction 0.2": replace(plain, marking="fraction", parameter=0.2),
    }


def _cost(
    case: str, seconds: float, error: float, fraction: float, solves: int, full: float
) -> Row:
    return {
        "case": case,
        "seconds": seconds,
        "error": error,
        "reference": "full model, same mesh",
        "elements": fraction,
        "solves": solves,
        "ratio": seconds / full,
        "peer": "Navier-Stokes everywhere",
    }
