"""The coupled pancake: end state against its static equilibrium, schemes against each other.

Rows: the shipped run (Stokes) and its uniform-pressure twin, each against a static solve started
from its end state; height over the inlet at equal volumes for both; partitioned schemes against
the implicit one at the same time step, as error of the displacement since t = 0.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from coupling import Outcome, State
from shells.surfaces.spline_surface import SplineSurface

from ... import loader
from ...geometry.bag import Bag
from ...kinds import simulation
from ...kinds.inflation.build import structure
from ...kinds.inflation.config import InflationScene, PancakeGeometry
from ...kinds.inflation.plan import InflationPlan
from ..recorded import RecordedHistory
from ..report import Row

FAST = ("mesh.degree=2", "mesh.around=8", "time.dt=32", "fluid.outer_points=2")
VOLUMES = (1.1, 1.2, 1.35, 1.5, 2.0, 2.5)


@dataclass(frozen=True)
class BagRun:
    """A finished run with everything that was measured on the way."""

    scene: InflationScene
    body: Bag
    history: RecordedHistory
    outcome: Outcome
    seconds: float

    @property
    def end(self) -> State:
        return self.history.states[-1]

    @property
    def half_width(self) -> float:
        assert isinstance(self.scene.geometry, PancakeGeometry)
        return self.scene.geometry.half_width

    def per_step(self, name: str) -> float:
        return float(self.history.column(name)[1:].mean())


def simulate(name: str, overrides: Sequence[str] = ()) -> BagRun:
    """BagRun a shipped scene in memory."""
    scene = loader.read(name, overrides)
    assert isinstance(scene, InflationScene)
    history = RecordedHistory()
    start = time.perf_counter()
    outcome = simulation(scene, [history]).run()
    return BagRun(scene, InflationPlan(scene).bag, history, outcome, time.perf_counter() - start)


def asymmetry(body: Bag, coefficients: np.ndarray) -> float:
    """Largest distance of a coefficient from its ring's mean after rotating the ring back."""
    surface = body.membrane
    assert isinstance(surface, SplineSurface)
    nt = surface.t.n
    angle = surface.t.greville - surface.t.breaks[0]
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = np.moveaxis(coefficients[: body.n_membrane].reshape(-1, nt, 3), -1, 0)
    turned = np.stack([c * x + s * y, c * y - s * x, z], axis=-1)
    return float(np.linalg.norm(turned - turned.mean(axis=1, keepdims=True), axis=-1).max())


def profile(body: Bag, coefficients: np.ndarray) -> tuple[float, float]:
    """Height of the top and largest radius of the membrane."""
    x = np.linspace(0.0, 1.0, 9)
    xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    points = body.membrane.sample(xi, eta) @ coefficients[: body.n_membrane]
    return float(points[:, 2].max()), float(np.hypot(points[:, 0], points[:, 1]).max())


def static_pressure(run: BagRun) -> float:
    """Excess pressure of the static equilibrium next to the end state."""
    shell, c = structure(run.scene, run.body), run.end.coefficients
    step = shell.static(c, shell.volume(c), pressure=run.end.pressure)
    if not step.ok:
        raise ArithmeticError(f"static solve from the end state: {step.outcome.value}")
    return step.state.pressure


def _end_row(case: str, run: BagRun) -> Row:
    h = run.history
    static = static_pressure(run)
    top, radius = profile(run.body, run.end.coefficients)
    zeta = np.abs(h.column("zeta")[1:]) / h.column("velocity_max")[1:]
    volume = np.abs(h.column("volume") / h.column("volume_prescribed") - 1.0)
    skew = max(asymmetry(run.body, s.coefficients) for s in h.states)
    return {
        "case": case,
        "seconds": run.seconds,
        "error": abs(run.end.pressure / static - 1.0),
        "reference": "static equilibrium",
        "pressure": run.end.pressure,
        "top": top,
        "radius": radius,
        "rejected": run.outcome.counts["rejected"],
        "assemblies/step": run.per_step("assemblies"),
        "volume error": float(volume.max()),
        "zeta": float(zeta.max()),
        "asymmetry/R": skew / run.half_width,
        "min gap": float(h.column("min_gap").min()),
        "energy defect": float(np.abs(h.column("energy_defect")).max()),
    }


def _bulge_rows(stokes: BagRun, uniform: BagRun) -> list[Row]:
    """Height over the inlet at equal volumes; the difference is what the flow does."""
    rows = []
    tops = []
    for run in (stokes, uniform):
        v = run.history.column("volume")
        heights = [profile(run.body, s.coefficients)[0] for s in run.history.states]
        rising = np.r_[True, np.diff(np.maximum.accumulate(v)) > 1e-9 * v[0]]
        tops.append((v[rising] / v[0], np.array(heights)[rising]))
    for ratio in VOLUMES:
        a, b = (float(np.interp(ratio, *top)) for top in tops)
        rows.append(
            {
                "case": f"top at V/V0 = {ratio:g}",
                "seconds": 0.0,
                "error": a / b - 1.0,
                "error_kind": "difference of the models",
                "reference": "uniform pressure",
                "top": a,
                "top, uniform pressure": b,
            }
        )
    return rows


def _scheme_row(scheme: str, dt: float, end: float, common: Sequence[str]) -> Row:
    shared = [*common, f"time.dt={dt}", f"time.end={end}"]
    reference = simulate("pancake", shared)
    run = simulate("pancake", [*shared, f"coupling.scheme={scheme}"])
    moved = reference.end.coefficients - reference.history.states[0].coefficients
    difference = run.end.coefficients - reference.end.coefficients
    return {
        "case": f"{scheme}, dt = {dt:g} to t = {end:g}",
        "seconds": run.seconds,
        "error": float(np.linalg.norm(difference) / np.linalg.norm(moved)),
        "reference": "implicit, same dt",
        "ratio": run.seconds / reference.seconds,
        "peer": "implicit",
        "rejected": run.outcome.counts["rejected"],
        "assemblies/step": run.per_step("assemblies"),
        "asymmetry/R": asymmetry(run.body, run.end.coefficients) / run.half_width,
    }


def run(quick: bool) -> list[Row]:
    """Rows of the benchmark; ``quick`` takes the reduced mesh of continuous integration."""
    common = FAST if quick else ()
    simulate("pancake", [*FAST, "time.end=32"])  # compiles the kernels
    stokes = simulate("pancake", common)
    uniform = simulate("pancake-pressure", [c for c in common if "outer" not in c])
    rows = [_end_row("stokes, implicit", stokes), _end_row("uniform pressure", uniform)]
    rows += _bulge_rows(stokes, uniform)
    mesh = [c for c in common if "dt" not in c]
    rows.append(_scheme_row("aitken", 8.0, 40.0 if quick else 200.0, mesh))
    rows.append(_scheme_row("gauss-seidel", 1.0, 6.0 if quick else 48.0, mesh))
    return rows
