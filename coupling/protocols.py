"""What the schemes and the time loop ask of a structure, a fluid and a collision test.

Sign: a load enters the momentum balance as ``M a + W'(theta) - p Q'(theta) = load``. On a frozen
geometry the fluid is linear: ``load(traction(v)) = response() @ v + drive()``.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from typing import Any, Protocol, TypeAlias, TypeVar

import numpy as np
from scipy.sparse.linalg import LinearOperator

from .exchange import Result, State, StateLike, Traction

T = TypeVar("T", bound=Traction)


class StructureStep(Protocol):
    """Outcome of one structure solve: the new state, or (``ok`` false) why there is none."""

    @property
    def state(self) -> StateLike:
        """New state."""

    @property
    def newton_iterations(self) -> int:
        """Newton iterations taken."""

    @property
    def ok(self) -> bool:
        """Whether the solve succeeded."""

    @property
    def outcome(self) -> enum.Enum:
        """How the solve ended."""


class DenseMap(Protocol):
    """A linear map of velocities that is an array on request."""

    def dense(self) -> np.ndarray:
        """Form the array.

        Returns
        -------
        (3 n_full, 3 n_full) array
        """

    def __matmul__(self, velocity: np.ndarray) -> np.ndarray: ...


Damping: TypeAlias = np.ndarray | LinearOperator | DenseMap


class FluidOperator(Protocol[T]):
    """The fluid on one frozen geometry, with tractions of its own type T."""

    def traction(self, velocity: np.ndarray) -> T:
        """Solve for the traction jump; the influx follows the flux of the velocity.

        Parameters
        ----------
        velocity : (n_full, 3) array
            Of the membrane.

        Returns
        -------
        Traction
            Or an object with its attributes.
        """

    def load(self, traction: T) -> np.ndarray:
        """Integrate the force ``-m <tau, rho>`` on the membrane.

        Parameters
        ----------
        traction : Traction

        Returns
        -------
        (n_full, 3) array
        """

    def response(self) -> LinearOperator:
        """Give the linear map from velocity to load less `drive`.

        Returns
        -------
        LinearOperator
            ``3 n_full`` square, with a method ``dense()`` where it is small.
        """

    def drive(self) -> np.ndarray | None:
        """Give the load at rest: that of a background flow.

        Returns
        -------
        (n_full, 3) array or None
            None where there is none.
        """

    def flux(self, velocity: np.ndarray) -> float:
        """Integrate the flux of a velocity out through the membrane.

        Parameters
        ----------
        velocity : (n_full, 3) array

        Returns
        -------
        float
        """


class Fluid(Protocol):
    """A fluid model; assembling costs, so one operator serves one geometry."""

    def assemble(self, coefficients: np.ndarray) -> FluidOperator[Any]:
        """Make the operator of one geometry.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        FluidOperator
        """

    def reset(self) -> None:
        """Forget what is reused from one geometry to the next; called at checkpoints."""


class Structure(Protocol):
    """A structure with its enclosed volume; ``step`` solves one implicit time step."""

    def step(
        self,
        state: State,
        load: np.ndarray | None,
        dt: float,
        volume: float,
        damping: Damping | None = None,
        guess: np.ndarray | None = None,
    ) -> StructureStep:
        """Take a backward-Euler step to a given enclosed volume.

        Parameters
        ----------
        state : State
        load : (n_full, 3) array or None
        dt, volume : float
            Length of the step and enclosed volume at its end.
        damping : array or operator, optional
            C, ``3 n_full`` square, adds ``C v_{n+1}`` to the residual.
        guess : (n_full, 3) array, optional
            Where Newton starts; default the predictor.

        Returns
        -------
        StructureStep
        """

    def energies(self, state: State) -> Mapping[str, float]:
        """Compute kinetic, membrane and bending energy, and that of contact forces.

        Parameters
        ----------
        state : State

        Returns
        -------
        mapping of float
            By name: the history has a column of each.
        """

    def linearised(self, state: State, dt: float) -> LinearOperator:
        """Give the inverse tangent with its volume row.

        Parameters
        ----------
        state : State
        dt : float

        Returns
        -------
        LinearOperator
            ``3 n_full`` square.
        """

    def budget(
        self,
        start: State,
        end: State,
        load: np.ndarray | None,
        *,
        acceleration: np.ndarray | None = None,
    ) -> Mapping[str, float]:
        """Compute the works done over a step.

        Parameters
        ----------
        start, end : State
        load : (n_full, 3) array or None
        acceleration : (n_full, 3) array, optional
            That of the integrator; default backward Euler's.

        Returns
        -------
        mapping of float
            ``pressure_work``, ``load_work`` and the integrator's ``dissipation``.
        """

    def volume(self, coefficients: np.ndarray) -> float:
        """Compute the enclosed volume.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        float
        """

    def area(self, coefficients: np.ndarray) -> float:
        """Compute the area of the membrane.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        float
        """

    def measure(self, increment: np.ndarray) -> float:
        """Compute the root mean square of a displacement, for stopping tests.

        Parameters
        ----------
        increment : (n_full, 3) array

        Returns
        -------
        float
        """


class CollisionTest(Protocol):
    """Tests every predicted, iterated and accepted configuration."""

    def inspect(self, before: np.ndarray, after: np.ndarray) -> Result | None:
        """Say why a configuration cannot be reached straight from the accepted one.

        Parameters
        ----------
        before, after : (n_full, 3) array

        Returns
        -------
        Result or None
            None if it can be reached; otherwise the result of a run that ends because of it.
        """
