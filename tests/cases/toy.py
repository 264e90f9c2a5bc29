"""A kind that stands in for the inflation: a tube that swells, with memory and rejected steps.

Run as a script (``toy.py OUT KILL_AT``) it is killed with SIGKILL inside a step.
"""

from __future__ import annotations

import os
import signal
import sys
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from cases.kinds.inflation import KIND
from cases.kinds.kind import TimeFolder
from coupling import Result, Simulation, State, StepControl, StepResult

AROUND, ROWS = 8, 4


@dataclass
class Step:
    state: State


class Tube:
    def energies(self, state):
        kinetic = 0.5 * float(np.sum(state.velocity**2))
        return {"kinetic": kinetic, "membrane": float(np.sum(state.coefficients**2)) / 7.0}

    def budget(self, before, after, load):
        return {"pressure_work": after.t / 3.0, "load_work": 0.1, "dissipation": 0.0}

    def volume(self, coefficients):
        return 1.0 + float(np.mean(coefficients**2))

    def area(self, coefficients):
        return float(np.abs(coefficients).sum())


@dataclass
class Scheme:
    """Grows with a rate it remembers; large steps fail between t = 40 and 60."""

    kill_at: int = 0
    error_at: int = 0
    error: type[BaseException] = RuntimeError
    done: int = 0

    def init(self):
        return {"rate": np.array(1e-3), "load": np.ones((3, 2)) / 3.0}

    def reset(self, memory):
        return memory

    def attempt(self, problem, memory):
        state, dt = problem.state, problem.dt
        self.done += 1
        if self.done == self.kill_at:
            os.kill(os.getpid(), signal.SIGKILL)
        if self.done == self.error_at:
            raise self.error
        problem.report(1, 0.5, 1.0, False)
        if 40.0 < state.t < 60.0 and dt > 4.0:
            return StepResult(Result.COUPLING, iterations=1)
        problem.report(2, 1e-6, 1.0, True)
        velocity = float(memory["rate"]) * state.coefficients
        new = State(state.t + dt, state.coefficients + dt * velocity, velocity, np.sin(state.t))
        memory = {"rate": memory["rate"] * 1.01, "load": memory["load"] * 1.1}
        traction = plain_traction(1e-2 * velocity, 1e-7)
        return StepResult(None, Step(new), None, traction, memory, 2, 2, 5, 11)


def plain_traction(coefficients: np.ndarray, zeta: float) -> SimpleNamespace:
    rest = {"flux": 0.0, "velocity_max": 0.0, "iterations": 0, "residual": 0.0}
    return SimpleNamespace(coefficients=coefficients, zeta=zeta, **rest)


def initial() -> np.ndarray:
    angle = 2.0 * np.pi * np.arange(AROUND) / AROUND
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.concatenate([np.column_stack([ring, np.full(AROUND, z)]) for z in range(ROWS)])


class Sampler:
    def surface_grid(self, coefficients, traction=None, velocity=None, tessellate=3):
        i, j = (g.ravel() for g in np.meshgrid(range(ROWS - 1), range(AROUND), indexing="ij"))
        k = (j + 1) % AROUND
        below, above = i * AROUND, (i + 1) * AROUND
        quads = np.stack([below + j, above + j, above + k, below + k], axis=1)
        data = {"velocity": velocity} | ({} if traction is None else {"traction": traction})
        part = np.zeros(len(quads), dtype=int)
        return {
            "points": coefficients,
            "quads": quads,
            "point_data": data,
            "cell_data": {"part": part},
        }


def start() -> State:
    return State(0.0, initial(), np.zeros((AROUND * ROWS, 3)))


@dataclass
class ToySimulated:
    """A scene as objects."""

    scene: object
    scheme: object
    initial: State = field(default_factory=start)
    sampler: object = field(default_factory=Sampler)
    skips: tuple = ("toy: all",)
    accuracy: None = None
    fluid: None = None

    def simulation(self, recorders=()):
        time = self.scene.time
        return Simulation(
            structure=Tube(),
            fluid=None,
            scheme=self.scheme,
            volume=lambda t: 1.0 + t,
            initial=self.initial,
            control=StepControl(time.dt, time.end, floor=time.dt_floor),
            recorders=recorders,
            diagnostics=lambda state: {"min_gap": 2.0},
            checkpoint_every=self.scene.output.checkpoint_every,
        )


class ToyKind(TimeFolder):
    """The inflation's tables and pictures, with a run of its own."""

    def __init__(self, scheme=None):
        super().__init__(**{f.name: getattr(KIND, f.name) for f in fields(KIND)})
        object.__setattr__(self, "scheme", scheme)

    def simulated(self, scene):
        return ToySimulated(scene, self.scheme or Scheme())


if __name__ == "__main__":
    from cases import cli
    from cases.kinds import KINDS

    KINDS["inflation"] = ToyKind(Scheme(kill_at=int(sys.argv[2])))
    folder = str(Path(sys.argv[1]))
    sys.exit(cli.main(["run", "pancake", "--set", "time.dt=8", "--set", "time.end=160", "--set",
                       "output.checkpoint_every=4", "--set", "output.fields_every=3",
                       "--out", folder]))  # fmt: skip
