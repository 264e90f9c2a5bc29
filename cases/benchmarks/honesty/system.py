"""What the system does to a run: a full disk, no permission, a closed pipe, signals."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from ...output.checkpoint import CHECKPOINT, load
from .verdict import SCENE, Answer, Trial, TriedRun, console, resumed, rows_of, told

FULL, KILLS, STOPS = 24, 20, 6
TOUCHES = 105  # so often a run touches its files
NOBODY = 65534  # a user without rights, where the trials run as root
ROOT = Path(__file__).resolve().parents[3]


def consoles(tried: TriedRun, place: Path, quick: bool) -> Iterator[Trial]:
    """Consoles that lack letters, were closed, or are full."""
    plain = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    yield told("console", "ASCII only", console("list", out=plain), good=[0])
    run = ("run", *SCENE, "--set", "description='β → ∞'", "--out", str(place / "β"))
    plain = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    yield told("console", "a run, ASCII only", console(*run, out=plain), good=[0])
    reading, writing = os.pipe()
    os.close(reading)
    with open(writing, "w", encoding="utf-8") as pipe:
        yield _quiet("closed pipe", console("list", out=pipe))
    words = ("run", *SCENE, "--out", str(place / "piped"))
    yield _quiet("pipe closed in a run", console(*words, out=_Closing()))
    yield {"promise": "console", "case": "resume afterwards"} | resumed(tried, place / "piped")
    if os.path.exists("/dev/full"):
        with open("/dev/full", "w", encoding="utf-8") as device:
            yield told("console", "full device", console("list", out=device))


class _Closing(io.StringIO):
    """A pipe whose other end is closed after some lines."""

    def write(self, text: str) -> int:
        if self.tell() > 400:
            raise BrokenPipeError
        return super().write(text)


def _quiet(case: str, answer: Answer) -> Trial:
    """Nobody listens any more: no message is wanted."""
    held = answer.code == 1 and not answer.err
    detail = answer.err.strip() or f"exit code {answer.code}"
    return {"promise": "console", "case": case, "held": held, "silent": False, "detail": detail}


def forbidden(tried: TriedRun, place: Path, quick: bool) -> Iterator[Trial]:
    """Folders that may be read only."""
    if not hasattr(os, "geteuid"):
        return
    folder = tried.copied(place / "forbidden")
    for path in (*folder.rglob("*"), folder):
        path.chmod(0o555 if path.is_dir() else 0o444)
    (place / "closed").mkdir(mode=0o555)
    new = str(place / "closed" / "run")
    with _without_rights(place):
        answers = {
            "resume": console("resume", str(folder)),
            "report": console("report", str(folder)),
            "run below": console("run", *SCENE, "--out", new),
            "run into": console("run", *SCENE, "--out", str(place / "closed")),
        }
    for path in (folder, *folder.rglob("*")):
        path.chmod(0o755)
    for case, answer in answers.items():
        yield told("read-only folder", case, answer)
    yield {"promise": "read-only folder", "case": "resume afterwards"} | resumed(tried, folder)


@contextmanager
def _without_rights(place: Path) -> Iterator[None]:
    """Root may write anywhere: be nobody meanwhile."""
    if os.geteuid() != 0:
        yield
        return
    place.chmod(0o755)
    os.seteuid(NOBODY)
    try:
        yield
    finally:
        os.seteuid(0)


def full(tried: TriedRun, place: Path, quick: bool) -> Iterator[Trial]:
    """A disk that takes only so many bytes of a file, then has room again."""
    try:
        import resource
    except ImportError:
        return
    rng = np.random.default_rng(4)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    largest = max(path.stat().st_size for path in tried.whole.rglob("*"))
    for i, limit in enumerate(rng.integers(largest, size=4 if quick else FULL)):
        folder = place / f"full-{i}"
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(limit), before[1]))
        try:
            answer = console("run", *SCENE, "--out", str(folder))
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
        case = f"{limit} bytes a file"
        yield told("full disk", case, answer)
        yield {"promise": "full disk", "case": f"{case}, resume"} | _again(tried, folder)


def _again(tried: TriedRun, folder: Path) -> Trial:
    """Resume what a broken run left; before its scene was written that is no run."""
    if not (folder / "run.toml").exists():
        trial = told("", "", console("resume", str(folder)))
        return {key: trial[key] for key in ("held", "silent", "detail")}
    return resumed(tried, folder, known=0)


def stopped(tried: TriedRun, place: Path, quick: bool) -> Iterator[Trial]:
    """Ctrl-C and SIGTERM: a checkpoint of the last step, and nothing is lost."""
    for name in ("SIGTERM",) if quick else ("SIGINT", "SIGTERM"):
        for case, codes, folder in _struck(name, place, 1 if quick else STOPS, seed=5, again=False):
            rows = rows_of(folder / "history.csv")[1:]
            saved = load(folder / CHECKPOINT).step if (folder / CHECKPOINT).exists() else -1
            behind = len(rows) - 1 - saved  # the row that was being written may lie beyond
            trial = {"promise": "stopped", "case": case} | _again(tried, folder)
            ended = behind <= 1 and codes[0] in (0, 130, -signal.SIGTERM)
            detail = f"{codes}, {behind} rows beyond; {trial['detail']}"
            yield trial | {"held": trial["held"] and ended, "detail": detail}


def killed(tried: TriedRun, place: Path, quick: bool) -> Iterator[Trial]:
    """kill -9, of the run and of its resume."""
    count, again = (1, False) if quick else (KILLS, True)
    for case, codes, folder in _struck("SIGKILL", place, count, seed=6, again=again):
        trial = {"promise": "killed", "case": case} | _again(tried, folder)
        yield trial | {"detail": f"{codes}; {trial['detail']}"}


def _struck(
    name: str, place: Path, count: int, *, seed: int, again: bool
) -> Iterator[tuple[str, list[int], Path]]:
    """Runs in processes of their own, struck by a signal at some touch of their files."""
    if not hasattr(signal, "SIGKILL"):
        return
    rng = np.random.default_rng(seed)
    at = rng.integers(1, TOUCHES, size=(count, 2))

    def strike(i: int) -> tuple[str, list[int], Path]:
        folder = place / f"{name}-{i}"
        codes = [_process(name, at[i, 0], "run", *SCENE, "--out", str(folder))]
        if again:
            codes.append(_process(name, at[i, 1], "resume", str(folder)))
        return f"{name} at touches {at[i].tolist()}", codes, folder

    with ThreadPoolExecutor(2) as pool:
        yield from pool.map(strike, range(count))


def _process(name: str, at: int, *command: str) -> int:
    words = [sys.executable, "-m", f"{__package__}.struck", name, str(at), *command]
    return subprocess.run(words, cwd=ROOT, capture_output=True, check=False).returncode
