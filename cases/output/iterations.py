"""iterations.log (one line an attempted step) and convergence.log (one line a subiteration).

Columns as preCICE writes them, so that its scripts read ours; rejected attempts say why.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from .recorder import Silent

if TYPE_CHECKING:
    from coupling import AcceptedStep, Iteration, Rejection

STEPS = "TimeWindow  TotalIterations  Iterations  Convergence  Time  Dt  Cause"
RESIDUALS = "TimeWindow  Iteration  Time  Dt  Relaxation  ResRel(Displacement)"


class Iterations(Silent):
    """Recorder of both logs in a folder; subiterations are written when their step ends."""

    def __init__(self, folder: Path):
        self.steps = folder / "iterations.log"
        self.residuals = folder / "convergence.log"
        self._total = 0
        self._pending: list[str] = []

    def on_iteration(self, iteration: Iteration) -> None:
        i = iteration
        self._pending.append(
            f"{i.step:10d}  {i.iteration:9d}  {i.t:.8e}  {i.dt:.8e}  {i.relaxation: .8e}  "
            f"{i.residual:.8e}\n"
        )

    def on_accepted(self, step: AcceptedStep) -> None:
        count = int(step.row.get("subiterations", len(self._pending)))
        self._finish(step.step, count, 1, step.state.t, step.row.get("dt", 0.0), "-")

    def on_rejected(self, rejection: Rejection) -> None:
        r = rejection
        self._finish(r.step, r.iterations, 0, r.t, r.dt, r.cause.name)

    def take_up(self) -> None:
        """Go on with the count of an earlier session."""
        if self.steps.exists():
            lines = self.steps.read_text(encoding="utf-8").splitlines()[1:]
            self._total = int(lines[-1].split()[1]) if lines else 0

    def _finish(self, step: int, count: int, ok: int, t: float, dt: float, cause: str) -> None:
        self._total += count
        _append(self.residuals, RESIDUALS, "".join(self._pending))
        self._pending.clear()
        line = f"{step:10d}  {self._total:15d}  {count:10d}  {ok:11d}  {t:.8e}  {dt:.8e}  {cause}\n"
        _append(self.steps, STEPS, line)


def _append(path: Path, header: str, text: str) -> None:
    start = "" if path.exists() and path.stat().st_size else header + "\n"
    with open(path, "a", encoding="utf-8") as file:
        file.write(start + text)
