"""Runs that ask for trouble: each must end completed or in a named result, its files whole.

Antisymmetric disturbances, mass ratios over six decades, influx that jumps, steps a hundred times
too long; and runs killed by the system and resumed, whose history must be that of an undisturbed
run to the last digit.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import numpy as np
from rich.console import Console

from coupling import Outcome, Result

from ... import loader
from ...output.checkpoint import load, scene_hash
from ...output.history import read_history
from ...output.vtk import read_frames
from ...runs.start import start
from ..pancake.suite import FAST
from ..report import Row
from .posed import CoupledScene

PLANE = "planar-stokes-pancake"
COARSE = ("mesh.straight=1.0", "mesh.curved=0.5")
SPACE = tuple(o for o in FAST if "dt" not in o)

CASES: dict[str, tuple[str, Sequence[str]]] = {
    **{
        f"antisymmetric, {scheme}": (
            PLANE,
            ["geometry.asymmetry=0.033", "time.end=80", f"coupling.scheme={scheme}"],
        )
        for scheme in ("implicit", "auto", "iqn-ils", "aitken", "gauss-seidel")
    },
    **{
        f"m = {m:g}": (
            PLANE, [*COARSE, f"fluid.mass_ratio={m}", "time.end=160", "coupling.scheme=auto"]
        )
        for m in (5e-6, 5e-5, 5e-4, 5e-3, 5e-2, 0.5, 5.0)
    },
    "influx jumps": (PLANE, [*COARSE, "inflow.t1=0.01", "time.end=200"]),
    "influx jumps, 30 times too fast": (
        PLANE, [*COARSE, "inflow.t1=0.01", "inflow.t2=50", "time.end=100"]
    ),
    "dt 100 times too long": (PLANE, [*COARSE, "time.dt=400", "time.end=3600"]),
    "dt 100 times too long, aitken": (
        PLANE, [*COARSE, "time.dt=400", "time.end=1200", "coupling.scheme=aitken"]
    ),
    "round: m = 5e-6": ("pancake", [*SPACE, "time.end=96", "fluid.mass_ratio=5e-6"]),
    "round: m = 5": ("pancake", [*SPACE, "time.end=96", "fluid.mass_ratio=5.0"]),
    "round: influx jumps": ("pancake", [*SPACE, "inflow.t1=0.01", "time.end=96"]),
    "round: dt 100 times too long": ("pancake", [*SPACE, "time.dt=1600", "time.end=1600"]),
}  # fmt: skip
QUICK = ("antisymmetric, auto", "m = 5", "dt 100 times too long")
KILLED = (("backward-euler", "implicit"), ("bdf2", "iqn-ils"), ("bdf2", "auto"))


def damage(folder: Path, result: str) -> list[str]:
    """What is wrong with the files of a finished run; empty if all are whole."""
    scene = loader.read(folder / "run.toml")
    assert isinstance(scene, CoupledScene)
    wrong = []
    record = json.loads((folder / "run.json").read_text())
    if record["result"] != result:
        wrong.append(f"run.json says {record['result']}")
    columns = read_history(folder / "history.csv")
    lines = (folder / "history.csv").read_text().splitlines()
    if columns["t"].size != len(lines) - 1 or not np.all(np.diff(columns["t"]) > 0.0):
        wrong.append("history.csv: torn or unordered rows")
    if not np.all(np.isfinite(columns["volume"])):
        wrong.append("history.csv: volumes that are not finite")
    snapshot = load(folder / "checkpoint.npz", scene_hash(scene))
    if snapshot.step != columns["step"][-1] or not np.all(np.isfinite(snapshot.state.coefficients)):
        wrong.append("checkpoint.npz: not the last accepted step")
    for _, name in read_frames(folder / "fields.pvd"):
        if not (folder / name).exists():
            wrong.append(f"fields.pvd: {name} is missing")
    return wrong


def stress_row(case: str, folder: Path) -> Row:
    """Run one of `CASES` into a folder."""
    name, options = CASES[case]
    scene = loader.read(name, [*options, "output.picture=false"])
    assert isinstance(scene, CoupledScene)
    began = time.process_time()
    with redirect_stdout(StringIO()):
        outcome = start(scene, folder, Console(file=StringIO())).outcome
    assert isinstance(outcome, Outcome)  # none is stopped
    columns = read_history(folder / "history.csv")
    drift = np.abs(columns["volume"] / columns["volume_prescribed"] - 1.0).max()
    return {
        "case": f"stress: {case}",
        "seconds": time.process_time() - began,
        "error": float(drift),
        "reference": "prescribed volume",
        "result": outcome.result.name.lower(),
        "named": outcome.result in Result,
        "t": outcome.t,
        "of": scene.time.end,
        "steps": outcome.step,
        "rejected": outcome.counts["rejected"],
        "damaged files": len(damage(folder, outcome.result.name.lower())),
    }


def _console(*arguments: str) -> subprocess.Popen:
    root = str(Path(__file__).resolve().parents[2])
    return subprocess.Popen(
        [sys.executable, "-m", "cases.cli", *arguments],
        cwd=root,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def _history(folder: Path) -> list[str]:
    """Lines of the history without their last column, the wall time."""
    path = folder / "history.csv"
    lines = path.read_text().splitlines() if path.exists() else []
    return [line.rsplit(",", 1)[0] for line in lines]


def kill_row(integrator: str, scheme: str, folder: Path, after: int = 9) -> Row:
    """A run killed after some steps and resumed, against the same run left alone."""
    options = [*COARSE, "time.end=80", f"time.integrator={integrator}", "output.picture=false",
               "output.checkpoint_every=4", f"coupling.scheme={scheme}"]  # fmt: skip
    sets = [word for option in options for word in ("--set", option)]
    began = time.perf_counter()
    whole = _console("run", PLANE, *sets, "--out", str(folder / "whole")).wait()
    process = _console("run", PLANE, *sets, "--out", str(folder / "killed"))
    while process.poll() is None and len(_history(folder / "killed")) < after + 2:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    killed = process.wait()
    left = len(_history(folder / "killed"))
    resumed = _console("resume", str(folder / "killed")).wait()
    a, b = _history(folder / "whole"), _history(folder / "killed")
    different = sum(x != y for x, y in zip(a, b, strict=False)) + abs(len(a) - len(b))
    return {
        "case": f"kill -9 and resume: {integrator}, {scheme}",
        "seconds": time.perf_counter() - began,
        "error": different / len(a),
        "error_kind": "share of history rows that differ",
        "reference": "uninterrupted run",
        "rows": len(a),
        "rows when killed": left,
        "exit codes": f"{whole}, {killed}, {resumed}",
    }


def rows(quick: bool) -> list[Row]:
    """All cases, each in a folder of its own that is removed."""
    found = []
    with tempfile.TemporaryDirectory() as place:
        for i, case in enumerate(QUICK if quick else CASES):
            found.append(stress_row(case, Path(place) / f"{i}"))
        for integrator, scheme in KILLED[1:2] if quick else KILLED:
            folder = Path(place) / f"{integrator}-{scheme}"
            found.append(kill_row(integrator, scheme, folder))
    return found
