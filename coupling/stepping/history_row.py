"""Columns of the history: energies and their balance, the fluid's health, the work of a step.

``energy_defect`` is what is left of ``E - E_0 + dissipation - work``; ``flux_ratio`` the volume
prescribed over the volume that the membrane velocity carries (1 up to the first order in dt). Of
contact that carries load: its energy, the sum of its forces on the structure (0 to rounding where
it touches only itself), its smallest distance (infinite out of reach) and the samples in reach.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..contact.carried import CarriedContact
from ..exchange import State
from ..protocols import Structure
from ..schemes.scheme import StepResult

SUMS = ("pressure_work", "fluid_work", "dissipation")


@dataclass
class Counts:
    """Totals of work, of a run or of one step with its rejected attempts."""

    accepted: int = 0
    rejected: int = 0
    assemblies: int = 0
    newton: int = 0
    krylov: int = 0
    frozen_solves: int = 0
    reused: int = 0  # assemblies saved by an OperatorReuse

    def add(self, result: StepResult) -> None:
        """Add the work of an attempt."""
        self.assemblies += result.assemblies
        self.newton += result.newton_iterations
        self.krylov += result.krylov_iterations
        self.frozen_solves += result.frozen_solves


def history_row(
    structure: Structure,
    state: State,
    sums: Mapping[str, float],
    *,
    step: int,
    dt: float,
    volume: float,
    growth: float,
    result: StepResult | None,
    extra: Mapping[str, float],
    contact: CarriedContact | None,
    work: Counts,
    wall_time: float,
) -> dict[str, float]:
    """Row of an accepted step; the last column is the only one that differs between equal runs.

    Parameters
    ----------
    sums : mapping
        `SUMS` and ``energy_start``.
    volume, growth : float
        Prescribed volume and its increase over the step.
    result : StepResult or None
        None of the initial state.
    extra : mapping
        Further columns.
    work : Counts
        Of this step, rejected attempts included.
    """
    energies = structure.energies(state)
    stored = sum(energies.values()) - sums["energy_start"]
    done = sums["pressure_work"] + sums["fluid_work"]
    traction = result.traction if result else None
    return {
        "step": step,
        "t": state.t,
        "dt": dt,
        "volume": structure.volume(state.coefficients),
        "volume_prescribed": volume,
        "area": structure.area(state.coefficients),
        "pressure": state.pressure,
        **{f"{name}_energy": value for name, value in energies.items()},
        **{name: sums[name] for name in SUMS},
        "energy_defect": stored + sums["dissipation"] - done,
        "zeta": traction.zeta if traction else 0.0,
        "flux_ratio": growth / (dt * traction.flux) if traction and traction.flux else 1.0,
        "velocity_max": traction.velocity_max if traction else _largest(state.velocity),
        **_touch(contact, state),
        **extra,
        "subiterations": result.iterations if result else 0,
        "assemblies": work.assemblies,
        "newton_iterations": work.newton,
        "krylov_iterations": work.krylov,
        "wall_time": wall_time,
    }


def _touch(contact: CarriedContact | None, state: State) -> dict[str, float]:
    if contact is None:
        return {}
    now, c = contact.at(state.t), state.coefficients
    return {
        "contact_force": float(np.linalg.norm(now.force(c))),
        "contact_distance": now.distance(c),
        "contacts": now.within_reach(c),
    }


def _largest(velocity: np.ndarray) -> float:
    return float(np.linalg.norm(velocity, axis=-1).max())
