"""A run of the time loop, recorded in a folder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..kinds.kind import TimeKind
from ..output.atomic import RecordError
from ..output.checkpoint import (
    CHECKPOINT,
    Checkpoint,
    read_arrays,
    scene_hash,
    snapshot_of,
    unlike,
)
from ..output.history import History, read_history
from ..output.iterations import Iterations
from ..output.run_record import RunRecord
from ..output.seals import Seals, only_begun
from ..output.vtk import LIST, Fields
from ..sections import TimedScene
from .folder import Finished
from .pictures import draw_at_end
from .progress import Progress

if TYPE_CHECKING:
    from rich.console import Console

    from coupling import Recorder, Snapshot

    from ..kinds.simulated import Simulated


@dataclass
class _Recorders:
    """The recorders of a folder, in the order in which they must write."""

    history: History
    iterations: Iterations
    record: RunRecord
    checkpoint: Checkpoint
    progress: Progress
    fields: Fields | None = field(default=None)

    @classmethod
    def of(
        cls, scene: TimedScene, folder: Path, console: Console, record: RunRecord, seals: Seals
    ) -> _Recorders:
        return cls(
            History(folder / "history.csv", scene.physical),
            Iterations(folder),
            record,
            Checkpoint(folder, scene, seals),
            Progress(console, scene.time.end),
        )

    def in_order(self) -> list[Recorder]:
        """The checkpoint last of the files it must not run ahead of.

        News before the record, which measures the traction's error: that takes as long as a step.
        """
        files = [self.history, self.iterations, self.fields, self.checkpoint]
        found = [*files, self.progress, self.record]
        return [recorder for recorder in found if recorder is not None]


def run_in_time(
    kind: TimeKind,
    scene: TimedScene,
    folder: Path,
    console: Console,
    tolerances: Mapping[str, Any] | None = None,
    *,
    resume: bool,
) -> Finished:
    """Run a scene in time and record it in a folder.

    Raises
    ------
    RecordError
        A checkpoint of another scene, or a damaged folder.
    """
    snapshot, seals, lost = _saved(scene, folder) if resume else (None, Seals(folder), [])
    record = RunRecord(folder / "run.json", scene, tolerances)
    recorders = _Recorders.of(scene, folder, console, record, seals)
    try:
        with record.kept_on_failure():
            if snapshot is None:
                record.write()
            with record.phase("build"):
                simulated = kind.simulated(scene)
                if snapshot is not None:
                    _refuse_unlike(snapshot, simulated)
                _tell(simulated, lost, record, console)
                recorders.fields = _fields(simulated, seals)
                if resume:
                    _take_up(recorders, seals, snapshot)
                record.write()
                simulation = simulated.simulation(recorders.in_order())
                record.compression = getattr(simulation.fluid, "statistics", {})
                _contraction(simulated, record, console)
            with record.phase("run"):
                outcome = simulation.run(snapshot)
            if simulated.accuracy is not None and simulated.accuracy.worst:
                said = f"traction error, largest along the run: {simulated.accuracy.so_far()}"
                console.print(said, markup=False, highlight=False)
            return Finished(outcome, draw_at_end(scene, folder, record, console))
    except KeyboardInterrupt:
        saved = recorders.checkpoint.saved
        return Finished(None, saved=f"step {saved.step}, t = {saved.state.t:g}" if saved else "")
    finally:
        recorders.progress.stop()


def _saved(scene: TimedScene, folder: Path) -> tuple[Snapshot | None, Seals, list[str]]:
    """What a folder can be continued from, and what it has lost beside; nothing is changed."""
    file = folder / CHECKPOINT
    if not file.exists():
        return None, Seals(folder), [only_begun(folder, rows=1)]
    arrays = read_arrays(file, scene_hash(scene))
    seals = Seals(folder, arrays)
    snapshot, lost = snapshot_of(arrays), seals.verify()
    row = seals.last_row()
    if (float(row["step"]), float(row["t"])) != (snapshot.step, snapshot.state.t):
        raise RecordError(
            f"{CHECKPOINT} is of step {snapshot.step}, t = {snapshot.state.t:g}; the row of "
            f"history.csv at it is of step {row['step']}, t = {row['t']}"
        )
    return snapshot, seals, lost


def _refuse_unlike(snapshot: Snapshot, simulated: Simulated) -> None:
    memory = simulated.scheme.init()
    if wrong := unlike(snapshot, simulated.initial, memory, simulated.scene.time.end):
        raise RecordError(f"{CHECKPOINT} cannot be continued from: {'; '.join(wrong)}")


def _tell(simulated: Simulated, lost: list[str], record: RunRecord, console: Console) -> None:
    """Warnings of the accuracy, what is left out, and what an earlier session has lost."""
    if simulated.accuracy is not None:
        record.expect(simulated.accuracy)
        for warning in simulated.accuracy.budget.warnings:
            console.print(f"warning: {warning}", markup=False, highlight=False)
    for what in [*simulated.skips, *lost]:
        record.skip(what)
        console.print(f"skipped: {what}", markup=False, highlight=False)


def _take_up(recorders: _Recorders, seals: Seals, snapshot: Snapshot | None) -> None:
    """Cut the records of an earlier session back to its checkpoint."""
    seals.restore()
    recorders.iterations.take_up()
    if snapshot is not None:
        recorders.checkpoint.mark(snapshot.step)
        recorders.progress.volume = float(read_history(recorders.history.path)["volume"][0])


def _contraction(simulated: Simulated, record: RunRecord, console: Console) -> None:
    """rho before and measured, where the scheme is chosen by it (costs one assembly)."""
    from coupling.schemes.automatic import Automatic

    scheme, dt = simulated.scheme, simulated.scene.time.dt
    if not isinstance(scheme, Automatic):
        return
    measured = simulated.measured_contraction()
    record.contraction(scheme.rate * dt, measured)
    console.print(
        f"contraction rho: {scheme.rate * dt:.3g} a priori, {measured:.3g} measured at the start; "
        f"below {scheme.limit:g} iqn-ils, else implicit (measured again on the way)",
        markup=False,
        highlight=False,
    )


def _fields(simulated: Simulated, seals: Seals) -> Fields | None:
    o = simulated.scene.output
    if not o.fields_every:
        return None
    return Fields(
        seals.folder / LIST,
        simulated.sampler,
        seals.frames,
        every=o.fields_every,
        tessellate=o.tessellate,
        traction=simulated.fluid is not None,
    )
