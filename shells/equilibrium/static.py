"""Static equilibria: ``W'(theta) - p Q'(theta) = load(theta)``, with ``Q(theta) = V`` if asked."""

from __future__ import annotations

import numpy as np

from ..conditions.loads import Follower
from .balance import Balance
from .state import ShellState, ShellStep
from .supported_shell import SupportedShell


def static_equilibrium(
    structure: SupportedShell,
    coefficients: np.ndarray,
    volume: float | None,
    pressure: float,
    load: np.ndarray | Follower | None,
) -> ShellStep:
    """Equilibrium near a configuration; parameters and errors as in `ShellStructure.static`."""
    structure.refuse_contact("static equilibria")
    structure.mechanism.refuse(dead=not callable(load))
    linear = np.zeros(structure.E.shape[1])
    follower = None
    if isinstance(load, np.ndarray):
        linear -= structure.E.T @ load.ravel()
        if load.any() and not linear.any():
            raise ValueError("the load acts on supported coefficients only: it moves nothing")
    else:
        follower = load
    balance = Balance(structure, coefficients, volume, linear, follower=follower)
    result = balance.solve(np.zeros_like(linear), pressure)
    still = np.zeros_like(coefficients)
    solved = ShellStep.of(
        ShellState(0.0, coefficients + structure.expand(result.x), still, -result.multiplier),
        result,
    )
    if solved.ok:
        return solved
    return ShellStep.of(ShellState(0.0, coefficients + still, still, pressure), result)
