"""Compressed solves of thin bags against dense ones with the same rule."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache

from hbem.flows.stokes_flow import StokesFlow
from hbem.solvers.saddle import DenseSaddle, IterativeSaddle
from hbem.surfaces.quadrature import QuadratureOrders

from ....geometry.pillows.pillow import PillowBag, accordion, round_bag
from .fields import FIELDS, Field, Trial, announced, away, resolves

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5)
SMALL, LARGE = "flat .02", "flat .01, 968 elements"
BAGS = {
    SMALL: lambda: round_bag(16, gap=0.02),
    "flat .05": lambda: round_bag(28, gap=0.05),
    "flat .01": lambda: round_bag(28, gap=0.01),
    "two folds": lambda: accordion(28, 2),
    LARGE: lambda: round_bag(44, gap=0.01),
}


def trials(quick: bool) -> Iterator[Trial]:
    """Each bag, tolerance and method: eight flows."""
    if quick:
        yield from _trials(SMALL, 1e-3, "h2", ("squeeze", "slide"))
        yield from _trials(SMALL, 1e-2, "aca", ("squeeze", "slide"))
        return
    for name in (b for b in BAGS if b != SMALL):
        for method in ("h2",) if name == LARGE else ("h2", "aca"):
            for tolerance in TOLERANCES:
                yield from _trials(name, tolerance, method, FIELDS)
        _dense.cache_clear()


@cache
def _dense(name: str, orders: QuadratureOrders) -> DenseSaddle | IterativeSaddle:
    """One factor for all that have the same rule."""
    bag = _bag(name)
    flow = StokesFlow(bag.patches(), orders=orders, compression="dense", measure="none")
    return flow.formulation.system


@cache
def _bag(name: str) -> PillowBag:
    return BAGS[name]()


def _trials(name: str, tolerance: float, method: str, fields: Iterable[str]) -> Iterator[Trial]:
    patches = _bag(name).patches()
    flow = StokesFlow(patches, tolerance=tolerance, compression=method, measure="operator")
    exact = _dense(name, flow.orders)
    for field in fields:
        case = f"{name}, {method} for {tolerance:g}, {field}"
        yield {"case": case} | _trial(flow, exact, FIELDS[field])


def _trial(flow: StokesFlow, exact: DenseSaddle | IterativeSaddle, field: Field) -> Trial:
    made = flow.formulation
    tested = flow.surface.project(field(flow.points)).ravel()
    data = made.data(tested)
    truth, plain = exact.solve(data).solution, made.system.solve(data)
    measured = flow.solver.decompressed(plain, tested)
    told = flow.solver.error(measured, flow.budget.krylov_error(measured.solved.residual))
    return {
        "promise": "compression",
        "tolerance": told.tolerance,
        "error": away(flow, measured.solved.solution, truth),
        "refused": announced(told, quadrature=0.0),
        "share": "compression",
        "estimate": told.compression + told.krylov,
        "before": measured.compression[0] / away(flow, plain.solution, truth),
        "resolved": resolves(flow, told),
    }
