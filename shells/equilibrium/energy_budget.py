"""Where the energy of a structure is, and where it goes in a step.

Backward Euler burns ``1/2 |v_1 - v_0|_M^2`` and, of the stored energy,
``int_0^1 (W'(theta_1) - W'(theta_0 + s d)).d ds`` (five Gauss points): with it the sum of work,
dissipation and the energies' change measures Newton's residual and nothing else. Of contact it
burns ``B'(theta_1).d - (B(theta_1) - B(theta_0))`` with obstacles where they are at the end: on
the straight way sheets may pass through each other, and B' has kinks, so that no points are taken.
Obstacles that move do the work ``B(theta_0)`` at the end less that at the start, which the load's
work counts with its own.
"""

from __future__ import annotations

import numpy as np

from ..conditions.contact import Contact
from .state import MotionState
from .supported_shell import SupportedShell


def energies(structure: SupportedShell, state: MotionState) -> dict[str, float]:
    """Kinetic, membrane and bending energy of a state."""
    membrane, bending = structure.shell.energy(structure.own(state.coefficients))
    v = structure.own(state.velocity)
    kinetic = 0.5 * float(v @ (structure.M @ v))
    found = {"kinetic": kinetic, "membrane": membrane, "bending": bending}
    if structure.contact is not None:
        found["contact"] = structure.contact.at(state.t).energy(state.coefficients)
    return found


def budget(
    structure: SupportedShell,
    start: MotionState,
    end: MotionState,
    load: np.ndarray | None,
    acceleration: np.ndarray | None = None,
) -> dict[str, float]:
    """Work and dissipation of a step; the parameters are those of `ShellStructure.budget`."""
    own, M = structure.own, structure.M
    c0, c1 = own(start.coefficients), own(end.coefficients)
    d, dv = c1 - c0, own(end.velocity - start.velocity)
    work = 0.0 if load is None else float(own(load) @ d)
    pressure = 0.0
    if structure.enclosed is not None:
        pressure = end.pressure * float(structure.enclosed.gradient(c1) @ d)
    kinetic = 0.5 * float(dv @ (M @ dv))
    if acceleration is not None:
        mean = 0.5 * own(end.velocity + start.velocity)
        kinetic = float((M @ own(acceleration)) @ d) - float(mean @ (M @ dv))
    dissipation = kinetic + _stored_dissipation(structure, c0, c1)
    if structure.contact is not None:
        pushed, burnt = _contact(structure.contact, start, end)
        work, dissipation = work + pushed, dissipation + burnt
    return {"pressure_work": pressure, "load_work": work, "dissipation": dissipation}


def _contact(contact: Contact, start: MotionState, end: MotionState) -> tuple[float, float]:
    """Work of obstacles that move, and what the step burns of the contact's energy."""
    c0, c1 = start.coefficients, end.coefficients
    then = contact.at(end.t)
    before, between, after = contact.at(start.t).energy(c0), then.energy(c0), then.energy(c1)
    force, _ = then.derivatives(c1)
    return between - before, float(force @ (c1 - c0).ravel()) - (after - between)


def _stored_dissipation(structure: SupportedShell, c0: np.ndarray, c1: np.ndarray) -> float:
    shell, d = structure.shell, c1 - c0
    s, w = np.polynomial.legendre.leggauss(5)
    path = sum(
        0.5 * wi * (shell.gradient(c0 + 0.5 * (si + 1.0) * d) @ d)
        for si, wi in zip(s, w, strict=True)
    )
    return float(shell.gradient(c1) @ d - path)
