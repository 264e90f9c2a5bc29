"""The first start of a scene: wall time until news and until a step, without compiled kernels."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[3]


def seconds_to_first_step(
    scene: str, *settings: str, cold: bool = True, root: Path = ROOT
) -> dict[str, float]:
    """Wall seconds of ``airfold run`` until its first line and until its first step.

    Parameters
    ----------
    scene : str
        Name of a shipped scene.
    settings : str
        As after ``--set``.
    cold : bool
        Without compiled kernels; else with those that a run just before has left.

    root : Path
        Where the packages lie, for another commit beside this one.

    Returns
    -------
    dict
        ``news`` (first line about the run after its folder), ``first step``, ``CPU`` (of the run
        and its processes until they end).
    """
    with tempfile.TemporaryDirectory() as folder:
        if not cold:
            _run(scene, settings, Path(folder), root)
        return _run(scene, settings, Path(folder), root)


def _run(scene: str, settings: tuple[str, ...], folder: Path, root: Path) -> dict[str, float]:
    chosen = [part for setting in settings for part in ("--set", setting)]
    out = tempfile.mkdtemp(dir=folder)
    command = [sys.executable, "-m", "cases.cli", "run", scene, *chosen, "--out", out]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(folder), "PYTHONPATH": str(root)}
    found: dict[str, float] = {}
    begin, used = time.perf_counter(), os.times()
    with subprocess.Popen(
        command, cwd=root, env=environment, stdout=subprocess.PIPE, text=True
    ) as run:
        for line in run.stdout or ():
            for key, words in (("news", ("compiling", "skipped", "step")), ("first step", "step")):
                if line.startswith(words) and (key == "news" or "V/V0" in line):
                    found.setdefault(key, time.perf_counter() - begin)
    if run.returncode != 0 or "first step" not in found:
        raise RuntimeError(f"airfold run {scene} ended with code {run.returncode}, before a step")
    now = os.times()
    found["CPU"] = sum(now[2:4]) - sum(used[2:4])
    return found
