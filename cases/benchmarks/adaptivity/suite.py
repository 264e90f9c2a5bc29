"""Model adaptivity [T ch. 7]: the thesis' steps, effectivity, partitions, boundary elements, cost.

``error`` is the true modelling error relative to J(u0) unless ``error_kind`` says otherwise;
``thesis_eps`` is the negative estimate, which by its numbers is what the thesis prints. Steps
that did not converge are marked and carry no figures. Seconds are the processor's.
"""

from __future__ import annotations

import time

import numpy as np

from coupling.model_adaptivity.adaptive_loop import Step, Strategy, adapt, full_model
from coupling.navier_stokes.flow import MixedFlow
from coupling.navier_stokes.newton import solve_robustly

from ... import loader
from ...kinds.adaptive_flow import build
from ...kinds.adaptive_flow.config import AdaptiveFlowScene
from ...kinds.adaptive_flow.geometry import channel_cavity
from ..report import Row
from . import partitions
from .costs import cost_rows
from .partitions import vorticity
from .picture import draw

__all__ = ["draw", "run"]

# [T fig. 7.3]: step -> printed error and fraction of Navier-Stokes elements.
PRINTED = {0: (-4.12e-2, 0.0), 1: (4.43e-3, 0.195), 2: (2.12e-3, 0.392), 4: (-2.56e-5, 0.743)}
PRINTED_1000 = 1.73


def run(quick: bool) -> list[Row]:
    """Rows of the benchmark; ``quick`` keeps meshes at h = 1/20 and leaves out the adapted one."""
    rows = _thesis_loop(20 if quick else 80)
    rows += _first_steps((20,) if quick else (20, 40))
    if not quick:
        rows.append(_first_step_adapted())
    rows += _loop_rows("Re = 1000", 1000.0, 20 if quick else 40, Strategy(tolerance=1e-9))
    rows.append(_linearised(10))
    for reynolds in (10.0, 100.0, 1000.0):
        rows += [_independence(reynolds, cells) for cells in ((10, 20) if quick else (10, 20, 40))]
    rows += partitions.partitioned_rows()
    rows += [
        partitions.boundary_row(name, n)
        for name in partitions.FIXED
        for n in ((5, 10) if quick else (5, 10, 20))
    ]
    rows += partitions.boundary_loops(10 if quick else 20)
    rows += cost_rows(20 if quick else 40)
    return rows


def steps_of(flow: MixedFlow, strategy: Strategy) -> list[Step]:
    """A whole loop with true errors."""
    goal = vorticity(flow)
    reference, _ = full_model(flow, goal)
    return list(adapt(flow, goal, strategy, reference=reference))


def _step_row(case: str, step: Step) -> Row:
    return {
        "case": f"{case}, step {step.index}",
        "seconds": sum(step.seconds.values()),
        "error": step.error_rel_j0,
        "reference": "full model, same mesh",
        "estimate": step.estimate,
        "thesis_eps": step.thesis_eps,
        "bound": step.bound,
        "bound/estimate": float(np.divide(step.bound, abs(step.estimate))),
        "effectivity": step.effectivity,
        "error_rel_J1": step.error,
        "elements": step.element_fraction,
        "volume": step.volume_fraction,
        "converged": step.solution.ok,
    }


def _thesis_loop(cells: int) -> list[Row]:
    """Re = 10, counting indicators, greedy 0.1: beside the printed figures."""
    strategy = Strategy(indicator="counting", tolerance=1e-12)
    began = time.process_time()
    steps = steps_of(build.flow_on(channel_cavity(cells), 10.0), strategy)
    seconds = time.process_time() - began
    rows = []
    for step in steps:
        eps, fraction = PRINTED.get(step.index, (np.nan, np.nan))
        rows.append(
            _step_row(f"Re = 10, h = 1/{cells}, counting", step)
            | {"printed": eps, "to printed": step.thesis_eps / eps - 1.0}
            | {"printed elements": fraction}
        )
    last = steps[-1]
    rows.append(_total(f"Re = 10, h = 1/{cells}, counting", last, seconds))
    return rows


