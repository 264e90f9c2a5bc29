"""The adaptive loop with a Stokes part that has no mesh.

Fields in the Stokes part come from the representation formula at the nodes of a background grid,
on which no system is solved. The adjoint is mixed (boundary elements too: no mesh at all),
enriched (finite elements on some layers more) or, for comparison, full (a mesh everywhere).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from ..model_adaptivity.adaptive_loop import Strategy
from ..model_adaptivity.error_estimate import add_layers, dual
from ..model_adaptivity.goals import Goal
from ..model_adaptivity.marking import mark
from ..navier_stokes.flow import MixedFlow
from ..navier_stokes.spaces import FlowSpace
from .boundary_stokes import BoundaryFlow
from .substructure import connect_to_outlet

MakeGoal = Callable[[FlowSpace], Goal]
MakeFlow = Callable[[np.ndarray], BoundaryFlow]


@dataclass(frozen=True)
class BoundaryStep:
    """One step; figures relative to ``J(u0)``.

    Parameters
    ----------
    flagged : (n_elements,) bool array
        Navier-Stokes elements.
    goal, estimate, bound, error : float
        ``error`` is ``(J(u1) - J(u0)) / J(u0)`` with the full finite-element model on the same
        mesh: it contains the difference of both discretisations.
    element_fraction : float
    field, adjoint : (n,) arrays
        Velocities at all nodes.
    """

    flagged: np.ndarray
    goal: float
    estimate: float
    bound: float
    error: float
    element_fraction: float
    field: np.ndarray
    adjoint: np.ndarray


def adapt_boundary(
    whole: MixedFlow,
    make_flow: MakeFlow,
    make_goal: MakeGoal,
    seed: np.ndarray,
    strategy: Strategy,
    *,
    outlet: str,
    reference: float,
) -> Iterator[BoundaryStep]:
    """Run the adaptive loop with boundary elements in the Stokes part.

    Parameters
    ----------
    whole : MixedFlow
        The problem on the background grid (full stress): used for element integrals, and solved
        only for a full adjoint.
    make_flow : callable
        Flags to a coupled problem.
    make_goal : callable
        Flow space of the Navier-Stokes part to the goal, which must lie in it.
    seed : (n_elements,) bool array
        Initial Navier-Stokes part; joined to the outflow.
    strategy : Strategy
        The indicator is the element integral whatever it says.
    outlet : str
        Boundary without traction.
    reference : float
        ``J(u1)``.

    Yields
    ------
    BoundaryStep
    """
    mesh = whole.space.mesh
    flagged = connect_to_outlet(mesh, seed, outlet)
    for _ in range(strategy.max_steps + 1):
        if flagged.all():
            return
        flow = make_flow(flagged)
        x, levels = flow.solve()
        u = flow.field(x, levels)
        goal = make_goal(flow.inner.space)
        value = goal.value(x)
        z = _adjoint(whole, flow, make_flow, make_goal, u, x, flagged, strategy, outlet)
        eta = -whole.convection.elements(u, z, ~flagged)
        step = BoundaryStep(
            flagged=flagged,
            goal=value,
            estimate=float(eta.sum()) / value,
            bound=float(np.abs(eta).sum()) / abs(value),
            error=(reference - value) / value,
            element_fraction=float(flagged.mean()),
            field=u,
            adjoint=z,
        )
        yield step
        if step.bound <= strategy.tolerance:
            return
        new = mark(eta, flagged, strategy.marking, strategy.parameter)
        flagged = connect_to_outlet(mesh, flagged | new, outlet)


def _adjoint(
    whole: MixedFlow,
    flow: BoundaryFlow,
    make_flow: MakeFlow,
    make_goal: MakeGoal,
    u: np.ndarray,
    x: np.ndarray,
    flagged: np.ndarray,
    strategy: Strategy,
    outlet: str,
) -> np.ndarray:
    """Adjoint velocities at all nodes."""
    if strategy.adjoint == "full":
        return dual(whole, make_goal(whole.space), u, whole.everywhere)
    if strategy.adjoint == "enriched":
        larger = connect_to_outlet(
            whole.space.mesh, add_layers(whole.space, flagged, strategy.layers), outlet
        )
        if larger.all():
            return dual(whole, make_goal(whole.space), u, whole.everywhere)
        flow = make_flow(larger)
        x = flow.embed.T @ u  # velocities suffice: the pressure enters linearly
    return flow.field(*flow.adjoint(make_goal(flow.inner.space), x), prescribed=False)
