"""Backward-Euler steps [T 6.11] of a shell with an enclosed volume, and their inverse tangent.

``M ((theta - theta_n)/dt^2 - v_n/dt) + W'(theta) - p Q'(theta) + C v = load, Q(theta) = V`` with
``v = (theta - theta_n)/dt``, solved by a `Descent` on free coordinates ``theta = theta_n + E q``.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from scipy.sparse.linalg import LinearOperator

from . import newton
from .balance import Balance
from .damped_tangent import FrozenDamping
from .descent import Descent
from .state import MotionState, ShellState, ShellStep
from .supported_shell import SupportedShell

Damping: TypeAlias = np.ndarray | LinearOperator


def step(
    structure: SupportedShell,
    state: MotionState,
    load: np.ndarray | None,
    dt: float,
    volume: float | None,
    damping: Damping | None = None,
    guess: np.ndarray | None = None,
) -> ShellStep:
    """One step; the parameters are those of `ShellStructure.step`."""
    s = structure
    linear = -(s.M_free @ s.reduce(state.velocity)) / dt
    if load is not None:
        linear -= s.E.T @ load.ravel()
    operator = s.M_free / dt**2
    frozen: FrozenDamping | None = FrozenDamping()
    if isinstance(damping, LinearOperator) and not hasattr(damping, "dense"):

        def action(q: np.ndarray) -> np.ndarray:
            return s.E.T @ (damping @ (s.E @ q)) / dt

        frozen = FrozenDamping(action)
    elif damping is not None:
        C = damping.dense() if hasattr(damping, "dense") else damping
        operator, frozen = operator.toarray() + (s.E.T @ (s.E.T @ C.T).T) / dt, None
    contact = None if s.contact is None else s.contact.at(state.t + dt)
    balance = Balance(
        s, state.coefficients, volume, linear, operator, damping=frozen, contact=contact
    )
    still = np.zeros_like(linear)
    start = s.reduce(dt * state.velocity if guess is None else guess - state.coefficients)
    crosses = guess is None and balance.free_step(still, start) < 1.0
    if crosses or not np.isfinite(balance.potential(start)[0]):
        start = still
    result = Descent(balance).solve(start, state.pressure)
    increment = s.expand(result.x)
    new = ShellState(
        state.t + dt, state.coefficients + increment, increment / dt, -result.multiplier
    )
    return ShellStep.of(new, result)


def inverse_tangent(structure: SupportedShell, state: MotionState, dt: float) -> LinearOperator:
    """Inverse of ``M/dt^2 + W'' - p Q''`` under ``Q'(x) = 0``, ``3 n_full`` square."""
    s, c = structure, structure.own(state.coefficients)
    _, tangent = s.shell.gradient_and_tangent(c)
    row = None
    if s.enclosed is not None:
        _, gradient, hessian = s.enclosed.derivatives(c)
        tangent, row = tangent - state.pressure * hessian, s.E_shell.T @ gradient
    free = s.M_free / dt**2 + s.E_shell.T @ tangent @ s.E_shell
    if s.contact is not None:
        _, stiffness = s.contact.at(state.t + dt).derivatives(state.coefficients)
        free = free + s.E.T @ stiffness @ s.E
    solve = newton.factorize(free)
    along = None if row is None else solve(row)

    def apply(b: np.ndarray) -> np.ndarray:
        x = solve(s.E.T @ b.ravel())
        if row is not None:
            x = x - along * (row @ x) / (row @ along)
        return s.E @ x

    n = s.E.shape[0]
    return LinearOperator((n, n), matvec=apply, dtype=float)
