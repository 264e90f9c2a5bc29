"""Modelling error in a goal: ``J1 - J0 ~ R1(u0; z) = -c_S(u0, u0, z)`` [T 7.25] and where it is.

The adjoint z belongs to the full model [T 7.23], to the mixed one (cheap, unreliable) or to one
whose Navier-Stokes part is some layers larger. Indicators: element integrals of
``-(u . grad u) . z`` over the Stokes part, or nodal residuals spread over elements [T 7.28].
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..navier_stokes.checked_factor import Factor
from ..navier_stokes.flow import MixedFlow
from ..navier_stokes.spaces import FlowSpace
from .goals import Goal

Indicator = Literal["integral", "counting", "volume", "exact"]
Adjoint = Literal["full", "mixed", "enriched"]


@dataclass(frozen=True)
class Estimate:
    """Error estimate of one mixed-model solution, absolute values.

    Parameters
    ----------
    goal : float
        ``J(u0)``.
    error : float
        ``R1(u0; z)``, the estimate of ``J(u1) - J(u0)``.
    bound : float
        Sum of the indicators' magnitudes: bounds the estimate, not the error.
    algebraic : float
        ``R0(u0; z)``: what the unconverged part of Newton's method does to the goal.
    indicators : (n_elements,) array
    adjoint : (n,) array
    """

    goal: float
    error: float
    bound: float
    algebraic: float
    indicators: np.ndarray
    adjoint: np.ndarray


def estimate(
    flow: MixedFlow,
    goal: Goal,
    x: np.ndarray,
    flagged: np.ndarray,
    *,
    indicator: Indicator = "integral",
    adjoint: Adjoint = "full",
    layers: int = 1,
) -> Estimate:
    """Estimate the modelling error of a solution in a goal [T 7.25].

    Parameters
    ----------
    flow : MixedFlow
    goal : Goal
    x : (n,) array
        Solution of the mixed model.
    flagged : (n_elements,) bool array
        Its Navier-Stokes elements.
    indicator : {"integral", "counting", "volume", "exact"}
        Element integrals of the estimate, or nodal residuals shared among elements by their
        number, their areas or the means of the shape functions [T 7.28].
    adjoint : {"full", "mixed", "enriched"}
        Model of the adjoint: Navier-Stokes everywhere, the mixed one of ``x``, or a mixed one
        whose Navier-Stokes part is larger.
    layers : int
        Of elements by which an enriched adjoint's Navier-Stokes part is larger.

    Returns
    -------
    Estimate

    Raises
    ------
    ValueError
        ``exact`` where a shape function has no mean (vertices of P2 triangles).
    LinearSolveError
        The adjoint could not be solved.
    """
    z = dual(flow, goal, x, _fine(flow, flagged, adjoint, layers))
    r1 = flow.residual(x, flow.everywhere)
    eta = indicators(flow, x, z, flagged, indicator, r1)
    return Estimate(
        goal=goal.value(x),
        error=float(r1 @ z),
        bound=float(np.abs(eta).sum()),
        algebraic=float(flow.residual(x, flagged) @ z),
        indicators=eta,
        adjoint=z,
    )


def dual(
    flow: MixedFlow,
    goal: Goal,
    x: np.ndarray,
    fine: np.ndarray,
    factor: Factor | None = None,
) -> np.ndarray:
    """Adjoint solution z, 0 where velocities are prescribed: ``N'(u0)^T z = J'(u0)`` [T 7.23]."""
    factor = factor or flow.tangent(x, fine)
    right = goal.derivative(x)[flow.pattern.order]
    return flow.extend(factor.solve(right, transposed=True))


def _fine(flow: MixedFlow, flagged: np.ndarray, adjoint: Adjoint, layers: int) -> np.ndarray:
    if adjoint == "full":
        return flow.everywhere
    return add_layers(flow.space, flagged, layers if adjoint == "enriched" else 0)


def add_layers(space: FlowSpace, flagged: np.ndarray, layers: int = 1) -> np.ndarray:
    """Add layers of elements that share a vertex with flagged ones."""
    corners = space.mesh.t
    for _ in range(layers):
        touched = np.zeros(space.mesh.p.shape[1], dtype=bool)
        touched[corners[:, flagged]] = True
        flagged = flagged | touched[corners].any(axis=0)
    return flagged


def indicators(
    flow: MixedFlow,
    x: np.ndarray,
    z: np.ndarray,
    flagged: np.ndarray,
    kind: Indicator = "integral",
    r1: np.ndarray | None = None,
) -> np.ndarray:
    """Element contributions whose sum is the estimate, ``(n_elements,)``.

    Raises
    ------
    ValueError
        ``exact`` where a shape function has no mean (vertices of P2 triangles).
    """
    if kind == "integral":
        # exact for Galerkin solutions, and zero in the Navier-Stokes part without leakage
        return -flow.convection.elements(x, z, ~flagged)
    r1 = flow.residual(x, flow.everywhere) if r1 is None else r1
    space = flow.space
    weight, dofs = _weights(space, kind), space.element_dofs
    total = np.bincount(dofs.ravel(), weight.ravel(), minlength=space.n)
    return (weight / total[dofs] * (r1 * z)[dofs]).sum(axis=0)


def _weights(space: FlowSpace, kind: Indicator) -> np.ndarray:
    """Shares of elements in their unknowns before normalisation, ``(k, n_elements)``."""
    if kind == "counting":
        return np.ones(space.element_dofs.shape)
    if kind == "volume":
        return np.broadcast_to(space.volumes, space.element_dofs.shape)
    means = []
    for basis in (space.velocity, space.pressure):
        phi = np.array([basis.elem.lbasis(basis.X, i)[0] for i in range(basis.Nbfun)])
        means.append(phi @ basis.dx.T)
    if min(np.abs(m / space.volumes).min() for m in means) < 1e-12:
        raise ValueError(
            "exact shares need shape functions with a mean, those of P2 vertices have none: "
            "use 'volume' or 'counting' on triangles"
        )
    return np.concatenate([means[0], means[0], means[1]])
