"""Run folders: damaged, full, forbidden, shared and killed; no loss in silence, no traceback.

Every trial is seeded, and its order and number are always the same.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from ... import loader
from ...runs.folder import new_folder
from ...runs.lock import locked
from .damage import damages, flipped
from .system import consoles, forbidden, full, killed, stopped
from .verdict import SCENE, Trial, TriedRun, console, content, resumed, told

FLIPS = 3000


def trials(quick: bool) -> list[Trial]:
    """All trials, or a reduced set.

    Parameters
    ----------
    quick : bool
        A few seconds instead of minutes.

    Returns
    -------
    list of dict
        ``promise``, ``case``, ``held``, ``silent`` (broken without a word), ``detail``.
    """
    kinds = (damaged, bits, drawn, refusals, consoles, forbidden, full, stopped, killed)
    with tempfile.TemporaryDirectory() as name:
        place = Path(name).resolve()
        tried = TriedRun.inflated(place)
        return [trial for kind in kinds for trial in kind(tried, place, quick)]


def damaged(tried: TriedRun, place: Path, quick: bool) -> Iterator[Trial]:
    """Every file damaged in every way; the quick set is a seventh of them."""
    yield from _damaged(tried, place, 7 if quick else 1)
    yield from _damaged(TriedRun.loaded(place), place, 29 if quick else 1)


def _damaged(tried: TriedRun, place: Path, every: int) -> Iterator[Trial]:
    rng = np.random.default_rng(1)
    for i, (name, damage) in enumerate(damages(tried.cut)):
        if i % every:
            continue
        folder = tried.copied(place / f"{tried.cut.name}-{i}")
        damage(folder, rng)
        case = f"{tried.cut.name}: {name}"
        yield {"promise": "damaged folder", "case": case} | resumed(tried, folder, content(folder))


def bits(tried: TriedRun, place: Path, quick: bool) -> Iterator[Trial]:
    """Single bits."""
    rng = np.random.default_rng(2)
    for i in range(FLIPS // 30 if quick else FLIPS):
        folder = tried.copied(place / f"bit-{i}")
        case = flipped(folder, rng)
        yield {"promise": "bit flip", "case": case} | resumed(tried, folder, content(folder))
        shutil.rmtree(folder)


def drawn(tried: TriedRun, place: Path, quick: bool) -> Iterator[Trial]:
    """Pictures of damaged folders."""
    rng = np.random.default_rng(3)
    for i, (case, damage) in enumerate(damages(tried.cut)):
        if i % (120 if quick else 3):
            continue
        folder = tried.copied(place / f"drawn-{i}")
        damage(folder, rng)
        answer = console("report", str(folder))
        yield told("report of a damaged folder", case, answer, good=(0,))


def refusals(tried: TriedRun, place: Path, quick: bool) -> Iterator[Trial]:
    """What the system or another process forbids."""
    (place / "file").write_text("")
    outs = {
        "--out below a file": place / "file" / "run",
        "--out is a file": place / "file",
        "overlong name": place / ("x" * 300),
        "a folder in use": tried.cut,
    }
    for case, out in outs.items():
        yield told("refused place", case, console("run", *SCENE, "--out", str(out)))
    for name in ("../../x", "/x", "a/b", "", "..", "x" * 300, "a\nb", "C:x"):
        answer = console("run", *SCENE, "--set", f"name='''{name}'''")
        yield told("refused name", repr(name)[:30], answer)
    folder = tried.copied(place / "locked")
    with locked(folder):
        for words in (["resume"], ["run", *SCENE, "--out"]):
            answer = console(*words, str(folder))
            trial = told("two writers", f"{words[0]} into a folder in use", answer)
            yield trial | {"held": trial["held"] and f"process {os.getpid()}" in answer.err}
        yield told("two writers", "report of a folder in use", console("report", str(folder)), [0])
    yield {"promise": "two writers", "case": "resume afterwards"} | resumed(tried, folder)
    scene = loader.read(SCENE[0], [f"name='{place.name}'"])
    with contextlib.chdir(place), ThreadPoolExecutor(8) as pool:
        made = list(pool.map(lambda _: new_folder(scene, None), range(40)))
    shared = len(made) - len(set(made))
    yield {"promise": "two writers", "case": "40 new folders at once", "held": not shared,
           "silent": bool(shared), "detail": f"{shared} shared"}  # fmt: skip
