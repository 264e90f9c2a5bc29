"""Seconds of coupled steps: an accordion folded twice, and a pancake, as they were shipped.

The console and what runs write are used, nothing that an older tree lacks. Runs are processes of
their own, start included.
"""

from __future__ import annotations

import csv
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage

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


def figures(scene: str, steps: int) -> dict[str, float]:
    """Wall and CPU seconds of a run's first steps, their counts, and the state they end in.

    Parameters
    ----------
    scene : {"accordion", "pancake"}
    steps : int
    """
    _run(scene, 2)  # compiles what no file holds
    return _run(scene, steps)


def _run(scene: str, steps: int) -> dict[str, float]:
    dt = 5.0 if scene == "accordion" else 16.0
    options = [f"time.end={steps * dt}", "output.picture=false", "output.fields_every=0"]
    with tempfile.TemporaryDirectory() as folder:
        text, out = Path(folder) / f"{scene}.toml", Path(folder) / "run"
        text.write_text(SCENES[scene], encoding="utf-8")
        arguments = ["run", str(text), "--out", str(out)]
        for option in options:
            arguments += ["--set", option]
        before, wall = getrusage(RUSAGE_CHILDREN), time.perf_counter()
        console = [sys.executable, "-c", "import sys; from cases.cli import main; sys.exit(main())"]
        subprocess.run([*console, *arguments], check=True, stdout=subprocess.DEVNULL)
        wall, after = time.perf_counter() - wall, getrusage(RUSAGE_CHILDREN)
        with (out / "history.csv").open(encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    cpu = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    counts = {name: sum(int(row[name]) for row in rows) for name in COUNTS}
    return {"wall": wall, "cpu": cpu, **counts, **{n: float(rows[-1][n]) for n in STATE}}
