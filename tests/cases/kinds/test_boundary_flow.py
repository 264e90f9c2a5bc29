"""Navier-Stokes finite elements with Stokes boundary elements against finite elements alone."""

from __future__ import annotations

import numpy as np
import pytest

from cases.kinds.adaptive_flow.build import DIRICHLET, OUTLET, boundary_flow_on, flow_on
from cases.kinds.adaptive_flow.geometry import channel_cavity
from coupling.model_adaptivity import goals
from coupling.model_adaptivity.adaptive_loop import Strategy, full_model
from coupling.partitions.boundary_loop import adapt_boundary
from coupling.partitions.boundary_traces import boundary_loops
from coupling.partitions.substructure import connect_to_outlet, cut, solve_monolithic

CORNER = (1.9, 2.0, -1.0, -0.9)


def _vorticity(space):
    return goals.vorticity(space, goals.region(space, CORNER))


def test_upstream_channel_by_boundary_elements():
    errors, goal_errors = [], []
    for cells in (10, 20):
        mesh = channel_cavity(cells)
        flagged = mesh.p[0, mesh.t].mean(axis=0) > 0.8
        parts = cut(mesh, flagged, DIRICHLET, reynolds=10.0, outlet=OUTLET)
        reference = solve_monolithic(parts)
        flow = boundary_flow_on(mesh, flagged, 10.0)
        x, levels = flow.solve()
        trace = parts.inner_trace
        error = np.linalg.norm(x[trace] - reference.inner[trace])
        errors.append(error / np.linalg.norm(reference.inner[trace]))
        goal = _vorticity(flow.inner.space)
        goal_errors.append(abs(goal.value(x) / goal.value(reference.inner) - 1.0))
        whole = flow.field(x, levels)
        inside = parts.outer.space.velocity
        found = (
            flow.space.velocity.probes(np.array([[0.3, 0.4], [0.5, 0.2]]))
            @ whole[: flow.space.n_velocity]
        )
        wanted = (
            inside.probes(np.array([[0.3, 0.4], [0.5, 0.2]]))
            @ parts.outer.space.split(reference.outer)[0]
        )
        assert found == pytest.approx(wanted, abs=1.0 / cells**2)
    assert errors[1] < errors[0] / 3.0
    assert errors[1] < 3e-4  # measured 2.1e-4
    assert goal_errors[1] < goal_errors[0] / 3.0


def test_loops_run_counterclockwise_and_bridges_reach_the_outflow():
    mesh = channel_cavity(5)
    x, y = mesh.p[:, mesh.t].mean(axis=1)
    (loop,) = boundary_loops(mesh, y < 0.0)
    px, py = mesh.p[:, loop]
    area = 0.5 * (px * np.roll(py, -1) - np.roll(px, -1) * py).sum()
    assert area == pytest.approx(1.0)
    seed = (x > 1.8) & (x < 2.0) & (y < -0.8)
    joined = connect_to_outlet(mesh, seed, OUTLET)
    assert joined[seed].all()
    assert joined.sum() < 20
    cut(mesh, joined, DIRICHLET, reynolds=10.0, outlet=OUTLET)  # accepts it


def test_enclosed_pieces_are_refused():
    mesh = channel_cavity(5)
    x, y = mesh.p[:, mesh.t].mean(axis=1)
    stokes = (x < 2.2) & ~((x > 1.2) & (x < 1.4) & (y > 0.4) & (y < 0.6))
    with pytest.raises(ValueError, match="without outflow"):
        boundary_flow_on(mesh, ~stokes, 10.0)


def test_mesh_free_loop_reduces_the_error():
    mesh = channel_cavity(10)
    whole = flow_on(mesh, 10.0, stress=True)
    reference, _ = full_model(whole, _vorticity(whole.space))
    steps = list(
        adapt_boundary(
            whole,
            lambda flagged: boundary_flow_on(mesh, flagged, 10.0),
            _vorticity,
            goals.region(whole.space, CORNER),
            Strategy(adjoint="enriched", layers=2, tolerance=1e-3, max_steps=8),
            outlet=OUTLET,
            reference=reference,
        )
    )
    fractions = [s.element_fraction for s in steps]
    assert fractions == sorted(fractions)
    assert steps[-1].bound < 1e-3
    assert abs(steps[-1].error) < 0.05 * abs(steps[0].error)
