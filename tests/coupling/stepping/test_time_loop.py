"""Step control: rejection as a whole, halving, growth, floor, checkpoints."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from coupling.exchange import Result, State
from coupling.schemes.contraction import contraction_forecast
from coupling.schemes.scheme import StepResult
from coupling.stepping.integrator import BDF2
from coupling.stepping.step_control import StepControl
from coupling.stepping.time_loop import Simulation


@dataclass(frozen=True)
class Step:
    state: State


class Point:
    """A structure that is one coefficient; its energy is its square."""

    def energies(self, state):
        return {"kinetic": 0.0, "membrane": float(np.sum(state.coefficients**2))}

    def budget(self, start, end, load):
        change = np.sum(end.coefficients**2) - np.sum(start.coefficients**2)
        return {"pressure_work": float(change), "load_work": 0.0, "dissipation": 0.0}

    def volume(self, coefficients):
        return 1.0

    def area(self, coefficients):
        return 1.0


@dataclass
class Fussy:
    """Accepts steps only up to ``largest(t)``; counts in its memory."""

    largest: object
    seen: list = field(default_factory=list)

    def init(self):
        return {"count": np.array(0)}

    def reset(self, memory):
        return memory

    def attempt(self, problem, memory):
        self.seen.append((problem.state.t, problem.dt))
        if problem.dt > self.largest(problem.state.t):
            return StepResult(Result.COUPLING, iterations=3, assemblies=3)
        new = problem.state.coefficients + problem.dt
        state = State(problem.state.t + problem.dt, new, np.ones_like(new))
        return StepResult(None, Step(state), memory={"count": memory["count"] + 1}, iterations=1)


@dataclass
class Log:
    accepted: list = field(default_factory=list)
    rejected: list = field(default_factory=list)
    snapshots: list = field(default_factory=list)
    outcome: object = None

    def on_start(self, step):
        self.accepted.append(step)

    def on_iteration(self, iteration): ...

    def on_accepted(self, step):
        self.accepted.append(step)

    def on_rejected(self, rejection):
        self.rejected.append(rejection)

    def on_note(self, step, text): ...

    def on_checkpoint(self, snapshot):
        self.snapshots.append(snapshot)

    def close(self, outcome):
        self.outcome = outcome


def simulation(largest, log, **control):
    zero = np.zeros((1, 3))
    options = {"dt": 4.0, "end": 40.0} | control
    return Simulation(
        Point(), None, Fussy(largest), lambda t: 1.0, State(0.0, zero, zero),
        StepControl(**options), recorders=(log,), checkpoint_every=3,
    )  # fmt: skip


def test_equal_steps_when_nothing_fails():
    log = Log()
    outcome = simulation(lambda t: 10.0, log).run()
    assert outcome.result is Result.COMPLETED
    assert [s.row["dt"] for s in log.accepted[1:]] == [4.0] * 10
    assert log.accepted[-1].state.t == 40.0


def test_rejection_halves_and_acceptance_grows_back():
    log = Log()
    outcome = simulation(lambda t: 1.0 if 8.0 <= t < 10.0 else 10.0, log).run()
    assert outcome.result is Result.COMPLETED
    steps = [s.row["dt"] for s in log.accepted[1:]]
    assert steps[:3] == [4.0, 4.0, 1.0]  # two halvings at t = 8
    assert [r.dt for r in log.rejected][:2] == [4.0, 2.0]
    assert max(steps) == 4.0  # grown back, never above the scene's
    assert outcome.t == pytest.approx(40.0, abs=1e-12)
    # assemblies of rejected tries belong to the step that was accepted in the end
    assert log.accepted[3].row["assemblies"] == 6
    # the state moved only through accepted steps
    assert log.accepted[-1].state.coefficients == pytest.approx(40.0)


def test_floor_ends_the_run_with_its_cause():
    log = Log()
    outcome = simulation(lambda t: 10.0 if t < 8.0 else 0.0, log, floor=0.1).run()
    assert outcome.result is Result.STEP_FLOOR
    assert outcome.t == 8.0
    assert log.snapshots[-1].state.t == 8.0  # resumable from the last accepted step


def test_resume_repeats_the_same_rows():
    def largest(t):
        return 1.0 if 8.0 <= t < 14.0 else 10.0

    whole, first, second = Log(), Log(), Log()
    simulation(largest, whole).run()
    simulation(largest, first).run(steps=5)
    snapshot = next(s for s in reversed(first.snapshots) if s.step == 3)
    simulation(largest, second).run(snapshot)

    def rows(log, after):
        kept = [dict(s.row) for s in log.accepted if s.step > after]
        return [{k: v for k, v in row.items() if k != "wall_time"} for row in kept]

    assert rows(second, 3) == rows(whole, 3)


def test_energy_defect_is_zero_for_a_balanced_step():
    log = Log()
    simulation(lambda t: 10.0, log).run()
    assert max(abs(s.row["energy_defect"]) for s in log.accepted) < 1e-11


@pytest.mark.parametrize(("half_width", "rho"), [(10.0, 0.49), (20.0, 2.2)])
def test_forecast_of_the_pancakes(half_width, rho):
    """Formula figures of the pancake study at dt = 1, m = .005."""
    value = contraction_forecast(0.005, 1.0, element_size=0.5, gap=2.0, extent=half_width - 1.0)
    assert value == pytest.approx(rho, rel=0.01)


def test_limits_never_lower_the_step_below_its_floor():
    """A slow step at the floor is taken and judged; only its rejection may end the run."""
    control = StepControl(4.0, 40.0, floor=0.5)
    shared = {"effort": 0.1, "error": 0.0, "order": 1}
    assert control.next(4.0, 4.0, gap=0.1, speed=1.0, **shared)[0] == 0.5
    assert control.next(4.0, 4.0, gap=3.0, speed=1.0, **shared)[0] == 1.5
    assert control.next(4.0, 4.0, gap=0.1, speed=-1.0, **shared) == (4.0, "")


class Touch:
    """Contact that carries: three samples within 0.1 from t = 8 on."""

    def __init__(self, t=0.0):
        self.t = t

    def at(self, t):
        return Touch(t)

    def force(self, c):
        return np.array([3.0, 0.0, -4.0])

    def distance(self, c):
        return 0.1 if self.t >= 8.0 else np.inf

    def within_reach(self, c):
        return 3 if self.t >= 8.0 else 0


class Walls:
    """Refuses every way, but no place."""

    def inspect(self, before, after):
        return None if before is after else Result.SELF_INTERSECTION


def test_contact_that_carries():
    """Steps close a gap as they like, only where they end is tested, and the history tells."""
    logs = Log(), Log(), Log()
    gap = {"diagnostics": lambda state: {"min_gap": 41.0 - state.t}, "collision": Walls()}
    free, held, walled = (simulation(lambda t: 10.0, log) for log in logs)
    assert replace(free, contact=Touch(), **gap).run().result is Result.COMPLETED
    assert [s.row["dt"] for s in logs[0].accepted[1:]] == [4.0] * 10
    rows = [s.row for s in logs[0].accepted]
    assert [row["contacts"] for row in rows[:4]] == [0, 0, 3, 3]
    assert rows[2]["contact_distance"] == 0.1
    assert rows[2]["contact_force"] == 5.0
    replace(held, **(gap | {"collision": None})).run()
    assert min(s.row["dt"] for s in logs[1].accepted[1:]) < 1.0
    assert "contacts" not in logs[1].accepted[-1].row
    ended = replace(walled, control=StepControl(4.0, 40.0, floor=1.0), **gap).run()
    assert ended.result is Result.SELF_INTERSECTION
    with pytest.raises(ValueError, match="backward-euler"):
        replace(free, contact=Touch(), integrator=BDF2())
