"""The run of the trials, and the verdict on what becomes of its folder.

The runs are the smallest that have everything: a bag without fluid and a load path, four steps.
"""

from __future__ import annotations

import io
import shutil
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any
from unittest.mock import patch

from ... import loader
from ...output.vtk import read_frames
from ...sections import SceneError
from .damage import files, sessions

Trial = dict[str, Any]
CONSOLE = "cases.cli"  # by its name: it is what is tried, and stands above benchmarks


def _scene(name: str, *items: str) -> list[str]:
    items = (*items, "output.fields_every=1", "output.picture=false")
    return [name, *(word for item in items for word in ("--set", item))]


SCENE = _scene(
    "pancake-pressure",
    *("mesh.degree=2", "mesh.around=4", "time.dt=8", "time.end=32", "output.checkpoint_every=2"),
)
PATH = _scene("cantilever-shear", "load.steps=4")
COPIED_AT = 3  # step at which a folder is copied
PATIENCE = 60  # seconds until a trial counts as an endless loop


@dataclass(frozen=True)
class Answer:
    """What the console did: exit code (None: a traceback), output, errors."""

    code: int | None
    out: str
    err: str

    @property
    def refused(self) -> bool:
        """Whether it ended with exit code 1 or 2 and one message (one a mistake of a scene)."""
        lines = self.err.splitlines()
        return self.code in (1, 2) and bool(lines) and all(x.startswith("error: ") for x in lines)


class _Endless(BaseException):
    pass


@contextmanager
def _patience() -> Iterator[None]:
    """Break a trial off that does not end, where the system can."""
    if not hasattr(signal, "SIGALRM"):
        yield
        return

    def stop(number: int, frame: object) -> None:
        raise _Endless

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(PATIENCE)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def console(*words: str, out: io.TextIOBase | None = None) -> Answer:
    """Run the console in this process, without waiting for the disk: no trial cuts the power."""
    output, errors = out or io.StringIO(), io.StringIO()
    code: int | None
    try:
        with _patience(), patch("os.fsync"), redirect_stdout(output), redirect_stderr(errors):
            code = import_module(CONSOLE).main(words)
    except (Exception, _Endless, SystemExit) as error:
        code = None
        errors.write(f"{type(error).__name__}: {error}")
    text = output.getvalue() if isinstance(output, io.StringIO) else ""
    return Answer(code, text, errors.getvalue())


@dataclass(frozen=True)
class TriedRun:
    """A run that was left alone, and its folder as a kill between two checkpoints leaves it.

    Attributes
    ----------
    whole, cut : Path
    step : int
        Of the copy's checkpoint.
    time : float
        Of the frame at that step.
    """

    whole: Path
    cut: Path
    step: int
    time: float

    @classmethod
    def made(cls, place: Path, scene: Sequence[str], step: int, time: float) -> TriedRun:
        """Run it once; the copy is taken when the console tells of a step."""
        tried = cls(place / f"whole-{scene[0]}", place / f"cut-{scene[0]}", step, time)

        class Witness(io.StringIO):
            def write(self, text: str) -> int:
                if f"step {COPIED_AT:4d}" in text:
                    shutil.copytree(tried.whole, tried.cut)
                return super().write(text)

        answer = console("run", *scene, "--out", str(tried.whole), out=Witness())
        assert answer.code == 0, answer.err
        return tried

    @classmethod
    def inflated(cls, place: Path) -> TriedRun:
        """A bag without fluid, a checkpoint every other step."""
        return cls.made(place, SCENE, 2, 16.0)

    @classmethod
    def loaded(cls, place: Path) -> TriedRun:
        """A load path, a checkpoint every step."""
        return cls.made(place, PATH, COPIED_AT, COPIED_AT / 4)

    def copied(self, place: Path) -> Path:
        """A new folder to damage."""
        return Path(shutil.copytree(self.cut, place))


def lost(tried: TriedRun, folder: Path, news: str, before: int = 1) -> list[str]:
    """Records that a resumed run has lost against the one left alone, and that it did not tell.

    Parameters
    ----------
    tried : TriedRun
    folder : Path
    news : str
        What the console said.
    before : int
        Least number of sessions in run.json before.
    """
    whole = tried.whole
    try:
        same = loader.read(folder / "run.toml") == loader.read(whole / "run.toml")
    except SceneError:
        same = False
    names = ["history.csv", "iterations.log", "convergence.log"]
    last = None if same else tried.step
    different = [name for name in names if not _kept(whole / name, folder / name, last)]
    frames = read_frames(folder / "fields.pvd")
    wanted = [f for f in read_frames(whole / "fields.pvd") if same or f[0] <= tried.time]
    if not all(
        frame in frames and (folder / frame[1]).read_bytes() == (whole / frame[1]).read_bytes()
        for frame in wanted
    ):
        different.append("field files")
    if sessions(folder) <= before and "the run begins anew" not in news:
        different.append("run.json")
    announced = [line for line in news.splitlines() if line.startswith("skipped: ")]
    return [name for name in different if not any(name in line for line in announced)]


def _kept(whole: Path, found: Path, step: int | None) -> bool:
    """Whether all rows are there; with another scene (a later end), those up to a step."""
    a, b = (rows_of(path) for path in (whole, found))
    if step is None:
        return a == b
    kept = [row for row in a[1:] if int(row[0].split()[0]) <= step]
    return b[1 : len(kept) + 1] == kept


def rows_of(path: Path) -> list[list[str]]:
    """Rows of a history without the wall time, or lines of a log; none of a missing file."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    return [line.split(",")[:-1] if path.suffix == ".csv" else [line] for line in lines]


def content(folder: Path) -> dict[str, bytes]:
    """Bytes of all files but the lock; a refused folder must keep them."""
    return {name: (folder / name).read_bytes() for name in files(folder)}


def resumed(
    tried: TriedRun, folder: Path, before: dict[str, bytes] | None = None, known: int = 1
) -> Trial:
    """Verdict on a resume: all records of the whole run, or one message and nothing touched.

    Parameters
    ----------
    tried : TriedRun
    folder : Path
    before : mapping, optional
        The folder's `content`; without it a refusal is no good answer.
    known : int
        Least number of sessions in run.json.
    """
    answer = console("resume", str(folder))
    if answer.code == 0:
        gone = lost(tried, folder, answer.out, known)
        return {"held": not gone, "silent": bool(gone), "detail": ", ".join(gone) or "completed"}
    detail = answer.err.strip().replace(str(folder), "DIR")
    untouched = before is not None and content(folder) == before
    held = answer.refused and untouched
    return {
        "held": held,
        "silent": False,
        "detail": detail if untouched else f"not untouched: {detail}",
    }


def told(promise: str, case: str, answer: Answer, good: Sequence[int] = ()) -> Trial:
    """Verdict on an answer: one of the good codes, or one message."""
    held = answer.code in good or answer.refused
    detail = answer.err.strip() or f"exit code {answer.code}"
    return {"promise": promise, "case": case, "held": held, "silent": False, "detail": detail}
