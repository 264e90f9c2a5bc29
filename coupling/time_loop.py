"""The time loop: steps accepted or rejected as a whole, history rows, checkpoints.

A rejected step leaves no trace but its record: state, scheme memory and sums are those of the
last accepted step, and dt is halved. Acceptance lets dt grow again, never above the scene's. The
loop writes nothing itself; recorders do.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from .attempt import Attempt, Scheme, StepProblem
from .protocols import (
    AcceptedStep,
    Fluid,
    Iteration,
    Outcome,
    Recorder,
    Rejection,
    Result,
    Snapshot,
    State,
    Structure,
)

logger = logging.getLogger(__name__)

SUMS = ("pressure_work", "fluid_work", "dissipation")


@dataclass(frozen=True)
class StepControl:
    """Step size: the scene's dt is the ceiling; a dt below the floor ends the run."""

    dt: float
    end: float
    growth: float = 1.5
    floor: float = 0.0

    @property
    def smallest(self) -> float:
        return self.floor or self.dt / 2**20


@dataclass(frozen=True)
class Tolerances:
    """Stopping test of the fluid-structure iteration (see `StepProblem`)."""

    relative: float = 1e-4
    absolute: float = 1e-9
    max_iterations: int = 6


@dataclass(frozen=True)
class Simulation:
    """A structure, an optional fluid, a scheme and the prescribed volume, ready to run.

    Parameters
    ----------
    volume : callable
        Prescribed enclosed volume V(t).
    diagnostics : callable, optional
        Extra columns from a state, computed for accepted steps (smallest gap, ...).
    admissible : callable, optional
        Whether a configuration ``(n_full, 3)`` may be accepted (no self-intersection, ...).
    checkpoint_every : int
        Steps between checkpoints.
    """

    structure: Structure
    fluid: Fluid | None
    scheme: Scheme
    volume: Callable[[float], float]
    initial: State
    control: StepControl
    tolerances: Tolerances = Tolerances()
    recorders: Sequence[Recorder] = ()
    diagnostics: Callable[[State], Mapping[str, float]] | None = None
    admissible: Callable[[np.ndarray], bool] | None = None
    checkpoint_every: int = 10

    def run(self, start: Snapshot | None = None, steps: int | None = None) -> Outcome:
        """Advance to the end time, from a checkpoint if one is given.

        Parameters
        ----------
        start : Snapshot, optional
        steps : int, optional
            Stop (with ``Result.STOPPED``) after this many accepted steps.
        """
        return _Loop(self, start).run(steps)


@dataclass
class _Counts:
    """Totals of a run, for its record."""

    accepted: int = 0
    rejected: int = 0
    assemblies: int = 0
    newton: int = 0
    krylov: int = 0

    def add(self, attempt: Attempt) -> None:
        self.assemblies += attempt.assemblies
        self.newton += attempt.newton_iterations
        self.krylov += attempt.krylov_iterations


