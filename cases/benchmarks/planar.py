"""The planar systems: exact flows, coupled runs of all planar scenes, models compared.

Static rows come from `planar_layers`; coupled rows say how each run ended. ``quick`` shortens the
runs; their full lengths are those of the thesis.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from coupling.protocols import Outcome, State
from hbem.planar.potential import PotentialSystem
from shells.dynamics import ShellStructure

from .. import loader
from ..geometry.planar import pieces
from ..planar import build, exact
from ..planar.config import Geometry, Mesh, Scene
from . import planar_layers
from .pancake import History
from .planar_layers import Row, rate

VOLUMES = (1.01, 1.02, 1.03)  # under uniform pressure the walls meet at 1.04


@dataclass(frozen=True)
class Run:
    """A finished planar run with everything that was measured on the way."""

    scene: Scene
    structure: ShellStructure
    history: History
    outcome: Outcome
    seconds: float

    @property
    def states(self) -> list[State]:
        return self.history.states

    def row(self, case: str, error: float, **more: Any) -> Row:
        h = self.history
        counts = self.outcome.counts
        return {
            "case": case,
            "seconds": self.seconds,
            "error": error,
            **more,
            "result": self.outcome.result.name,
            "t": self.outcome.t,
            "rejected": counts["rejected"],
            "assemblies/step": counts["assemblies"] / max(1, counts["accepted"]),
            "min gap": float(h.column("min_gap").min()),
            "V/V0": float(h.column("volume")[-1] / h.column("volume")[0]),
        }


def simulate(name: str, *overrides: str) -> Run:
    """Run a shipped planar scene in memory."""
    scene = loader.read(name, list(overrides))
    history = History()
    simulation = build.simulation(scene, [history])
    start = time.process_time()
    outcome = simulation.run()
    return Run(scene, simulation.structure, history, outcome, time.process_time() - start)


def volume_error(run: Run) -> float:
    """Largest relative deviation from the prescribed volume."""
    h = run.history
    return float(np.abs(h.column("volume") / h.column("volume_prescribed") - 1.0).max())


def inflation_rows(quick: bool) -> list[Row]:
    """High aspect ratio [T 5.3.1]: with and without exterior, against uniform pressure."""
    short = ("time.end=400", "time.dt=8", "mesh.straight=0.6", "mesh.curved=0.35") if quick else ()
    stokes = simulate("planar-stokes-pancake", *short)
    h = stokes.history
    end = stokes.states[-1]
    if quick:
        error, kind = volume_error(stokes), "volume"
    else:
        static = stokes.structure.static(
            end.coefficients, stokes.structure.volume(end.coefficients), pressure=end.pressure
        )
        error, kind = abs(end.pressure / static.state.pressure - 1.0), "final pressure"
    rows = [
        stokes.row(
            "pancake, lambda = 1",
            error,
            error_kind=kind,
            pressure=end.pressure,
            stretch=f"{h.column('stretch_min').min():.4f}..{h.column('stretch_max').max():.4f}",
        )
    ]
    if not quick:
        alone = simulate(
            "planar-stokes-pancake", "fluid.viscosity_ratio=0", "time.dt=1", "time.end=1300"
        )
        rows.append(
            alone.row("pancake, lambda = 0, dt = 1", volume_error(alone), error_kind="volume")
        )
    uniform = simulate("planar-stokes-pancake", "fluid.model=pressure", "time.end=1460", *short)
    for ratio in VOLUMES:
        a, b = (top_at(run, ratio) for run in (stokes, uniform))
        rows.append(
            {
                "case": f"top at V/V0 = {ratio:g}",
                "seconds": 0.0,
                "error": a / b - 1.0,
                "error_kind": "Stokes against uniform pressure",
                "top": a,
                "top, uniform pressure": b,
            }
        )
    return rows


def top_at(run: Run, ratio: float) -> float:
    """Height of the top when the volume first reaches a multiple of the initial one, else nan."""
    v = run.history.column("volume")
    if v[-1] < ratio * v[0]:
        return float("nan")
    return float(np.interp(ratio, v / v[0], run.history.column("top")))


def deflation_rows(quick: bool) -> list[Row]:
    """Deflating circle [T 5.3.2]: volume reduction at the end of each run."""
    short = ("time.end=200", "time.dt=8") if quick else ()
    rows = []
    for elements, rim in ((32, "clamped"), (64, "clamped"), (64, "hinged")):
        run = simulate(
            "planar-stokes-deflation", f"mesh.uniform={elements}", f"structure.ends={rim}", *short
        )
        row = run.row(
            f"deflation, {rim}, {elements} elements", volume_error(run), error_kind="volume"
        )
        rows.append({**row, "reduction": 1.0 - row["V/V0"]})
    return rows


def fold_rows(quick: bool) -> list[Row]:
    """The folds: Stokes flow, and potential flow with the contact force for three varpi."""
    rows = []
    stokes = simulate("planar-stokes-fold", *(("time.end=64",) if quick else ()))
    rows.append(stokes.row("fold, Stokes, lambda = 1", volume_error(stokes), error_kind="volume"))
    for varpi in (0.1, 1.0, 10.0):
        # heavy fluids need tiny steps: three of the scene's dt are enough to see it
        end = ("time.end=0.2" if varpi > 1.0 else "time.end=0.6") if quick else "time.end=20"
        run = simulate("planar-potential-fold", f"fluid.mass_ratio={varpi}", end)
        row = run.row(f"fold, potential, varpi = {varpi:g}", volume_error(run), error_kind="volume")
        rows.append({**row, "bound of the contact pressure": 4.0 * run.scene.fluid.contact_force})
    return rows


def space_time_distance(a: Run, b: Run, end: float) -> float:
    """``|a - b|`` over ``|b|`` in L2(0, end; H2), b on a mesh that contains a's nodes."""
    basis = b.structure.shell.basis
    local = np.searchsorted(a.structure.shell.basis.nodes, basis.nodes, side="right") - 1
    h = np.diff(a.structure.shell.basis.nodes)
    local = np.clip(local, 0, h.size - 1)
    x = (basis.nodes - a.structure.shell.basis.nodes[local]) / h[local]
    embed = _embedding(local, x, h, 2 * h.size + 2)
    times = np.linspace(0.0, end, 33)[1:]
    total = norm = 0.0
    for t in times:
        ca, cb = (_state_at(run, t) for run in (a, b))
        total += _h2(basis, embed @ ca - cb)
        norm += _h2(basis, cb)
    return float(np.sqrt(total / norm))


