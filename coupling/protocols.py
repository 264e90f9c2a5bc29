"""What the time loop asks of a structure, a fluid and a recorder, and the data they exchange.

A configuration is one array of spline coefficients ``(n_full, 3)`` shared by structure and
fluid; loads are dual arrays of the same shape (force tested with each spline function).
Sign: a load enters the momentum balance as ``M a + W'(theta) - p Q'(theta) = load``.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from scipy.sparse.linalg import LinearOperator


class Result(enum.Enum):
    """How a run, a step or an iteration ended; the value is the advice shown to the user."""

    COMPLETED = "completed"
    STOPPED = "stopped by the caller before the end time; resume continues it"
    NEWTON = "the structure's Newton iteration did not converge; lower time.dt"
    COUPLING = (
        "the fluid-structure iteration did not converge; "
        "use coupling.scheme = 'implicit' or lower time.dt"
    )
    KRYLOV = "the fluid solve missed its residual; raise fluid.krylov_iterations"
    GEOMETRY = "the configuration folded over itself or lost its orientation"
    SELF_INTERSECTION = (
        "the membrane meets itself and no smaller step avoids it; model the exterior "
        "(fluid.viscosity_ratio > 0) or refine the mesh there"
    )
    INLET_CONTACT = (
        "the membrane reached the inflow patch, where no lubrication keeps it away; stop the "
        "outflow earlier or clamp the rim"
    )
    TIME_ERROR = "the local time error exceeds its tolerance; the step is repeated with a lower dt"
    STEP_FLOOR = "the time step fell below its floor; see iterations.log for the causes"

    @property
    def ok(self) -> bool:
        return self is Result.COMPLETED


@dataclass(frozen=True)
class Traction:
    """Fluid traction jump on one geometry.

    Attributes
    ----------
    coefficients : (n_density, 3) array
        Coefficients of the traction (per unit ``1/Re``) in the fluid's density space.
    zeta : float
        Multiplier of ``<tau, n> = 0``: quadrature plus Krylov error, a health indicator.
    flux : float
        Discrete flux of the membrane velocity, which the influx follows.
    velocity_max : float
        Largest velocity on the boundary, inflow included.
    iterations : int
        Krylov iterations (0 for a direct solve).
    residual : float
        Achieved relative residual of the linear system.
    """

    coefficients: np.ndarray
    zeta: float
    flux: float = 0.0
    velocity_max: float = 0.0
    iterations: int = 0
    residual: float = 0.0


@dataclass(frozen=True)
class State:
    """Accepted state: time, coefficients and velocity ``(n_full, 3)``, excess pressure."""

    t: float
    coefficients: np.ndarray
    velocity: np.ndarray
    pressure: float = 0.0


class StructureStep(Protocol):
    """Outcome of one structure solve: the new state, or (``ok`` false) why there is none."""

    state: State
    newton_iterations: int

    @property
    def ok(self) -> bool: ...

    @property
    def outcome(self) -> enum.Enum: ...


class FluidOperator(Protocol):
    """The fluid on one frozen geometry."""

    def traction(self, velocity: np.ndarray) -> Traction:
        """Traction jump for membrane velocity ``(n_full, 3)``; influx follows its flux."""

    def load(self, traction: Traction) -> np.ndarray:
        """Force ``-m <tau, rho>`` on the membrane, ``(n_full, 3)``."""

    def response(self) -> LinearOperator:
        """Velocity to load less `drive`, ``3 n_full`` square; ``.dense()`` if small."""

    def drive(self) -> np.ndarray | None:
        """Load at rest: that of a background flow; None where there is none."""

    def flux(self, velocity: np.ndarray) -> float:
        """Discrete flux of the velocity out through the membrane."""


class Fluid(Protocol):
    """A fluid model; assembling costs, so one operator serves one geometry."""

    def assemble(self, coefficients: np.ndarray) -> FluidOperator: ...

    def reset(self) -> None:
        """Forget what is kept from one geometry to the next; called at checkpoints."""


class Structure(Protocol):
    """A structure with its enclosed volume; ``step`` solves one implicit time step."""

    def step(
        self,
        state: State,
        load: np.ndarray | None,
        dt: float,
        volume: float,
        damping: Any = None,
        guess: np.ndarray | None = None,
    ) -> StructureStep:
        """Backward-Euler step to the enclosed ``volume``.

        ``damping`` C (array or operator with ``dense()``, ``3 n_full`` square) adds
        ``C v_{n+1}`` to the residual; ``guess`` starts Newton (default: the predictor).
        """

    def energies(self, state: State) -> Mapping[str, float]:
        """Kinetic, membrane and bending energy."""

    def linearised(self, state: State, dt: float) -> LinearOperator:
        """Inverse tangent with its volume row, ``3 n_full`` square."""

    def budget(self, start: State, end: State, load: np.ndarray | None) -> Mapping[str, float]:
        """Pressure work, load work and the integrator's dissipation over a step."""

    def volume(self, coefficients: np.ndarray) -> float: ...

    def area(self, coefficients: np.ndarray) -> float: ...

    def measure(self, coefficients: np.ndarray) -> float:
        """Root-mean-square size of an increment ``(n_full, 3)``, for stopping tests."""


class CollisionTest(Protocol):
    """Tests every predicted, iterated and accepted configuration."""

    def inspect(self, before: np.ndarray, after: np.ndarray) -> Result | None:
        """Why ``after`` cannot be reached from the accepted ``before``; None if it can.

        A run that ends at the floor of its step because of it has this `Result`.
        """


@dataclass(frozen=True)
class Iteration:
    """One subiteration: step index, attempt and iteration count, relative residual."""

    step: int
    t: float
    dt: float
    iteration: int
    residual: float
    relaxation: float
    converged: bool


@dataclass(frozen=True)
class Rejection:
    """A step that was rolled back as a whole."""

    step: int
    t: float
    dt: float
    cause: Result
    iterations: int


@dataclass(frozen=True)
class AcceptedStep:
    """An accepted step: its history row, the state and the traction (None without fluid)."""

    step: int
    state: State
    row: Mapping[str, float]
    traction: Traction | None


@dataclass(frozen=True)
class Snapshot:
    """Everything a run needs to continue with the same arithmetic: the checkpoint.

    ``accumulated`` holds running sums of the history, ``memory`` what the coupling scheme
    carries from step to step (scalars and arrays).
    """

    step: int
    dt: float
    state: State
    accumulated: Mapping[str, float]
    memory: Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Outcome:
    """How the run ended, with counts for run.json."""

    result: Result
    step: int
    t: float
    counts: Mapping[str, float]
    detail: str = ""

    @property
    def where(self) -> str:
        return f"step {self.step}, t = {self.t:g}"

    @property
    def summary(self) -> str:
        rejected, assemblies = (self.counts.get(k, 0) for k in ("rejected", "assemblies"))
        return f"{rejected} rejected steps, {assemblies} assemblies"


class Recorder(Protocol):
    """Receives what happens; never changes it."""

    def on_start(self, step: AcceptedStep) -> None: ...

    def on_iteration(self, iteration: Iteration) -> None: ...

    def on_accepted(self, step: AcceptedStep) -> None: ...

    def on_rejected(self, rejection: Rejection) -> None: ...

    def on_checkpoint(self, snapshot: Snapshot) -> None: ...

    def on_note(self, step: int, text: str) -> None:
        """Something a reader of the log should know: a scheme changed, a step was limited."""

    def close(self, outcome: Outcome) -> None: ...
