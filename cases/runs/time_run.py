"""A run of the time loop, recorded in a folder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..kinds.kind import TimeKind
from ..output.checkpoint import Checkpoint, load, scene_hash
from ..output.history import History, read_history
from ..output.iterations import Iterations
from ..output.progress import Progress
from ..output.run_record import RunRecord
from ..output.vtk import Fields
from ..sections import TimedScene
from .folder import Finished
from .pictures import draw_at_end

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
    def of(cls, scene: TimedScene, folder: Path, console: Console, record: RunRecord) -> _Recorders:
        return cls(
            History(folder / "history.csv", scene.physical),
            Iterations(folder),
            record,
            Checkpoint(folder / "checkpoint.npz", scene),
            Progress(console, scene.time.end),
        )

    def in_order(self) -> list[Recorder]:
        """The checkpoint last of the files it must not run ahead of."""
        files = [self.history, self.iterations, self.fields, self.checkpoint, self.record]
        return [recorder for recorder in [*files, self.progress] if recorder is not None]

    def cut_back(self, step: int) -> None:
        for recorder in (self.history, self.iterations, self.fields):
            if recorder is not None:
                recorder.cut_back(step)


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
    CheckpointError
        A checkpoint of another scene, or an unreadable one.
    """
    snapshot, file = None, folder / "checkpoint.npz"
    if resume and file.exists():
        snapshot = load(file, scene_hash(scene))
    record = RunRecord(folder / "run.json", scene, tolerances)
    recorders = _Recorders.of(scene, folder, console, record)
    try:
        with record.kept_on_failure():
            record.write()
            with record.phase("build"):
                simulated = kind.simulated(scene)
                _tell(simulated, record, console)
                recorders.fields = _fields(simulated, folder)
                _take_up(recorders, folder, snapshot)
                simulation = simulated.simulation(recorders.in_order())
                record.compression = getattr(simulation.fluid, "statistics", {})
                _contraction(simulated, record, console)
            with record.phase("run"):
                outcome = simulation.run(snapshot)
            return Finished(outcome, draw_at_end(scene, folder, record))
    except KeyboardInterrupt:
        return Finished(None)
    finally:
        recorders.progress.stop()


def _tell(simulated: Simulated, record: RunRecord, console: Console) -> None:
    """Warnings of the accuracy, and what is left out."""
    if simulated.accuracy is not None:
        record.expect(simulated.accuracy)
        for warning in simulated.accuracy.budget.warnings:
            console.print(f"warning: {warning}", markup=False, highlight=False)
    for what in simulated.skips:
        record.skip(what)
        console.print(f"skipped: {what}", markup=False, highlight=False)


def _take_up(recorders: _Recorders, folder: Path, snapshot: Snapshot | None) -> None:
    """Cut the records of an earlier session back to its checkpoint."""
    if not (folder / "history.csv").exists():
        return
    recorders.cut_back(snapshot.step if snapshot else -1)
    if snapshot is not None:
        start_volume = read_history(folder / "history.csv")["volume"][:1]
        recorders.progress.volume = float(start_volume[0]) if start_volume.size else None


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


def _fields(simulated: Simulated, folder: Path) -> Fields | None:
    o = simulated.scene.output
    if not o.fields_every:
        return None
    return Fields(
        folder / "fields.pvd",
        simulated.sampler,
        every=o.fields_every,
        tessellate=o.tessellate,
        traction=simulated.fluid is not None,
    )
