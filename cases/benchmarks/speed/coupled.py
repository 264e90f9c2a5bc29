"""Seconds of coupled steps: an accordion folded twice, and a pancake, as they were shipped.

`figures` uses the console and what runs write, nothing that an older tree lacks, and
``python coupled.py SCENE STEPS`` prints it as JSON: the same file, run with another tree on
PYTHONPATH, measures that tree.
"""

from __future__ import annotations

import contextlib
import csv
import io
import json
import sys
import tempfile
import time
from pathlib import Path

from cases.cli import main

SCENES = {
    "accordion": """
[geometry]
kind = "pillow"
fold = "accordion"
folds = 2
panel = 6.0
gap = 0.4
[mesh]
degree = 2
around = 28
across = 36
inlet = 2
[structure]
flexural_rigidity = 1e-5
inflow_rim = "clamped"
reference = "creased"
[fluid]
model = "stokes"
tolerance = 5e-2
mass_ratio = 1e-4
[inflow]
final_volume = 5.3
t1 = 30.0
t2 = 120.0
[time]
dt = 5.0
end = 165.0
[coupling]
scheme = "implicit"
tolerance = 3e-2
""",
    "pancake": """
[geometry]
kind = "pancake"
radius = 1.0
half_width = 10.0
neck_radius = 1.0
fillet = 1.0
[mesh]
degree = 3
around = 12
rim = 4
fillet = 2
flat_max = 3.0
pole = 2.0
disc = 2
[structure]
flexural_rigidity = 1e-2
inflow_rim = "hinged"
[fluid]
model = "stokes"
mass_ratio = 0.005
[inflow]
final_volume = 3.0
t1 = 200.0
t2 = 400.0
[time]
dt = 16.0
end = 800.0
[coupling]
scheme = "implicit"
""",
}
COUNTS = ("assemblies", "newton_iterations", "subiterations")
STATE = ("volume", "area", "pressure", "membrane_energy", "bending_energy", "fluid_work", "min_gap")


def figures(scene: str, steps: int, warm: bool = True) -> dict[str, float]:
    """Wall and CPU seconds of a run's first steps, their counts, and the state they end in.

    Parameters
    ----------
    scene : {"accordion", "pancake"}
    steps : int
    warm : bool
        One step first, which compiles or loads kernels.
    """
    if warm:
        _run(scene, 1)
    return _run(scene, steps)


def _run(scene: str, steps: int) -> dict[str, float]:
    dt = 5.0 if scene == "accordion" else 16.0
    with tempfile.TemporaryDirectory() as folder:
        text, out = Path(folder) / f"{scene}.toml", Path(folder) / "run"
        text.write_text(SCENES[scene], encoding="utf-8")
        options = [f"time.end={steps * dt}", "output.picture=false", "output.fields_every=0"]
        arguments = ["run", str(text), "--out", str(out)]
        for option in options:
            arguments += ["--set", option]
        wall, cpu = time.perf_counter(), time.process_time()
        with contextlib.redirect_stdout(io.StringIO()) as said:
            code = main(arguments)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        if code:
            raise RuntimeError(f"{scene}: the run ended with {code}: {said.getvalue()[-500:]}")
        with (out / "history.csv").open(encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    counts = {name: sum(int(row[name]) for row in rows) for name in COUNTS}
    return {"wall": wall, "cpu": cpu, **counts, **{n: float(rows[-1][n]) for n in STATE}}


if __name__ == "__main__":
    print(json.dumps(figures(sys.argv[1], int(sys.argv[2]))))
