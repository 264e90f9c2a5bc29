"""Runs and their folders: start one, resume it from its checkpoint, draw its pictures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from .. import loader
from ..kinds.inflation.accuracy import Accuracy
from ..kinds.inflation.config import Scene
from ..kinds.adaptive_flow import run as flow_run
from ..kinds.inflation.animation import animation
from ..output.atomic import (remove_parts, replacing)
from ..output.checkpoint import (Checkpoint, CheckpointError, load, scene_hash)
from ..kinds.inflation.comparison import comparison
from ..output.history import (History, read_history)
from ..output.iterations import Iterations
from ..kinds.inflation.picture import (NoPicture, overview)
from ..output.progress import Progress
from ..output.run_record import RunRecord
from ..output.vtk import Fields
from ..kinds.load_path import run as shell_run

if TYPE_CHECKING:
    from rich.console import Console

    from coupling.protocols import (Outcome, Recorder, Snapshot)


# Kinds without time: modules with Start, load, CheckpointError and run.
STEPWISE: Mapping[str, ModuleType] = {"model-adaptivity": flow_run, "shell": shell_run}


class FolderError(ValueError):
    """A run folder that cannot be used, with the remedy."""


@dataclass(frozen=True)
class Finished:
    """How a run ended: the outcome (None if the user stopped it) and its picture, if any."""

    outcome: Outcome | None
    picture: Path | None = None


def new_folder(scene: Scene, out: str | Path | None) -> Path:
    """The folder of a new run: ``out``, or the next free ``runs/<scene>-<n>``.

    Raises
    ------
    FolderError
        If it exists and is not empty.
    """
    if out is None:
        n = 1
        while (folder := Path("runs") / f"{scene.name}-{n}").exists():
            n += 1
    else:
        folder = Path(out)
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise FolderError(
                f"{folder} exists and is not empty; choose another --out, remove it, "
                f"or continue the run in it: airfold resume {folder}"
            )
    return folder


def start(
    scene: Scene,
    folder: Path,
    console: Console,
    *,
    tolerances: Mapping[str, Any] | None = None,
) -> Finished:
    """Run a scene from its beginning into an empty folder."""
    folder.mkdir(parents=True, exist_ok=True)
    with replacing(folder / "run.toml") as file:
        file.write(loader.write(scene))
    if scene.kind in STEPWISE:
        return _run_stepwise(scene, folder, console, STEPWISE[scene.kind].Start())
    return _run(scene, folder, console, tolerances=tolerances)


def resume(
    folder: Path, console: Console, *, tolerances: Mapping[str, Any] | None = None
) -> Finished:
    """Continue the run of a folder from its checkpoint; records are cut back to it first.

    Raises
    ------
    FolderError
        No run there, or a checkpoint of another scene.
    loader.SceneError
        A run.toml that was edited into something wrong.
    """
    if not (folder / "run.toml").exists():
        raise FolderError(f"{folder} holds no run.toml; start a run there: airfold run SCENE --out")
    scene = loader.read(folder / "run.toml")
    if stepwise := STEPWISE.get(scene.kind):
        try:
            remove_parts(folder)
            return _run_stepwise(scene, folder, console, stepwise.load(folder, scene))
        except stepwise.CheckpointError as error:
            raise FolderError(f"{folder}: {error}") from error
    snapshot, file = None, folder / "checkpoint.npz"
    if file.exists():
        try:
            snapshot = load(file, scene_hash(scene))
        except CheckpointError as error:
            raise FolderError(f"{folder}: {error}") from error
    remove_parts(folder)
    return _run(scene, folder, console, snapshot, tolerances)


def draw(folder: Path) -> Path:
    """Draw overview.png of a run folder, for planar runs also animation.gif.

    Raises
    ------
    FolderError
        Nothing to draw there.
    """
    if not (folder / "history.csv").exists():
        raise FolderError(f"{folder} holds no history.csv; is it a run folder?")
    try:
        if loader.read(folder / "run.toml").kind == "planar":
            from ..kinds.planar.picture import animation

            animation(folder)
        return _picture_of(folder)(folder)
    except NoPicture as error:
        raise FolderError(str(error)) from error


def _picture_of(folder: Path) -> Callable[[Path], Path]:
    """What draws the runs of the folder's kind."""
    kind = loader.read(folder / "run.toml").kind
    if kind == "model-adaptivity":
        from ..kinds.adaptive_flow.picture import overview as flow_overview

        return flow_overview
    if kind == "shell":
        from ..kinds.load_path.picture import overview as shell_overview

        return shell_overview
    if kind == "planar":
        from ..kinds.planar.picture import overview as planar_overview

        return planar_overview
    return overview


def animate(folder: Path) -> Path:
    """Draw animation.gif of a run folder.

    Raises
    ------
    FolderError
        Nothing to draw there.
    """
    try:
        return animation(folder)
    except NoPicture as error:
        raise FolderError(str(error)) from error


