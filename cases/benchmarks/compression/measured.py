"""A solve that measures its compression's error, beside one that trusts a finer operator.

Both on one thread, in processor seconds: operator, preconditioner and one solve. The reference is
the measured solution corrected by exact sums until its corrections vanish.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np

from hbem._threads_kernels import limited
from hbem.flows.measured_solve import MeasuredSolve
from hbem.flows.stokes_flow import StokesFlow
from hbem.layers.direct_layer import DirectSingleLayer
from hbem.solvers.saddle_system import SaddleSolution

from ...geometry.pillows.pillow import PillowBag, round_bag
from ..integrals.gaps import relative
from ..report import Row

TRACTION = 1e-3
FLOWS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "squeeze": lambda x: x * [1.0, 1.0, -2.0],
    "slide": lambda x: np.broadcast_to([1.0, 0.0, 0.0], x.shape),
}
CONVERGED = 1e-9  # asked of the reference's corrections; they end where they no longer shrink


def measured_rows(n_s: int, gap: float) -> list[Row]:
    """Rows of a disc bag, one for each flow."""
    return list(_rows(n_s, gap))


def _rows(n_s: int, gap: float) -> Iterator[Row]:
    bag = round_bag(n_s, gap=gap)
    with limited(1) as threads:
        measured, measured_build = _flow(bag, "operator")
        trusting, trusting_build = _flow(bag, "none")
        for name, velocity in FLOWS.items():
            tested = measured._tested(velocity(measured.points))
            began = time.process_time()
            found = measured.solver.solve(*tested, quadrature=False)
            seconds = measured_build + time.process_time() - began
            began = time.process_time()
            plain = trusting.formulation.system.solve(trusting.formulation.data(*tested))
            peer = trusting_build + time.process_time() - began
            exact = _reference(measured, found.solved, *tested)
            error = measured.solver.error(found, 0.0)
            compression = measured.compression
            assert compression is not None
            yield {
                "case": f"measured solve, thinness {gap:g}, {name}",
                "seconds": seconds,
                "error": relative(measured.surface, found.solved.solution, exact),
                "tolerance": TRACTION,
                "unknowns": 3 * measured.patches.n_dofs,
                "operator at": compression.tolerance,
                "corrections": len(found.compression),
                "estimate": error.compression + error.krylov,
                "peer": "the budget's matrix tolerance, nothing measured",
                "peer_seconds": peer,
                "CPU ratio": seconds / peer,
                "error unmeasured": relative(measured.surface, plain.solution, exact),
                "threads": threads,
                "reference": "corrected by exact sums until corrections vanish",
            }


def _flow(bag: PillowBag, measure: str) -> tuple[StokesFlow, float]:
    """A flow with operator and preconditioner, and the processor seconds of these."""
    began = time.process_time()
    flow = StokesFlow(bag.patches(), tolerance=TRACTION, compression="h2", measure=measure)
    flow.formulation.system.prepare()
    return flow, time.process_time() - began


def _reference(
    flow: StokesFlow, solved: SaddleSolution, tested: np.ndarray, background: np.ndarray | float
) -> np.ndarray:
    """Solution of the operator with exact sums."""
    solver = MeasuredSolve(flow.formulation, CONVERGED)
    solver._sharp = DirectSingleLayer(flow.surface, flow.formulation.layer.near)
    return solver.decompressed(solved, tested, background).solved.solution
