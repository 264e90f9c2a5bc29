"""Coupled runs of the planar scenes: how each ended and what was measured on the way."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from coupling import Outcome, State
from shells.equilibrium.structure import ShellStructure

from ... import loader
from ...kinds import simulation
from ...kinds.planar.config import PlanarScene
from ..recorded import RecordedHistory
from ..report import Row

POINTS = 400  # of a history in a report


@dataclass(frozen=True)
class PlanarRun:
    """A finished planar run with everything that was measured on the way."""

    scene: PlanarScene
    overrides: tuple[str, ...]
    structure: ShellStructure
    history: RecordedHistory
    outcome: Outcome
    seconds: float

    @property
    def states(self) -> list[State]:
        return self.history.states

    def row(self, case: str, error: float, **more: Any) -> Row:
        h = self.history
        counts = self.outcome.counts
        t, gap = h.column("t"), h.column("min_gap")
        every = slice(None, None, max(1, t.size // POINTS))
        return {
            "case": case,
            "seconds": self.seconds,
            "error": error,
            **more,
            "result": self.outcome.result.name,
            "t": self.outcome.t,
            "rejected": counts["rejected"],
            "assemblies/step": counts["assemblies"] / max(1, counts["accepted"]),
            "min gap": float(gap.min()),
            "V/V0": float(h.column("volume")[-1] / h.column("volume")[0]),
            "_history": [t[every], gap[every]],
        }


def simulate(name: str, *overrides: str) -> PlanarRun:
    """PlanarRun a shipped planar scene in memory; its seconds are those of the processor."""
    scene = loader.read(name, overrides)
    assert isinstance(scene, PlanarScene)
    history = RecordedHistory()
    made = simulation(scene, [history])
    assert isinstance(made.structure, ShellStructure)
    start = time.process_time()
    outcome = made.run()
    seconds = time.process_time() - start
    return PlanarRun(scene, overrides, made.structure, history, outcome, seconds)


def volume_error(run: PlanarRun) -> float:
    """Largest relative deviation from the prescribed volume."""
    h = run.history
    return float(np.abs(h.column("volume") / h.column("volume_prescribed") - 1.0).max())


def pancake(quick: bool) -> tuple[list[Row], PlanarRun]:
    """High aspect ratio [T 5.3.1]: with and without exterior."""
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
    return rows, stokes


SECOND_ORDER = ("time.dt=2", "time.integrator=bdf2")
CONTACTS: dict[str, tuple[str, ...]] = {
    # 4 is the scene's step: backward Euler damps the arms, which then miss each other
    **{f"backward Euler, dt = {dt}": (f"time.dt={dt}",) for dt in (4, 2, 1)},
    "BDF2, dt = 2": SECOND_ORDER,
    "BDF2, dt = 1": ("time.dt=1", "time.integrator=bdf2"),
    "elements halved": (*SECOND_ORDER, "mesh.straight=0.2", "mesh.curved=0.125"),
    "8 elements in the inlet": (*SECOND_ORDER, "mesh.inlet=8"),
    "disturbance 1e-2": (*SECOND_ORDER, "geometry.asymmetry=0.01"),
    "stiffness 1": (*SECOND_ORDER, "structure.stiffness=1"),
    "clamped ends": (*SECOND_ORDER, "structure.ends=clamped"),
    "rigidity doubled": (*SECOND_ORDER, "structure.flexural_rigidity=2e-4"),
    "rigidity halved": (*SECOND_ORDER, "structure.flexural_rigidity=5e-5"),
    "viscosity doubled": (*SECOND_ORDER, "fluid.mass_ratio=0.01"),
    "viscosity halved": (*SECOND_ORDER, "fluid.mass_ratio=0.0025"),
}


def contact_rows(quick: bool) -> list[Row]:
    """When the outer walls of the pancake meet that has no fluid outside."""
    rows = []
    for what, options in ({} if quick else CONTACTS).items():
        run = simulate(
            "planar-stokes-pancake", "fluid.viscosity_ratio=0", "time.end=1300", *options
        )
        rows.append(run.row(f"contact, {what}", volume_error(run), error_kind="volume"))
    return rows


def deflation_rows(quick: bool) -> list[Row]:
    """Deflating circle [T 5.3.2]: volume reduction at the end of each run."""
    short = ("time.end=200", "time.dt=8") if quick else ()
    rows = []
    meshes = (32, 64) if quick else (32, 64, 96)
    for elements, rim in (*((n, "clamped") for n in meshes), (64, "hinged")):
        run = simulate(
            "planar-stokes-deflation", f"mesh.uniform={elements}", f"structure.ends={rim}", *short
        )
        row = run.row(
            f"deflation, {rim}, {elements} elements", volume_error(run), error_kind="volume"
        )
        rows.append({**row, "reduction": 1.0 - row["V/V0"]})
    return rows


def fold(quick: bool) -> tuple[list[Row], PlanarRun]:
    """The folded bag in Stokes flow."""
    run = simulate("planar-stokes-fold", *(("time.end=64",) if quick else ()))
    return [run.row("fold, Stokes, lambda = 1", volume_error(run), error_kind="volume")], run


def potential_rows(quick: bool) -> list[Row]:
    """Potential flow: the pancake, and the folded bag with its contact force for three varpi."""
    run = simulate("planar-potential-pancake", *(("time.end=6",) if quick else ()))
    rows = [run.row("pancake, potential, varpi = 0.1", volume_error(run), error_kind="volume")]
    for varpi in (0.1, 1.0, 10.0):
        # the heaviest fluid takes steps of 6e-3: t = 1 is what three minutes reach
        ends = (0.2, 1.0) if varpi > 1.0 else (0.6, 20.0)
        end = f"time.end={ends[0] if quick else ends[1]}"
        # plain subiterations diverge as the throat narrows; long ones are better halved early
        heavy = ("coupling.scheme=aitken", "coupling.max_iterations=12") if varpi >= 1.0 else ()
        run = simulate("planar-potential-fold", f"fluid.mass_ratio={varpi}", end, *heavy)
        row = run.row(f"fold, potential, varpi = {varpi:g}", volume_error(run), error_kind="volume")
        rows.append({**row, "bound of the contact pressure": 4.0 * run.scene.fluid.contact_force})
    return rows
