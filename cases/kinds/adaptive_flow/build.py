"""A model-adaptive scene as objects: mesh, flow, goal and strategy.

The only place where this kind of scene meets the libraries.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from skfem import Mesh

from coupling.model_adaptivity import goals
from coupling.model_adaptivity.adaptive_loop import Step, Strategy
from coupling.model_adaptivity.mesh_adaptivity import MeshLevel, refinements
from coupling.navier_stokes.flow import MixedFlow, mixed_flow
from coupling.partitions.boundary_stokes import BoundaryFlow, boundary_flow
from hbem.planar.polygon_stokes import PolygonStokes

from .config import AdaptiveFlowScene, EnergyGoal, VelocityGoal, VorticityGoal
from .geometry import channel_cavity, inflow, rest, with_names

DIRICHLET = {"inlet": inflow, "walls": rest}
OUTLET = "outlet"


@dataclass(frozen=True)
class AdaptiveProblem:
    """What a scene stands for.

    Attributes
    ----------
    flow : MixedFlow
    goal : Goal
    strategy : Strategy
    discretisation : float
        Estimated discretisation error of the full model's goal, absolute; NaN on uniform meshes,
        where it is not estimated.
    """

    flow: MixedFlow
    goal: goals.Goal
    strategy: Strategy
    discretisation: float = float("nan")


def flow_on(mesh: Mesh, reynolds: float, degree: int = 2, stress: bool = False) -> MixedFlow:
    """The channel flow on a mesh with named boundaries."""
    return mixed_flow(
        mesh, DIRICHLET, reynolds=reynolds, outlet=OUTLET, degree=degree, stress=stress
    )


def goal(scene: AdaptiveFlowScene, flow: MixedFlow) -> goals.Goal:
    """The scene's goal on a flow.

    Raises
    ------
    ValueError
        A region or a point that does not fit the mesh.
    """
    g = scene.goal
    if isinstance(g, VorticityGoal):
        return goals.vorticity(flow.space, goals.region(flow.space, g.region))
    if isinstance(g, EnergyGoal):
        return goals.kinetic_energy(flow.space)
    if isinstance(g, VelocityGoal):
        return goals.point_value(flow.space, g.point, g.radius, g.component)
    return goals.boundary_force(flow, "walls", g.direction)


def levels(scene: AdaptiveFlowScene) -> Iterator[MeshLevel]:
    """Iterator over the meshes that are adapted to the scene's goal."""

    def problem(mesh: Mesh, degree: int) -> tuple[MixedFlow, goals.Goal]:
        flow = flow_on(with_names(mesh), scene.flow.reynolds, degree)
        return flow, goal(scene, flow)

    f = scene.flow
    return refinements(
        problem, channel_cavity(f.cells, triangles=True), f.refinements, f.refined_fraction
    )


def problem(
    scene: AdaptiveFlowScene, news: Callable[[str], None] = lambda text: None
) -> AdaptiveProblem:
    """Flow, goal and strategy; ``news`` hears about each adapted mesh."""
    error = float("nan")
    if scene.flow.refinements:
        for level in levels(scene):
            share = level.error / level.value
            news(f"mesh: {level.flow.space.n_elements} triangles, discretisation {share:.1e}")
        flow, error = level.flow, level.error
    else:
        flow = flow_on(channel_cavity(scene.flow.cells), scene.flow.reynolds)
    if scene.flow.convection == "skew":
        flow = flow.skew()
    a: Any = scene.adaptivity  # its words are among the strategy's: their rules say so
    strategy = Strategy(
        indicator=a.indicator,
        adjoint=a.adjoint,
        layers=a.layers,
        marking=a.marking,
        parameter=a.parameter,
        tolerance=a.tolerance,
        max_steps=a.max_steps,
    )
    return AdaptiveProblem(flow, goal(scene, flow), strategy, error)


def grid(flow: MixedFlow, step: Step) -> dict[str, Any]:
    """Mesh and fields of a step for files and pictures, at the vertices."""
    space = flow.space
    mesh, x = space.mesh, step.solution.x
    vertices = space.velocity.nodal_dofs[0]
    ux, uy, p = space.split(x)
    zero = np.zeros(mesh.p.shape[1])
    cells = {"navier-stokes": step.flagged.astype(float)}
    points = {
        "velocity": np.stack([ux[vertices], uy[vertices], zero], axis=1),
        "pressure": p[space.pressure.nodal_dofs[0]],
    }
    if step.estimated is not None:
        zx, zy, _ = space.split(step.estimated.adjoint)
        points["adjoint"] = np.stack([zx[vertices], zy[vertices], zero], axis=1)
        cells["indicator"] = step.estimated.indicators
    key = "quads" if mesh.t.shape[0] == 4 else "triangles"
    return {
        "points": np.stack([*mesh.p, zero], axis=1),
        key: mesh.t.T,
        "point_data": points,
        "cell_data": cells,
    }


def skipped(scene: AdaptiveFlowScene) -> list[str]:
    """What this scene does not need and a run therefore leaves out."""
    skips = []
    if not scene.adaptivity.reference:
        skips.append("true errors: adaptivity.reference is off, no full model is solved")
    if not scene.flow.refinements:
        skips.append("discretisation error: not estimated on uniform meshes")
    return skips


def boundary_operators(polygon: np.ndarray) -> PolygonStokes:
    """Planar Stokes operators of a polygon, for the Stokes part by boundary elements."""
    return PolygonStokes(polygon)


def boundary_flow_on(
    mesh: Mesh, flagged: np.ndarray, reynolds: float, segments: int = 2
) -> BoundaryFlow:
    """Navier-Stokes finite elements coupled to Stokes boundary elements."""
    return boundary_flow(
        mesh,
        flagged,
        DIRICHLET,
        boundary_operators,
        reynolds=reynolds,
        outlet=OUTLET,
        segments=segments,
    )