def _embedding(e: np.ndarray, x: np.ndarray, h: np.ndarray, n: int) -> np.ndarray:
    """Hermite coefficients on a finer mesh: values and derivatives at its nodes."""
    matrix = np.zeros((2 * e.size, n))
    h = h[e]
    values = [1 - x**2 * (3 - 2 * x), h * x * (1 - x) ** 2, x**2 * (3 - 2 * x), h * x**2 * (x - 1)]
    slopes = [6 * x * (x - 1) / h, (1 - x) * (1 - 3 * x), 6 * x * (1 - x) / h, x * (3 * x - 2)]
    for k in range(4):
        matrix[2 * np.arange(e.size), 2 * e + k] += values[k]
        matrix[2 * np.arange(e.size) + 1, 2 * e + k] += slopes[k]
    return matrix


def _state_at(run: Run, t: float) -> np.ndarray:
    """Coefficients at time t, linear between steps."""
    times = run.history.column("t")
    k = int(np.clip(np.searchsorted(times, t), 1, times.size - 1))
    s = (t - times[k - 1]) / (times[k] - times[k - 1])
    before, after = run.states[k - 1].coefficients, run.states[k].coefficients
    return (1.0 - s) * before + s * after


def _h2(basis: Any, coefficients: np.ndarray) -> float:
    jets = basis.jets(coefficients)
    square = sum((part**2).sum(axis=-1) for part in (jets.value, jets.tangent, jets.second))
    return float((square * basis.dx).sum())


def convergence_rows(quick: bool) -> list[Row]:
    """Chapter 4 pancake: space-time norm in h and dt, each against a reference 4 times finer."""
    end = 3.0
    fixed = ("time.dt=0.0661", f"time.end={end}")
    meshes = [24, 48] if quick else [24, 48, 96]
    runs = {n: simulate("planar-potential-pancake", f"mesh.uniform={n}", *fixed) for n in meshes}
    finest = simulate("planar-potential-pancake", f"mesh.uniform={4 * meshes[-1]}", *fixed)
    rows = _errors([(f"potential pancake, L/{n}", 1.0 / n, runs[n]) for n in meshes], finest, end)
    steps = [5, 6] if quick else [6, 7, 8, 9]
    period = 8.467
    common = ("mesh.uniform=48", f"time.end={end}")
    runs = {
        k: simulate("planar-potential-pancake", f"time.dt={period / 2**k}", *common) for k in steps
    }
    finest = simulate(
        "planar-potential-pancake", f"time.dt={period / 2 ** (steps[-1] + 2)}", *common
    )
    return rows + _errors(
        [(f"potential pancake, dt = period/{2**k}", 2.0**-k, runs[k]) for k in steps], finest, end
    )


