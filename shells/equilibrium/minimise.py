"""Equilibria as minima of ``Pi = W - p Q - F.theta``: a Newton method that only descends.

Levenberg-Marquardt: ``(W'' - p Q'' + s M) d = -Pi'``; a step is taken if Pi falls and no
coefficient moves by more than a tenth of the structure, and s then shrinks; else s grows. The
shift also carries rigid motions, so that a free bag needs no pins, and an unstressed flat bag
inflates from zero volume.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .newton import NewtonOutcome, factorize
from .state import ShellState
from .supported_shell import SupportedShell

SHRINK, GROW = 0.25, 4.0
REACH = 0.1  # largest move of one step over the structure's length


@dataclass(frozen=True)
class Minimum:
    """Where the descent ended.

    Parameters
    ----------
    state : ShellState
        On failure, the lowest state found.
    outcome : NewtonOutcome
    iterations : int
    residual : float
        Norm of the last residual over that of the loads.
    shift : float
        Last multiple of the mass matrix.
    """

    state: ShellState
    outcome: NewtonOutcome
    iterations: int
    residual: float
    shift: float

    @property
    def ok(self) -> bool:
        """Whether the residual reached its tolerance."""
        return self.outcome is NewtonOutcome.CONVERGED


def minimise(
    structure: SupportedShell,
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
        Start, possibly unstressed.
    pressure : float
    load : (n_full, 3) array, optional
        Dead load F.
    tolerance : float
        On the residual over the norm of the forces of pressure and load.
    max_iterations : int
    shift : float
        First multiple of the mass matrix.

    Returns
    -------
    Minimum
        On failure, the lowest state found.

    Raises
    ------
    ValueError
        A pressure on a structure that encloses no volume.
    """
    E, E_shell, n = structure.E, structure.E_shell, structure.n
    dead = np.zeros(n) if load is None else structure.own(load)
    inflated = pressure != 0.0

    def potential(c: np.ndarray) -> float:
        work = pressure * structure.volume(c) if inflated else 0.0
        return sum(structure.shell.energy(c[:n])) - work - float(dead @ c[:n])

    def ended(outcome: NewtonOutcome) -> Minimum:
        configuration = c.reshape(-1, structure.dimension)
        state = ShellState(0.0, configuration, np.zeros_like(configuration), pressure)
        return Minimum(state, outcome, iteration, residual, shift)

    c = coefficients.ravel().copy()
    value, residual, iteration = potential(c), np.inf, 0
    while iteration < max_iterations:
        iteration += 1
        gradient, tangent = structure.shell.gradient_and_tangent(c[:n])
        force = dead
        if inflated:
            _, dQ, ddQ = structure.enclosure.derivatives(c[:n])
            force, tangent = force + pressure * dQ, tangent - pressure * ddQ
        force = E_shell.T @ force
        r = E_shell.T @ gradient - force
        residual = float(np.linalg.norm(r) / max(float(np.linalg.norm(force)), 1e-300))
        if residual <= tolerance:
            return ended(NewtonOutcome.CONVERGED)
        K = E_shell.T @ tangent @ E_shell
        while True:
            d = factorize(K + shift * structure.M_free)(-r)
            trial = c + E @ d
            # rounding decides about the last digits of Pi: accept ties
            lower = potential(trial) <= value + 1e-13 * abs(value)
            if lower and np.abs(d).max() < REACH * structure.length and r @ d < 0.0:
                break
            shift *= GROW
            if shift > 1e12:
                return ended(NewtonOutcome.DIVERGED)
        c, value, shift = trial, potential(trial), SHRINK * shift
    return ended(NewtonOutcome.LIMIT)