@dataclass
class _Loop:
    """One run in progress; the only mutable object of the package."""

    sim: Simulation
    start: Snapshot | None
    counts: _Counts = field(default_factory=_Counts)

    def __post_init__(self) -> None:
        sim = self.sim
        if self.start is None:
            self.step, self.dt, self.state = 0, sim.control.dt, sim.initial
            self.sums = dict.fromkeys(SUMS, 0.0)
            energies = sim.structure.energies(sim.initial)
            self.sums["energy_start"] = sum(energies.values())
            self.memory = sim.scheme.init()
        else:
            self.step, self.dt, self.state = self.start.step, self.start.dt, self.start.state
            self.sums, self.memory = dict(self.start.accumulated), dict(self.start.memory)
        self.clock = time.perf_counter()
        self.pending = _Counts()

    def tell(self, event: str, *args: object) -> None:
        for recorder in self.sim.recorders:
            getattr(recorder, event)(*args)

    def snapshot(self) -> Snapshot:
        return Snapshot(self.step, self.dt, self.state, dict(self.sums), dict(self.memory))

    def run(self, steps: int | None) -> Outcome:
        control = self.sim.control
        if self.start is None:
            self.tell("on_start", AcceptedStep(0, self.state, self._row(None, 0.0), None))
            self.tell("on_checkpoint", self.snapshot())
        result, last = Result.COMPLETED, self.step if steps is None else self.step + steps
        while control.end - self.state.t > 1e-9 * control.dt:
            if steps is not None and self.step >= last:
                result = Result.STOPPED
                break
            if self.dt < control.smallest:
                result = Result.STEP_FLOOR
                break
            self._advance(min(self.dt, control.end - self.state.t))
        # before close: a run that ends here resumes from its last accepted step
        self.tell("on_checkpoint", self.snapshot())
        outcome = Outcome(result, self.step, self.state.t, vars(self.counts), result.value)
        self.tell("close", outcome)
        return outcome

    def _advance(self, dt: float) -> None:
        sim = self.sim
        t = self.state.t + dt

        def report(iteration: int, residual: float, relaxation: float, converged: bool) -> None:
            self.tell(
                "on_iteration",
                Iteration(self.step + 1, t, dt, iteration, residual, relaxation, converged),
            )

        problem = StepProblem(
            sim.structure,
            sim.fluid,
            self.state,
            dt,
            sim.volume(t),
            sim.tolerances.relative,
            sim.tolerances.absolute,
            sim.tolerances.max_iterations,
            report,
        )
        attempt = sim.scheme.attempt(problem, self.memory)
        self.counts.add(attempt)
        self.pending.add(attempt)
        if attempt.cause is None and not self._admissible(attempt):
            attempt = replace(attempt, cause=Result.GEOMETRY)
        if attempt.cause is not None:
            self._reject(attempt, t, dt)
        else:
            self._accept(attempt, dt)

    def _admissible(self, attempt: Attempt) -> bool:
        check = self.sim.admissible
        return check is None or check(attempt.step.state.coefficients)

    def _reject(self, attempt: Attempt, t: float, dt: float) -> None:
        self.counts.rejected += 1
        self.memory = self.sim.scheme.reset(self.memory)
        self.dt = 0.5 * dt
        logger.info("step %d rejected at dt = %g: %s", self.step + 1, dt, attempt.cause.name)
        self.tell("on_rejected", Rejection(self.step + 1, t, dt, attempt.cause, attempt.iterations))

    def _accept(self, attempt: Attempt, dt: float) -> None:
        control, before = self.sim.control, self.state
        self.state, self.memory = attempt.step.state, attempt.memory
        self.step += 1
        self.counts.accepted += 1
        budget = self.sim.structure.budget(before, self.state, attempt.load)
        self.sums["pressure_work"] += budget["pressure_work"]
        self.sums["fluid_work"] += budget["load_work"]
        self.sums["dissipation"] += budget["dissipation"]
        growth = self.sim.volume(self.state.t) - self.sim.volume(before.t)
        row = self._row(attempt, dt, growth)
        self.pending = _Counts()
        self.dt = min(control.dt, max(self.dt, dt * control.growth))
        self.tell("on_accepted", AcceptedStep(self.step, self.state, row, attempt.traction))
        if self.step % self.sim.checkpoint_every == 0:
            self.tell("on_checkpoint", self.snapshot())
            if self.sim.fluid is not None:
                self.sim.fluid.reset()  # a resumed run starts without what is kept

    def _row(self, attempt: Attempt | None, dt: float, growth: float = 0.0) -> dict[str, float]:
        """History columns; the last one is the only one that differs between equal runs."""
        sim, state, sums = self.sim, self.state, self.sums
        energies = sim.structure.energies(state)
        stored = sum(energies.values()) - sums["energy_start"]
        work = sums["pressure_work"] + sums["fluid_work"]
        traction = attempt.traction if attempt else None
        row = {
            "step": self.step,
            "t": state.t,
            "dt": dt,
            "volume": sim.structure.volume(state.coefficients),
            "volume_prescribed": sim.volume(state.t),
            "area": sim.structure.area(state.coefficients),
            "pressure": state.pressure,
            **{f"{name}_energy": value for name, value in energies.items()},
            **{name: sums[name] for name in SUMS},
            "energy_defect": stored + sums["dissipation"] - work,
            "zeta": traction.zeta if traction else 0.0,
            "flux_ratio": growth / (dt * traction.flux) if traction and traction.flux else 1.0,
            "velocity_max": traction.velocity_max if traction else _largest(state.velocity),
            **(sim.diagnostics(state) if sim.diagnostics else {}),
            "subiterations": attempt.iterations if attempt else 0,
            "assemblies": self.pending.assemblies,
            "newton_iterations": self.pending.newton,
            "krylov_iterations": self.pending.krylov,
            "wall_time": time.perf_counter() - self.clock,
        }
        return row


def _largest(velocity: np.ndarray) -> float:
    return float(np.linalg.norm(velocity, axis=-1).max())
