"""Boundary velocities of the trials, and what they have in common."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from hbem.flows.mesh_share import RESOLVING, film_ratio
from hbem.flows.stokes_flow import StokesFlow
from hbem.traction_error import TractionError, Verdict

Trial = dict[str, Any]
Field = Callable[[np.ndarray], np.ndarray]
SPOT, WIDTH = np.array([0.2, 0.1, 0.0]), 0.3  # of the jet


def _linear(matrix: list[list[float]]) -> Field:
    transposed = np.array(matrix).T
    return lambda x: x @ transposed


def _constant(value: list[float]) -> Field:
    return lambda x: np.tile(value, (len(x), 1))


def _quadratic(x: np.ndarray) -> np.ndarray:
    return np.stack([x[:, 1] ** 2 + x[:, 2], x[:, 2] ** 2, x[:, 0] * x[:, 1]], axis=1)


def _jet(x: np.ndarray) -> np.ndarray:
    """A vortex ring cut through its middle, flux 0: rises at one side of a spot only."""
    y = (x - SPOT) / WIDTH
    bump = np.exp(-np.sum(y * y, axis=1))
    return np.stack([y[:, 2] * bump, 0.0 * bump, -y[:, 0] * bump], axis=1)


# all without net flux through a closed surface
FIELDS: dict[str, Field] = {
    "squeeze": _linear([[1, 0, 0], [0, 1, 0], [0, 0, -2]]),
    "slide": _constant([1.0, 0.0, 0.0]),
    "fall": _constant([0.0, 0.0, 1.0]),
    "spin": _linear([[0, -1, 0], [1, 0, 0], [0, 0, 0]]),
    "tumble": _linear([[0, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "shear": _linear([[0, 0, 1], [0, 0, 0], [0, 0, 0]]),
    "quadratic": _quadratic,
    "jet": _jet,
}


def away(flow: StokesFlow, found: np.ndarray, exact: np.ndarray) -> float:
    """Relative L2 distance of densities ``(3 n_dofs,)`` on the surface of a flow."""
    size = flow.solver.size
    return size(found - exact) / size(exact)


def announced(error: TractionError, quadrature: float | None = None) -> bool:
    """Whether a verdict is not "met" even without the mesh's share, and with that quadrature."""
    share = error.quadrature if quadrature is None else quadrature
    alone = replace(error, mesh=0.0, quadrature=share, resolved=True)
    return alone.verdict is not Verdict.MET


def resolves(flow: StokesFlow, error: TractionError) -> bool:
    """Whether a mesh is fine enough for its film, and by its own share for the tolerance."""
    return film_ratio(flow.facing) < RESOLVING and not error.mesh > error.tolerance