def _errors(cases: list[tuple[str, float, Run]], reference: Run, end: float) -> list[Row]:
    rows, last = [], None
    for case, size, run in cases:
        error = space_time_distance(run, reference, end)
        slope = float("nan") if last is None else rate([last[0], size], [last[1], error])
        rows.append(
            {
                "case": case,
                "seconds": run.seconds,
                "error": error,
                "rate": slope,
                "reference": "4 times finer",
            }
        )
        last = (size, error)
    return rows


def load_functional(n: int, k: int, m: int = 256) -> tuple[np.ndarray, float]:
    """Pressure and load of [T fig. 4.5] on n elements of the pancake's C1 curve.

    The velocity is [T 4.31]; x_1 is the horizontal coordinate, else it does not vanish at the
    hinges. Returns pressures at ``m`` equal parameters and the load tested with sin(k pi s / L).
    """
    curve = pieces(Geometry(width=4.0))
    s = curve.nodes(Mesh(uniform=n))
    membrane = curve.at(s)[0]
    r = 1.0 / 3.0
    inlet = np.column_stack([np.linspace(-0.5 * r, 0.5 * r, 17)[1:-1], np.full(15, -2.0 * r)])
    points = np.concatenate([membrane, inlet])
    ends = exact.ends(points)
    u = np.column_stack([np.zeros(len(ends)), 0.3 * (np.abs(ends[:, 0]) - 0.5 * r)])
    u[2 * n :] = 0.0
    system = PotentialSystem(points)
    h = np.einsum("ei,ei->e", u, np.repeat(system.normals, 2, axis=0))
    # no influx: what the membrane displaces leaves through the inlet uniformly
    weight = np.repeat(0.5 * system.lengths, 2)
    h[2 * n :] = -(weight @ h) / weight[2 * n :].sum()
    p = system.pressure(h, system.solve(h)[0])
    p -= (weight @ p) / weight.sum()
    x, w = np.polynomial.legendre.leggauss(4)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    load = 0.0
    for xi, wi in zip(x, w, strict=True):
        at = (1.0 - xi) * p[: 2 * n : 2] + xi * p[1 : 2 * n : 2]
        test = np.sin(k * np.pi * (s[:-1] + xi * np.diff(s)) / s[-1])
        load += wi * float(np.sum(at * test * (system.normals * system.lengths[:, None])[:n, 1]))
    place = (np.arange(m) + 0.5) / m * n
    e = place.astype(int)
    return (1.0 - (place - e)) * p[2 * e] + (place - e) * p[2 * e + 1], load


def load_rows(quick: bool) -> list[Row]:
    """Rates of pressure and load; k = 2 vanishes by parity: sin(2 pi s/L) is odd, p n_1 even."""
    meshes = [32, 64, 128] if quick else [32, 64, 128, 256]
    finest = 4 * meshes[-1]
    reference = {k: load_functional(finest, k) for k in (1, 2, 3)}
    scale = abs(reference[1][1])
    rows, last = [], None
    for n in meshes:
        start = time.perf_counter()
        found = {k: load_functional(n, k) for k in (1, 2, 3)}
        seconds = time.perf_counter() - start
        p = reference[1][0]
        errors = [
            float(np.linalg.norm(found[1][0] - p) / np.linalg.norm(p)),
            abs(found[1][1] / reference[1][1] - 1.0),
            abs(found[3][1] / reference[3][1] - 1.0),
        ]
        slopes = (
            [float("nan")] * 3
            if last is None
            else [float(np.log2(a / b)) for a, b in zip(last, errors, strict=True)]
        )
        rows.append(
            {
                "case": f"load functional, {n} elements",
                "seconds": seconds,
                "error": errors[1],
                "rate, k=1": slopes[1],
                "rate, k=3": slopes[2],
                "error of p": errors[0],
                "rate of p": slopes[0],
                "load, k=2 over k=1": found[2][1] / scale,
            }
        )
        last = errors
    return rows


def run(quick: bool) -> list[Row]:
    """Rows of the benchmark."""
    rows = planar_layers.rows(quick)
    for part in (load_rows, convergence_rows, inflation_rows, deflation_rows, fold_rows):
        rows += part(quick)
    return rows
