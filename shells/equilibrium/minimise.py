"""Equilibria as minima of ``Pi = W - p Q - F.theta``: a Newton method that only descends.

Levenberg-Marquardt: ``(W'' - p Q'' + s M) d = -Pi'``; a step is taken if Pi falls and no
coefficient moves by more than a tenth of the structure, and s then shrinks; else s grows. The
shift also carries rigid motions, so that a free bag needs no pins, and an unstressed flat bag
inflates from zero volume.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .newton import Outcome, factorize
from .structure import ShellState, ShellStructure

SHRINK, GROW = 0.25, 4.0
REACH = 0.1  # largest move of one step over the structure's length


@dataclass(frozen=True)
class Minimum:
    """Where the descent ended: state, outcome, iterations, last relative residual and shift."""

    state: ShellState
    outcome: Outcome
    iterations: int
    residual: float
    shift: float

    @property
    def ok(self) -> bool:
        return self.outcome is Outcome.CONVERGED


def minimise(
    structure: ShellStructure,
    coefficients: np.ndarray,
    pressure: float = 0.0,
    *,
    load: np.ndarray | None = None,
    tolerance: float = 1e-8,
    max_iterations: int = 300,
    shift: float = 1.0,
) -> Minimum:
    """Equilibrium under an excess pressure and a dead load, without pins or small steps.

    Parameters
    ----------
    structure : ShellStructure
        With an enclosed volume, unless the pressure is zero.
    coefficients : (n_full, 3) array
    pressure : float
    load : (n_full, 3) array, optional
        Dead load F.
    tolerance : float
        On the residual over the norm of the forces of pressure and load.
    shift : float
        First multiple of the mass matrix.

    Returns
    -------
    Minimum
        On failure, the lowest state found.
    """
    shell, E, M = structure.shell, structure.E, structure.M
    n = shell.basis.N
    Er = E[:n]
    Mr = (Er.T @ M @ Er).tocsr()
    length = float(np.ptp(shell.basis.reference.value.reshape(-1, 3), axis=0).max())

    dead = np.zeros(n) if load is None else load.ravel()[:n]
    inflated = pressure != 0.0

    def potential(c: np.ndarray) -> float:
        work = pressure * structure.volume(c) if inflated else 0.0
        return sum(shell.energy(c[:n])) - work - float(dead @ c[:n])

    c = coefficients.ravel().copy()
    value, residual, outcome = potential(c), np.inf, Outcome.LIMIT
    for iteration in range(1, max_iterations + 1):
        gradient, tangent = shell.gradient_and_tangent(c[:n])
        force = dead
        if inflated:
            _, dQ, ddQ = structure.enclosed.derivatives(c[:n])
            force, tangent = force + pressure * dQ, tangent - pressure * ddQ
        force = Er.T @ force
        r = Er.T @ gradient - force
        residual = float(np.linalg.norm(r) / max(np.linalg.norm(force), 1e-300))
        if residual <= tolerance:
            outcome = Outcome.CONVERGED
            break
        K = Er.T @ tangent @ Er
        while True:
            d = factorize(K + shift * Mr)(-r)
            trial = c + E @ d
            # rounding decides about the last digits of Pi: accept ties
            lower = potential(trial) <= value + 1e-13 * abs(value)
            if lower and np.abs(d).max() < REACH * length and r @ d < 0.0:
                break
            shift *= GROW
            if shift > 1e12:
                return Minimum(_state(c, pressure), Outcome.DIVERGED, iteration, residual, shift)
        c, value, shift = trial, potential(trial), SHRINK * shift
    return Minimum(_state(c, pressure), outcome, iteration, residual, shift)


def _state(c: np.ndarray, pressure: float) -> ShellState:
    configuration = c.reshape(-1, 3)
    return ShellState(0.0, configuration, np.zeros_like(configuration), pressure)
