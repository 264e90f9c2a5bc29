"""Meshes adapted to a goal of the full model, so that discretisation stays below modelling error.

Dual-weighted residuals on triangles: the adjoint is enriched (degree 3 over degree 2), its weight
``w = z - I z``; an element's share is its weak residual plus the mean flux over its edges,
``int_K [-(u.grad u).w - grad u : grad w / Re + p div w + div u y] + int_dK {dn u / Re - p n} . w``,
which by parts is the strong residual and half the jumps. The shares add up to ``R(u; w)``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from skfem import FacetBasis, Functional, InteriorFacetBasis, MeshTri
from skfem.assembly.basis import AbstractBasis
from skfem.element import DiscreteField

from ..navier_stokes.flow import MixedFlow
from ..navier_stokes.newton import solve_robustly
from ..navier_stokes.spaces import FlowSpace
from .error_estimate import dual
from .goals import Goal

Problem = Callable[[MeshTri, int], tuple[MixedFlow, Goal]]


@dataclass(frozen=True)
class MeshLevel:
    """A mesh of the sequence and its discretisation error in the goal.

    Parameters
    ----------
    flow : MixedFlow
        The problem on it.
    goal : Goal
    x : (n,) array
        Solution of the full model.
    value : float
        Goal of the solution.
    error : float
        Dual-weighted residual: the estimate of exact minus discrete goal.
    bound : float
        Sum of the indicators' magnitudes.
    indicators : (n_elements,) array
    """

    flow: MixedFlow
    goal: Goal
    x: np.ndarray
    value: float
    error: float
    bound: float
    indicators: np.ndarray


def refinements(
    problem: Problem, mesh: MeshTri, levels: int, fraction: float = 0.15
) -> Iterator[MeshLevel]:
    """Refine meshes where the discretisation error of the goal comes from.

    Parameters
    ----------
    problem : callable
        ``(mesh, degree) -> (flow, goal)`` for the velocity's degree 2 and 3.
    mesh : skfem.MeshTri
    levels : int
        Refinements.
    fraction : float
        Of the elements to be refined each time, those with the largest indicators.

    Yields
    ------
    MeshLevel

    Raises
    ------
    ArithmeticError
        The full model could not be solved.
    """
    start = None
    for level in range(levels + 1):
        flow, goal = problem(mesh, 2)
        if start is None:
            found = solve_robustly(flow, flow.everywhere)
        else:
            found = solve_robustly(flow, flow.everywhere, flow.space.transfer(*start))
        if not found.ok:
            raise ArithmeticError(f"mesh level {level}: {found.outcome.value}")
        start = (flow.space, found.x)
        eta = indicators(flow, found.x, *problem(mesh, 3))
        yield MeshLevel(
            flow,
            goal,
            found.x,
            goal.value(found.x),
            float(eta.sum()),
            float(np.abs(eta).sum()),
            eta,
        )
        if level < levels:
            count = int(np.ceil(fraction * eta.size))
            mesh = MeshTri(mesh.p, mesh.t).refined(np.argsort(-np.abs(eta), kind="stable")[:count])


def indicators(flow: MixedFlow, x: np.ndarray, richer: MixedFlow, goal: Goal) -> np.ndarray:
    """Shares of elements in the discretisation error of the goal.

    Parameters
    ----------
    flow : MixedFlow
    x : (n,) array
        Its solution of the full model.
    richer : MixedFlow
        The problem of degree 3 on the same mesh.
    goal : Goal
        Of the richer problem.

    Returns
    -------
    (n_elements,) array
    """
    space = richer.space
    u = space.nodal(flow.space, x)
    z = dual(richer, goal, u, richer.everywhere)
    weight = z - space.nodal(flow.space, flow.space.nodal(space, z))
    weight[richer.fixed] = 0.0
    shares = _inside(richer, u, weight)
    return shares + _mean_flux(richer, u, weight)


def _inside(flow: MixedFlow, x: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Weak residual of each element against w."""
    space, nu = flow.space, 1.0 / flow.reynolds
    u, v = _fields(space, space.velocity, x), _fields(space, space.velocity, w)
    p, q = (space.pressure.interpolate(space.split(a)[2]) for a in (x, w))

    @Functional
    def linear(c):
        viscous = sum(c[f"u{i}"].grad[j] * c[f"v{i}"].grad[j] for i in (0, 1) for j in (0, 1))
        div_u, div_v = (c[f"{n}0"].grad[0] + c[f"{n}1"].grad[1] for n in "uv")
        return -nu * viscous + c["p"] * div_v + c["q"] * div_u

    part = linear.elemental(space.velocity, **u, **_renamed(v), p=p, q=q)
    return part - flow.convection.elements(x, w, flow.everywhere)


def _renamed(v: dict[str, DiscreteField]) -> dict[str, DiscreteField]:
    return {key.replace("u", "v"): value for key, value in v.items()}


def _fields(space: FlowSpace, basis: AbstractBasis, x: np.ndarray) -> dict[str, DiscreteField]:
    return {f"u{i}": basis.interpolate(space.split(x)[i]) for i in range(2)}


def _mean_flux(flow: MixedFlow, x: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Mean flux of both sides (none on the outlet) against w, on the edges of each element."""
    space, nu = flow.space, 1.0 / flow.reynolds
    mesh = space.mesh
    result = np.zeros(space.n_elements)
    sides = [
        InteriorFacetBasis(mesh, space.velocity.elem, side=s, intorder=2 * space.degree)
        for s in (0, 1)
    ]
    normal = sides[0].normals
    fluxes = [_flux(space, side, x, nu, normal) for side in sides]
    mean = 0.5 * (fluxes[0] + fluxes[1])
    test = _fields(space, sides[0], w)
    value = mean[0] * np.asarray(test["u0"]) + mean[1] * np.asarray(test["u1"])
    share = (value * sides[0].dx).sum(axis=1)
    np.add.at(result, sides[0].tind, share)
    np.add.at(result, sides[1].tind, -share)
    return result


def _flux(
    space: FlowSpace, side: FacetBasis, x: np.ndarray, nu: float, n: np.ndarray
) -> np.ndarray:
    """``d_n u / Re - p n`` on facets, ``(2, n_facets, q)``."""
    u = _fields(space, side, x)
    p = np.asarray(side.with_element(space.pressure.elem).interpolate(space.split(x)[2]))
    return np.stack(
        [nu * (u[f"u{i}"].grad[0] * n[0] + u[f"u{i}"].grad[1] * n[1]) - p * n[i] for i in (0, 1)]
    )
