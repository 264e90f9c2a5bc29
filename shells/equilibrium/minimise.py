"""Equilibria as minima of ``Pi = W - p Q - F.theta``: a Newton method that only descends.

Levenberg-Marquardt: ``(W'' - p Q'' + s M) d = -Pi'``; a step is taken if Pi falls and no
coefficient moves by more than a tenth of the structure, and s then shrinks; else s grows. The
shift also carries rigid motions, so that a free bag needs no pins, and an unstressed flat bag
inflates from zero volume. Where the loads exceed a limit point Pi has no minimum: the shell then
stretches without end along directions of negative curvature; the descent stops, and finds the
largest share of the loads that is in equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .newton import NewtonOutcome, factorize
from .state import ShellState
from .supported_shell import SupportedShell

SHRINK, GROW = 0.25, 4.0
REACH = 0.1  # largest move of one step over the structure's length
RUNAWAY = 2.0  # mean stretch from which a step along negative curvature is one without end
HALVINGS = 7  # of the interval that holds the limit point


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
    factor : float
        Share of the loads that ``state`` carries: 1, unless they exceed a limit point.
    """

    state: ShellState
    outcome: NewtonOutcome
    iterations: int
    residual: float
    shift: float
    factor: float = 1.0

    @property
    def ok(self) -> bool:
        """Whether the residual reached its tolerance."""
        return self.outcome is NewtonOutcome.CONVERGED

    @property
    def failure(self) -> str:
        """Empty, or why there is no equilibrium."""
        if self.outcome is not NewtonOutcome.NO_EQUILIBRIUM:
            return "" if self.ok else self.outcome.value
        inflated = self.state.pressure != 0.0
        other = "prescribe the volume instead of the pressure (shells.static_path)"
        return (
            f"no equilibrium beyond {self.factor:.4g} of the loads: {self.outcome.value}; "
            f"{other if inflated else 'lower the load'}"
        )


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
        On failure, the lowest state found; beyond a limit point, that of the largest share of the
        loads that was found in equilibrium.

    Raises
    ------
    ValueError
        A pressure on a structure that encloses no volume; a load with a resultant along a
        translation that no support holds; a structure with contact.
    """
    structure.refuse_contact("minima of the potential")
    if load is not None:
        structure.mechanism.refuse_resultant(load)

    def descend(factor: float, start: np.ndarray) -> Minimum:
        dead = None if load is None else factor * load
        end = _descend(structure, start, factor * pressure, dead, tolerance, max_iterations, shift)
        return replace(end, factor=factor)

    end = descend(1.0, coefficients)
    if end.outcome is not NewtonOutcome.NO_EQUILIBRIUM:
        return end
    still = replace(end.state, coefficients=coefficients, pressure=0.0)
    best, above, spent = replace(end, state=still, factor=0.0), 1.0, end.iterations
    for _ in range(HALVINGS):
        trial = descend(0.5 * (best.factor + above), best.state.coefficients)
        spent += trial.iterations
        if trial.ok:
            best = trial
        else:
            above = trial.factor
    if above == 1.0:  # the loads may be in equilibrium where the first descent jumped past it
        trial = descend(1.0, best.state.coefficients)
        spent += trial.iterations
        best = trial if trial.ok else best
    outcome = best.outcome if best.factor == 1.0 else NewtonOutcome.NO_EQUILIBRIUM
    return replace(best, outcome=outcome, iterations=spent)


def _descend(
    structure: SupportedShell,
    coefficients: np.ndarray,
    pressure: float,
    load: np.ndarray | None,
    tolerance: float,
    max_iterations: int,
    shift: float,
) -> Minimum:
    """One descent; the parameters are those of `minimise`."""
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

    limit = RUNAWAY ** (structure.dimension - 1) * float(structure.shell.basis.dx.sum())
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
        if d @ (K @ d) <= 0.0 and structure.area(c) > limit:
            return ended(NewtonOutcome.NO_EQUILIBRIUM)
    return ended(NewtonOutcome.LIMIT)