def compare(folder: Path, other: Path) -> Path:
    """Draw beside.png in ``folder``: cuts of both runs at equal volumes.

    Raises
    ------
    FolderError
        One of them holds no run, or nothing to draw.
    """
    for run in (folder, other):
        if not (run / "history.csv").exists():
            raise FolderError(f"{run} holds no history.csv; is it a run folder?")
    try:
        return comparison(folder / "beside.png", [(folder, other)])
    except NoPicture as error:
        raise FolderError(str(error)) from error


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
        cls, scene: Scene, folder: Path, console: Console, tolerances: Mapping[str, Any] | None
    ) -> _Recorders:
        accuracy = Accuracy.of(scene)
        for warning in accuracy.budget.warnings if accuracy else ():
            console.print(f"warning: {warning}", markup=False, highlight=False)
        return cls(
            History(folder / "history.csv", scene.physical),
            Iterations(folder),
            RunRecord(folder / "run.json", scene, tolerances, accuracy),
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


def _run(
    scene: Scene,
    folder: Path,
    console: Console,
    snapshot: Snapshot | None = None,
    tolerances: Mapping[str, Any] | None = None,
) -> Finished:
    resuming = (folder / "history.csv").exists()
    recorders = _Recorders.of(scene, folder, console, tolerances)
    record = recorders.record
    try:
        record.write()
        with record.phase("build"):
            build = _factory(scene)
            for what in build.skipped(scene):
                record.skip(what)
                console.print(f"skipped: {what}", markup=False, highlight=False)
            recorders.fields = _fields(scene, folder, build)
            if resuming:
                recorders.cut_back(snapshot.step if snapshot else -1)
            if snapshot is not None and resuming:
                start_volume = read_history(folder / "history.csv")["volume"][:1]
                recorders.progress.volume = float(start_volume[0]) if start_volume.size else None
            simulation = build.simulation(scene, recorders.in_order())
            record.compression = getattr(simulation.fluid, "statistics", {})
            _contraction(scene, build, record, console)
        with record.phase("run"):
            outcome = simulation.run(snapshot)
        return Finished(outcome, _picture(scene, folder, record))
    except KeyboardInterrupt:
        record.broken_off("interrupted")
        return Finished(None)
    except Exception as error:
        record.broken_off(f"failed: {type(error).__name__}: {error}")
        raise
    finally:
        recorders.progress.stop()


def _contraction(scene: Scene, build: ModuleType, record: RunRecord, console: Console) -> None:
    """rho before and measured, where the scheme is chosen by it (costs one assembly)."""
    if scene.coupling.scheme != "auto" or not hasattr(build, "measured_contraction"):
        return
    if scene.fluid.model != "stokes":
        return
    scheme = build.chosen(scene)
    measured = build.measured_contraction(scene)
    record.contraction(scheme.rate * scene.time.dt, measured)
    console.print(
        f"contraction rho: {scheme.rate * scene.time.dt:.3g} a priori, {measured:.3g} measured at "
        f"the start; below {scheme.limit:g} iqn-ils, else implicit (measured again on the way)",
        markup=False,
        highlight=False,
    )


def _factory(scene: Scene) -> ModuleType:
    """What builds scenes of this kind for the one time loop."""
    if scene.kind == "planar":
        from ..kinds.planar import build
    elif scene.kind == "capsule":
        from ..kinds.capsule import build
    else:
        from ..kinds.inflation import build
    return build


def _run_stepwise(scene: Any, folder: Path, console: Console, start: Any) -> Finished:
    """A run without the time loop: its kind's module takes the steps."""
    record = RunRecord(folder / "run.json", scene)
    try:
        outcome = STEPWISE[scene.kind].run(scene, folder, console, record, start)
        record.ended(outcome)
        return Finished(outcome, _picture(scene, folder, record))
    except KeyboardInterrupt:
        record.broken_off("interrupted")
        return Finished(None)
    except Exception as error:
        record.broken_off(f"failed: {type(error).__name__}: {error}")
        raise


def _fields(scene: Scene, folder: Path, build: Any) -> Fields | None:
    o = scene.output
    if not o.fields_every:
        return None
    return Fields(
        folder / "fields.pvd",
        build.fields(scene),
        every=o.fields_every,
        tessellate=o.tessellate,
        traction=scene.fluid.model != "pressure",
    )


def _picture(scene: Scene, folder: Path, record: RunRecord) -> Path | None:
    """overview.png; a picture that fails must not lose a run that succeeded."""
    path = None
    if not (scene.output.picture and scene.output.fields_every):
        record.skip("overview.png: switched off by output.picture or output.fields_every")
    else:
        try:
            with record.phase("picture"):
                path = _picture_of(folder)(folder)
        except Exception as error:
            record.skip(f"overview.png: {type(error).__name__}: {error}")
    record.write()
    return path