def _total(case: str, last: Step, seconds: float) -> Row:
    return {
        "case": f"{case}: whole loop",
        "seconds": seconds,
        "error": last.error_rel_j0,
        "reference": "full model, same mesh",
        "bound": last.bound,
        "steps": last.index,
        "result": last.result.name.lower(),
        "peak_MB": peak_megabytes(),
    }


def peak_megabytes() -> float:
    """Largest resident memory of the process so far; NaN where the system does not tell."""
    try:
        import resource
    except ImportError:
        return float("nan")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def _first_row(case: str, flow: MixedFlow, discretisation: float) -> Row:
    began = time.process_time()
    (step,) = adapt(flow, vorticity(flow), Strategy(max_steps=0))
    return {
        "case": f"{case}, step 0",
        "seconds": time.process_time() - began,
        "error": step.thesis_eps / PRINTED_1000 - 1.0,
        "error_kind": "thesis_eps to the printed 1.73",
        "reference": "[T 7.4.3]",
        "thesis_eps": step.thesis_eps,
        "unknowns": flow.space.n,
        "discretisation": discretisation,
    }


def _first_steps(sizes: tuple[int, ...]) -> list[Row]:
    return [
        _first_row(f"Re = 1000, h = 1/{n}", build.flow_on(channel_cavity(n), 1000.0), np.nan)
        for n in sizes
    ]


def _first_step_adapted() -> Row:
    scene = loader.read("cavity-re1000")
    assert isinstance(scene, AdaptiveFlowScene)
    *_, level = build.levels(scene)
    n = level.flow.space.n_elements
    return _first_row(f"Re = 1000, {n} adapted triangles", level.flow, level.error / level.value)


def _loop_rows(case: str, reynolds: float, cells: int, strategy: Strategy) -> list[Row]:
    began = time.process_time()
    steps = steps_of(build.flow_on(channel_cavity(cells), reynolds), strategy)
    name = f"{case}, h = 1/{cells}, {strategy.indicator}"
    rows = [_step_row(name, step) for step in steps]
    return [*rows, _total(name, steps[-1], time.process_time() - began)]


def _linearised(cells: int) -> Row:
    """Frozen convection, linear goal: the estimate is exact."""
    flow = build.flow_on(channel_cavity(cells), 10.0)
    began = time.process_time()
    steps = steps_of(
        flow.with_wind(solve_robustly(flow, flow.everywhere).x), Strategy(tolerance=1e-4)
    )
    return {
        "case": f"linearised, h = 1/{cells}",
        "seconds": time.process_time() - began,
        "error": max(abs(step.effectivity - 1.0) for step in steps),
        "error_kind": "largest |effectivity - 1|",
        "reference": "exact: 1",
        "steps": len(steps),
    }


def _independence(reynolds: float, cells: int) -> Row:
    """What is needed for a tolerance, and the first estimate, on several meshes [T fig. 7.11]."""
    began = time.process_time()
    steps = steps_of(
        build.flow_on(channel_cavity(cells), reynolds),
        Strategy(indicator="counting", tolerance=1e-7),
    )
    good = [s for s in steps if s.solution.ok]
    return {
        "case": f"Re = {reynolds:g}, h = 1/{cells}, mesh independence",
        "seconds": time.process_time() - began,
        "error": good[0].error_rel_j0,
        "reference": "full model, same mesh; of step 0",
        "estimate": good[0].estimate,
        **{f"elements for {t:g}": _needed(good, t) for t in (1e-2, 1e-4, 1e-6)},
        "steps": len(steps),
        "_curve": [
            (s.element_fraction, s.volume_fraction, s.estimate, s.effectivity) for s in good
        ],
    }


def _needed(steps: list[Step], tolerance: float) -> float:
    """Smallest fraction of elements from which the bound stays below a tolerance."""
    above = [s.element_fraction for s in steps if s.bound > tolerance]
    below = [s.element_fraction for s in steps if s.element_fraction > max(above, default=-1.0)]
    return min(below, default=np.nan)
