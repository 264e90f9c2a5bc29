"""The data that structure, fluid and time loop exchange: results, tractions, states.

A configuration is one array of spline coefficients ``(n_full, 3)`` shared by structure and fluid;
loads are dual arrays of the same shape (force tested with each spline function).
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Protocol

import numpy as np


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
        "the membrane meets itself and no smaller step avoids it; let contact carry load (bags in "
        "space: contact.force = 'barrier'), model the exterior (fluid.viscosity_ratio > 0) or "
        "refine the mesh there"
    )
    INLET_CONTACT = (
        "the membrane reached the inlet, where no lubrication keeps it away; let contact carry "
        "load (contact.force = 'barrier') or stop the outflow earlier"
    )
    TIME_ERROR = "the local time error exceeds its tolerance; the step is repeated with a lower dt"
    STEP_FLOOR = "the time step fell below its floor; see iterations.log for the causes"

    @property
    def ok(self) -> bool:
        """Whether the run reached its end time."""
        return self is Result.COMPLETED


class Traction(Protocol):
    """What the time loop reads of a fluid's traction jump on one geometry.

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

    @property
    def coefficients(self) -> np.ndarray: ...

    @property
    def zeta(self) -> float: ...

    @property
    def flux(self) -> float: ...

    @property
    def velocity_max(self) -> float: ...

    @property
    def iterations(self) -> int: ...

    @property
    def residual(self) -> float: ...


class StateLike(Protocol):
    """What the time loop reads of a structure's new state; `State` says what it means."""

    @property
    def t(self) -> float: ...

    @property
    def coefficients(self) -> np.ndarray: ...

    @property
    def velocity(self) -> np.ndarray: ...

    @property
    def pressure(self) -> float: ...


@dataclass(frozen=True)
class State:
    """Where the structure is and how it moves.

    Parameters
    ----------
    t : float
    coefficients, velocity : (n_full, 3) array
    pressure : float
        Excess pressure inside.
    """

    t: float
    coefficients: np.ndarray
    velocity: np.ndarray
    pressure: float = 0.0
