"""The time loop: steps accepted or rejected as a whole, history rows, checkpoints.

A rejected step leaves no trace but its record: state, scheme memory and sums are those of the
last accepted step, and dt is halved. Acceptance lets dt grow again, never above the scene's. The
loop writes nothing itself; recorders do.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from ..contact.carried import CarriedContact
from ..contact.watch import Watch
from ..exchange import Result, State
from ..protocols import CollisionTest, Fluid, Structure
from ..records import AcceptedStep, Iteration, Outcome, Recorder, Rejection, Snapshot
from ..schemes.scheme import Memory, Scheme, StepProblem, StepResult, Tolerances
from .contact_guard import ContactGuard
from .history_row import SUMS, Counts, history_row
from .integrator import BackwardEuler, Integrator, Past
from .operator_reuse import without_reused
from .step_control import StepControl

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Simulation:
    """A structure, an optional fluid, a scheme and the prescribed volume, ready to run.

    Parameters
    ----------
    structure : Structure
    fluid : Fluid or None
        None for a uniform pressure.
    scheme : Scheme
    volume : callable
        Prescribed enclosed volume V(t).
    initial : State
    control : StepControl
    tolerances : Tolerances
    recorders : sequence of Recorder
        Told what happens, in this order.
    diagnostics : callable, optional
        Extra columns from a state, computed for accepted steps (smallest gap, ...).
    checkpoint_every : int
        Steps between checkpoints.
    integrator : Integrator
    collision : CollisionTest, optional
    watch : Watch, optional
        Says from when on the collision test is due, by the diagnostic ``min_gap``; default always.
    contact : CarriedContact, optional
        That of the structure: `StepControl.closing` is off, and where a step ends is tested, not
        the straight way there. Needs `BackwardEuler`, which starts from states that were tested.
    """

    structure: Structure
    fluid: Fluid | None
    scheme: Scheme
    volume: Callable[[float], float]
    initial: State
    control: StepControl
    tolerances: Tolerances = field(default_factory=Tolerances)
    recorders: Sequence[Recorder] = ()
    diagnostics: Callable[[State], Mapping[str, float]] | None = None
    checkpoint_every: int = 10
    integrator: Integrator = field(default_factory=BackwardEuler)
    collision: CollisionTest | None = None
    watch: Watch | None = None
    contact: CarriedContact | None = None

    def __post_init__(self) -> None:
        if self.contact is not None and not isinstance(self.integrator, BackwardEuler):
            raise ValueError("contact that carries load needs time.integrator = 'backward-euler'")

    def run(self, start: Snapshot | None = None, steps: int | None = None) -> Outcome:
        """Advance to the end time.

        Parameters
        ----------
        start : Snapshot, optional
            Checkpoint to go on from; default the initial state.
        steps : int, optional
            Stop (with ``Result.STOPPED``) after this many accepted steps.

        Returns
        -------
        Outcome
            An interrupt or error is passed on after a checkpoint of the last accepted step.
        """
        loop = _Loop(self, start)
        try:
            return loop.run(steps)
        except BaseException:
            loop.rescue()
            raise


@dataclass
class _Loop:
    """One run in progress."""

    sim: Simulation
    start: Snapshot | None
    counts: Counts = field(default_factory=Counts)

    def __post_init__(self) -> None:
        sim = self.sim
        self.memory: Memory
        self.past: Past
        if self.start is None:
            self.step, self.dt, self.state = 0, sim.control.dt, sim.initial
            energy = sum(sim.structure.energies(sim.initial).values())
            self.sums = {**dict.fromkeys(SUMS, 0.0), "energy_start": energy}
            self.memory, self.past = sim.scheme.init(), {}
        else:
            self.step, self.dt, self.state = self.start.step, self.start.dt, self.start.state
            self.sums = dict(self.start.accumulated)
            self.past = {k[5:]: v for k, v in self.start.memory.items() if k.startswith("past.")}
            self.memory = {k: v for k, v in self.start.memory.items() if not k.startswith("past.")}
        self.clock, self.pending = time.perf_counter(), Counts()
        self.causes: list[Result] = []  # of the rejections since the last accepted step
        self.gap = float("inf")
        self.safe = self.start  # the last step that recorders have heard of as a whole
        self.target = self.sim.volume(self.state.t)
        self.guard = ContactGuard(sim.collision, sim.watch, self._note)

    def tell(self, event: str, *args: object) -> None:
        for recorder in self.sim.recorders:
            getattr(recorder, event)(*args)

    def snapshot(self) -> Snapshot:
        memory = {**self.memory, **{f"past.{k}": v for k, v in self.past.items()}}
        return Snapshot(self.step, self.dt, self.state, dict(self.sums), memory)

    def rescue(self) -> None:
        """Tell the last accepted step as a checkpoint, if it can still be written."""
        if self.safe is not None:
            with suppress(OSError):
                self.tell("on_checkpoint", self.safe)

    def run(self, steps: int | None) -> Outcome:
        control = self.sim.control
        row = self._row(None, 0.0)
        self.gap = row.get("min_gap", self.gap)
        if self.start is None:
            self.tell("on_start", AcceptedStep(0, self.state, row, None))
            self.safe = self.snapshot()
            self.tell("on_checkpoint", self.safe)
        result, last = Result.COMPLETED, self.step if steps is None else self.step + steps
        while control.end - self.state.t > 1e-9 * control.dt:
            if steps is not None and self.step >= last:
                result = Result.STOPPED
                break
            if ending := control.ending(self.dt, self.causes):
                result = ending
                break
            self._advance(min(self.dt, control.end - self.state.t))
        # before close: a run that ends here resumes from its last accepted step
        self.tell("on_checkpoint", self.snapshot())
        outcome = Outcome(result, self.step, self.state.t, vars(self.counts), result.value)
        self.tell("close", outcome)
        return outcome

    def _advance(self, dt: float) -> None:
        sim, t = self.sim, self.state.t + dt
        self.target = sim.volume(t)

        def report(iteration: int, residual: float, relaxation: float, converged: bool) -> None:
            self.tell(
                "on_iteration",
                Iteration(self.step + 1, t, dt, iteration, residual, relaxation, converged),
            )

        base, length = sim.integrator.base(self.state, self.past, dt)
        problem = StepProblem(
            sim.structure,
            sim.fluid,
            base,
            length,
            self.target,
            sim.tolerances.relative,
            sim.tolerances.absolute,
            sim.tolerances.max_iterations,
            report,
            self.state.coefficients,
            self._inspect,
            self._verify,
            sim.collision is not None,
        )
        result = self._attempt(problem)
        cause, error = result.failure or self._verify(result.state.coefficients), 0.0
        if cause is None and sim.control.error > 0.0:
            estimate = sim.integrator.error(self.state, result.state, self.past, dt)
            error = sim.structure.measure(estimate)
            cause = Result.TIME_ERROR if sim.control.too_inaccurate(error) else None
        if cause is not None:
            self._reject(cause, result.iterations, t, dt)
        else:
            self._accept(result, dt, (base, length), error)

    def _attempt(self, problem: StepProblem) -> StepResult:
        """The scheme's answer, counted and noted; reused operators are no assemblies."""
        sim = self.sim
        result, reused = without_reused(sim.fluid, lambda: sim.scheme.attempt(problem, self.memory))
        self.counts.reused += reused
        self.counts.add(result)
        self.pending.add(result)
        for note in result.notes:
            self._note(note)
        return result

    def _inspect(self, coefficients: np.ndarray, straight: bool = True) -> Result | None:
        """Why a configuration cannot be reached from the accepted one."""
        volume = min(self.sim.volume(self.state.t), self.target)
        before = self.state.coefficients
        return self.guard.inspect(self.step + 1, before, coefficients, self.gap, volume, straight)

    def _verify(self, coefficients: np.ndarray) -> Result | None:
        """Why what the structure reached from the accepted one cannot be."""
        return self._inspect(coefficients, self.sim.contact is None)

    def _note(self, text: str) -> None:
        logger.info("step %d: %s", self.step + 1, text)
        self.tell("on_note", self.step + 1, text)

    def _reject(self, cause: Result, iterations: int, t: float, dt: float) -> None:
        self.counts.rejected += 1
        self.causes.append(cause)
        self.memory = self.sim.scheme.reset(self.memory)
        self.dt = 0.5 * dt
        logger.info("step %d rejected at dt = %g: %s", self.step + 1, dt, cause.name)
        self.tell("on_rejected", Rejection(self.step + 1, t, dt, cause, iterations))

    def _accept(
        self, result: StepResult, dt: float, euler: tuple[State, float], error: float
    ) -> None:
        before, base, length = self.state, *euler
        self.past = self.sim.integrator.past(before, dt)
        self.state, self.memory = result.state, result.memory
        self.step += 1
        self.counts.accepted += 1
        self.causes.clear()
        moved = (self.state.velocity - base.velocity) / length
        rate = {} if base is before else {"acceleration": moved}
        budget = self.sim.structure.budget(before, self.state, result.load, **rate)
        for name, part in zip(SUMS, ("pressure_work", "load_work", "dissipation"), strict=True):
            self.sums[name] += budget[part]
        growth = self.sim.volume(self.state.t) - self.sim.volume(before.t)
        row = self._row(result, dt, growth)
        self._next_step(result, dt, row, error)
        self.pending = Counts()
        self.tell("on_accepted", AcceptedStep(self.step, self.state, row, result.traction))
        self.safe = self.snapshot()
        if self.step % self.sim.checkpoint_every == 0:
            self.tell("on_checkpoint", self.safe)
            if self.sim.fluid is not None:
                self.sim.fluid.reset()  # a resumed run starts without reused operators

    def _next_step(
        self, result: StepResult, dt: float, row: Mapping[str, float], error: float
    ) -> None:
        gap = row.get("min_gap", float("inf"))
        closes = np.isfinite(self.gap - gap) and self.sim.contact is None
        speed = (self.gap - gap) / dt if closes else 0.0
        self.gap = gap
        self.dt, why = self.sim.control.next(
            self.dt,
            dt,
            effort=result.iterations / self.sim.tolerances.max_iterations,
            error=error,
            order=self.sim.integrator.order,
            gap=gap,
            speed=speed,
        )
        if why:
            self._note(f"next dt = {self.dt:.3g}: {why}")

    def _row(self, result: StepResult | None, dt: float, growth: float = 0.0) -> dict[str, float]:
        sim, state = self.sim, self.state
        return history_row(
            sim.structure,
            state,
            self.sums,
            step=self.step,
            dt=dt,
            volume=sim.volume(state.t),
            growth=growth,
            result=result,
            extra=sim.diagnostics(state) if sim.diagnostics else {},
            contact=sim.contact,
            work=self.pending,
            wall_time=time.perf_counter() - self.clock,
        )
