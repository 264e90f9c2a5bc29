"""Rows of the adaptivity benchmark on partitions: partitioned iterations, boundary elements.

Partitioned schemes against the monolithic problem; the Stokes part by boundary elements against
finite elements, on fixed partitions and in the adaptive loop with its choices of adjoint.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

import numpy as np

from coupling.model_adaptivity import goals
from coupling.model_adaptivity.adaptive_loop import Strategy, full_model
from coupling.navier_stokes.flow import MixedFlow
from coupling.navier_stokes.newton import solve_robustly
from coupling.partitions.boundary_loop import adapt_boundary
from coupling.partitions.interface_iterations import Transmission, solve_partitioned
from coupling.partitions.substructure import cut, solve_monolithic
from coupling.schemes.quasi_newton import QuasiNewton
from coupling.schemes.relaxation import Aitken, GaussSeidel, Relaxation

from ...kinds.adaptive_flow import build
from ...kinds.adaptive_flow.build import DIRICHLET, OUTLET
from ...kinds.adaptive_flow.geometry import channel_cavity
from ..report import Row

PLAIN = "no relaxation"
CORNER = (1.9, 2.0, -1.0, -0.9)


def vorticity(flow: MixedFlow) -> goals.Goal:
    """The thesis' goal on a flow."""
    return goals.vorticity(flow.space, goals.region(flow.space, CORNER))


def partitioned_rows() -> list[Row]:
    """Partitioned against monolithic, Re = 10, h = 1/10."""
    mesh = channel_cavity(10)
    y = mesh.p[1, mesh.t].mean(axis=0)
    rows = []
    for part, flagged in (("cavity", y > 0.0), ("lower half of it", y > -0.5)):
        for stress in (True, False):
            parts = cut(mesh, flagged, DIRICHLET, reynolds=10.0, outlet=OUTLET, stress=stress)
            whole = solve_monolithic(parts)
            n = 2 * parts.inner.space.n_velocity
            for transmission in Transmission:
                for name, relaxation in relaxations().items():
                    began = time.process_time()
                    found = solve_partitioned(
                        parts, relaxation, transmission=transmission, tolerance=1e-13
                    )
                    rows.append(
                        {
                            "case": f"S = {part}, {transmission.name.lower()}, {name}",
                            "seconds": time.process_time() - began,
                            "error": float(np.abs(found.inner - whole.inner)[:n].max()),
                            "error_kind": "largest velocity difference",
                            "reference": "monolithic, pressure double-valued",
                            "stress": "full" if stress else "laplacian",
                            "passes": found.iterations,
                            "converged": found.converged,
                            # passes without relaxation are shown to fail; nothing else may
                            **({} if found.converged or name != PLAIN else {"expected": "fail"}),
                        }
                    )
    return rows


def relaxations() -> Mapping[str, Relaxation]:
    """The schemes of the coupling package that partitions are run with."""
    return {
        PLAIN: GaussSeidel(),
        "aitken": Aitken(),
        # within one solve IQN-ILS and Anderson's acceleration are the same method
        "anderson": QuasiNewton(filter=1e-8),
    }


FIXED: Mapping[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {
    "upstream channel": lambda x, y: x > 0.8,
    "cavity": lambda x, y: y > 0.0,
}


def boundary_row(name: str, cells: int) -> Row:
    """Boundary elements for the Stokes part against finite elements; both against h / 2."""
    mesh, fine = channel_cavity(cells), channel_cavity(2 * cells)
    flagged = FIXED[name](*mesh.p[:, mesh.t].mean(axis=1))
    began = time.process_time()
    flow = build.boundary_flow_on(mesh, flagged, 10.0)
    x, _ = flow.solve()
    seconds = time.process_time() - began
    parts = cut(mesh, flagged, DIRICHLET, reynolds=10.0, outlet=OUTLET)
    began = time.process_time()
    coarse = solve_monolithic(parts)
    peer = time.process_time() - began
    finer = cut(
        fine, FIXED[name](*fine.p[:, fine.t].mean(axis=1)), DIRICHLET, reynolds=10.0, outlet=OUTLET
    )
    better = solve_monolithic(finer)
    at = parts.inner_trace
    size = np.linalg.norm(coarse.inner[at])
    points = parts.inner.space.points[:, at]
    half = at.size // 2
    probe = finer.inner.space.velocity.probes(points[:, :half])
    values = np.concatenate([probe @ c for c in finer.inner.space.split(better.inner)[:2]])
    energy = [
        goals.kinetic_energy(f.space).value(v)
        for f, v in ((flow.inner, x), (parts.inner, coarse.inner), (finer.inner, better.inner))
    ]
    return {
        "case": f"S = {name}, h = 1/{cells}, boundary elements",
        "seconds": seconds,
        "error": float(np.linalg.norm(x[at] - coarse.inner[at]) / size),
        "error_kind": "interface velocity",
        "reference": "finite elements, same mesh",
        "finite elements to h/2": float(np.linalg.norm(coarse.inner[at] - values) / size),
        "boundary elements to h/2": float(np.linalg.norm(x[at] - values) / size),
        "goal": energy[0] / energy[1] - 1.0,
        "goal, finite elements to h/2": energy[1] / energy[2] - 1.0,
        "ratio": seconds / peer,
        "peer": "finite elements, monolithic",
    }


def boundary_loops(cells: int) -> list[Row]:
    """The loop with a mesh-free Stokes part: full, enriched and mixed adjoints."""
    mesh = channel_cavity(cells)
    whole = build.flow_on(mesh, 10.0, stress=True)
    reference, _ = full_model(whole, vorticity(whole))
    rows = []
    for adjoint in ("full", "enriched", "mixed"):
        began = time.process_time()
        steps = adapt_boundary(
            whole,
            lambda flagged: build.boundary_flow_on(mesh, flagged, 10.0),
            lambda space: goals.vorticity(space, goals.region(space, CORNER)),
            goals.region(whole.space, CORNER),
            Strategy(adjoint=adjoint, layers=2, tolerance=1e-4, max_steps=8),
            outlet=OUTLET,
            reference=reference,
        )
        for k, step in enumerate(steps):
            stokes = solve_robustly(whole, step.flagged)
            value = vorticity(whole).value(stokes.x)
            rows.append(
                {
                    "case": f"boundary elements, {adjoint} adjoint, h = 1/{cells}, step {k}",
                    "seconds": time.process_time() - began,
                    "error": step.error,
                    "reference": "full model, finite elements, same mesh",
                    "estimate": step.estimate,
                    "bound": step.bound,
                    "model error": (reference - value) / value,
                    "effectivity": step.estimate * step.goal / (reference - value),
                    "elements": step.element_fraction,
                }
            )
            began = time.process_time()
    return rows
