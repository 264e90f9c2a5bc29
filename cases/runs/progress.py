"""News on the console: a live line on a terminal, one plain line a step in a pipe."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from ..output.recorder import Silent

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress as LiveBar

    from coupling import AcceptedStep, Iteration, Outcome, Rejection


class Progress(Silent):
    """Recorder that tells how far the run is.

    Parameters
    ----------
    console : rich.console.Console
        Live where it is a terminal.
    end : float
        End time of the run.
    volume : float
        Initial volume, for V/V0; taken from the first row if it is not given.
    """

    def __init__(self, console: Console, end: float, volume: float | None = None):
        self.console, self.end, self.volume = console, end, volume
        self._live: LiveBar | None = None
        self._told: set[str] = set()
        self._clock = time.perf_counter()

    def on_start(self, step: AcceptedStep) -> None:
        self.volume = step.row["volume"]
        self._show("start", step.state.t)

    def on_iteration(self, iteration: Iteration) -> None:
        if self.console.is_terminal:
            i = iteration
            self._show(f"step {i.step}  iteration {i.iteration}  residual {i.residual:.1e}")

    def on_accepted(self, step: AcceptedStep) -> None:
        row = step.row
        self.volume = self.volume or row["volume"]
        where = f"step {step.step:4d}  t = {step.state.t:<8.6g}"
        grown = f"V/V0 = {row['volume'] / self.volume:.4f}  p = {row['pressure']: .4e}"
        if self.console.is_terminal:
            self._show(f"{where} {grown}", step.state.t)
        else:
            count = f"iterations {row['subiterations']:2d}  {self._elapsed():6.1f} s"
            print(f"{where} dt = {row['dt']:<7.5g} {grown}  {count}", flush=True)

    def on_rejected(self, rejection: Rejection) -> None:
        r = rejection
        self._line(f"step {r.step:4d}  dt = {r.dt:g} rejected ({r.cause.name}); dt is halved")

    def on_note(self, step: int, text: str) -> None:
        """The first note of its kind; run.json counts them all."""
        kind = text.split(":")[0].split(" = ")[0]
        if kind not in self._told:
            self._told.add(kind)
            self._line(f"step {step:4d}  {text}")

    def close(self, outcome: Outcome) -> None:
        self.stop()

    def stop(self) -> None:
        """Take the live line off the terminal; safe to call twice."""
        if self._live is not None:
            self._live.stop()
            self._live = None

    def _elapsed(self) -> float:
        return time.perf_counter() - self._clock

    def _line(self, text: str) -> None:
        if self._live is not None:
            self._live.console.print(text, highlight=False, markup=False)
        else:
            print(text, flush=True)

    def _show(self, text: str, t: float | None = None) -> None:
        if not self.console.is_terminal:
            return
        if self._live is None:
            self._live = self._started()
        self._live.update(self._live.task_ids[0], description=text)
        if t is not None:
            self._live.update(self._live.task_ids[0], completed=t)

    def _started(self) -> LiveBar:
        from rich import progress

        live = progress.Progress(
            progress.BarColumn(bar_width=12),
            progress.TaskProgressColumn(),
            progress.TextColumn("{task.description}", markup=False),
            progress.TimeElapsedColumn(),
            console=self.console,
        )
        live.add_task("", total=self.end)
        live.start()
        return live
