"""Partitioned iterations against the monolithic problem with double-valued pressures."""

from __future__ import annotations

import numpy as np
import pytest

from cases.kinds.adaptive_flow.build import DIRICHLET, OUTLET, flow_on
from cases.kinds.adaptive_flow.geometry import channel_cavity
from coupling.navier_stokes.newton import solve_robustly
from coupling.partitions.interface_iterations import Transmission, solve_partitioned
from coupling.partitions.substructure import cut, solve_monolithic
from coupling.schemes.quasi_newton import QuasiNewton
from coupling.schemes.relaxation import Aitken, GaussSeidel


def _cavity(stress=True, cells=5):
    mesh = channel_cavity(cells)
    flagged = mesh.p[1, mesh.t].mean(axis=0) > 0.0
    return cut(mesh, flagged, DIRICHLET, reynolds=10.0, outlet=OUTLET, stress=stress)


@pytest.fixture(scope="module", params=[True, False], ids=["full-stress", "laplacian"])
def both(request):
    parts = _cavity(request.param)
    return parts, solve_monolithic(parts)


@pytest.mark.parametrize("transmission", Transmission)
@pytest.mark.parametrize("relaxation", [Aitken(), QuasiNewton(filter=1e-8)])
def test_partitioned_equals_monolithic(both, transmission, relaxation):
    parts, whole = both
    found = solve_partitioned(parts, relaxation, transmission=transmission, tolerance=1e-13)
    assert found.converged
    assert found.iterations < 50
    n, m = 2 * parts.inner.space.n_velocity, 2 * parts.outer.space.n_velocity
    assert found.inner[:n] == pytest.approx(whole.inner[:n], abs=1e-12)
    assert found.outer[:m] == pytest.approx(whole.outer[:m], abs=1e-12)


def test_plain_iterations():
    """Without relaxation Dirichlet-Neumann diverges; the thesis' scheme crawls."""
    parts = _cavity()
    broken = solve_partitioned(parts, GaussSeidel(), transmission=Transmission.DIRICHLET_NEUMANN)
    slow = solve_partitioned(parts, GaussSeidel(), max_iterations=20)
    assert not broken.converged
    assert not slow.converged
    assert np.all(np.isfinite(slow.inner))


def test_the_pressure_may_jump_but_tends_to_the_continuous_one():
    differences = []
    for cells in (5, 10):
        parts = _cavity(cells=cells)
        whole = solve_monolithic(parts)
        mesh = channel_cavity(cells)
        problem = flow_on(mesh, 10.0, stress=True)
        flagged = mesh.p[1, mesh.t].mean(axis=0) > 0.0
        one = solve_robustly(problem, flagged)
        p = np.array([0.5, 1.0, 1.5, 2.2]), np.array([0.5, 0.5, 0.3, 0.6])
        probe = [s.velocity.probes(np.array(p)) for s in (parts.inner.space, problem.space)]
        a = probe[0] @ parts.inner.space.split(whole.inner)[0]
        b = probe[1] @ problem.space.split(one.x)[0]
        differences.append(np.abs(a - b).max())
    assert differences[1] < 0.6 * differences[0]


def test_bad_partitions_are_named():
    mesh = channel_cavity(5)
    x, y = mesh.p[:, mesh.t].mean(axis=1)

    def attempt(flagged):
        return cut(mesh, flagged, DIRICHLET, reynolds=10.0, outlet=OUTLET)

    with pytest.raises(ValueError, match="touches the outflow"):
        attempt(x < 2.5)
    with pytest.raises(ValueError, match="without outflow"):
        attempt((x > 2.5) | (y < -0.5))
    with pytest.raises(ValueError, match="one part is empty"):
        attempt(x < 9.0)
