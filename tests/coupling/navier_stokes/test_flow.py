"""Mixed-model flow: convection against scikit-fem forms, exact flows, checked factors, Newton."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu
from skfem import LinearForm, MeshQuad

from coupling.navier_stokes.checked_factor import Factor, LinearSolveError
from coupling.navier_stokes.convection import Convection
from coupling.navier_stokes.flow import mixed_flow
from coupling.navier_stokes.newton import Newton, continuation, solve, solve_robustly
from coupling.navier_stokes.ordering import dissection
from coupling.navier_stokes.spaces import taylor_hood


def channel(n: int = 4, triangles: bool = False):
    """Unit height, length 2, named boundaries."""
    mesh = MeshQuad.init_tensor(np.linspace(0, 2, 2 * n + 1), np.linspace(0, 1, n + 1))
    mesh = mesh.to_meshtri() if triangles else mesh
    return mesh.with_boundaries(
        {
            "inlet": lambda x: x[0] < 1e-9,
            "outlet": lambda x: x[0] > 2 - 1e-9,
            "walls": lambda x: (x[1] < 1e-9) | (x[1] > 1 - 1e-9),
        }
    )


def parabola(x):
    return np.stack([4 * x[1] * (1 - x[1]), 0 * x[1]])


def rest(x):
    return np.zeros_like(x)


def flow(reynolds: float = 50.0, **options):
    mesh = options.pop("mesh", None) or channel()
    walls = {"inlet": parabola, "walls": rest}
    return mixed_flow(mesh, walls, reynolds=reynolds, outlet="outlet", **options)


def distorted(mesh):
    p = mesh.p.copy()
    p[0] += 0.03 * np.sin(5 * p[1]) * p[0] * (2 - p[0])
    p[1] += 0.04 * np.sin(3 * p[0]) * p[1] * (1 - p[1])
    return type(mesh)(p, mesh.t)


@pytest.fixture(params=[False, True], ids=["quadrilaterals", "triangles"])
def space(request):
    return taylor_hood(distorted(channel(3, request.param)))


@pytest.fixture
def field(space):
    return np.random.default_rng(1).standard_normal(space.n)


def _reference_vector(space, x, flagged):
    """The same by scikit-fem's forms."""
    part = space.velocity.with_elements(np.flatnonzero(flagged))
    u = [part.interpolate(c) for c in space.split(x)[:2]]
    forms = [
        LinearForm(
            lambda v, w, i=i: (w.u0 * w[f"u{i}"].grad[0] + w.u1 * w[f"u{i}"].grad[1]) * v
        ).assemble(part, u0=u[0], u1=u[1])
        for i in range(2)
    ]
    return np.concatenate([*forms, np.zeros(space.pressure.N)])


def test_convection_equals_the_forms_of_scikit_fem(space, field):
    flagged = np.arange(space.n_elements) % 3 > 0
    ours = Convection(space).vector(field, flagged)
    assert ours == pytest.approx(_reference_vector(space, field, flagged), abs=1e-13)
    z = np.random.default_rng(2).standard_normal(space.n)
    elements = Convection(space).elements(field, z, flagged)
    assert elements.sum() == pytest.approx(ours @ z, rel=1e-12)
    assert not elements[~flagged].any()


@pytest.mark.parametrize("skew", [False, True])
@pytest.mark.parametrize("frozen", [False, True])
def test_tangent_is_the_derivative(skew, frozen):
    problem = flow()
    rng = np.random.default_rng(3)
    x, step, other = (rng.standard_normal(problem.space.n) for _ in range(3))
    problem = problem.skew() if skew else problem
    problem = problem.with_wind(other) if frozen else problem
    c, rows = problem.convection, np.arange(problem.space.n_elements)
    blocks = c.matrices(x, rows)
    dofs = problem.space.element_dofs[: blocks.shape[1]].T
    ours = np.bincount(
        dofs.ravel(), np.einsum("eij,ej->ei", blocks, step[dofs]).ravel(), minlength=x.size
    )
    # quadratic in x: central differences are exact
    plus, minus = (c.vector(x + s * step, problem.everywhere) for s in (0.5, -0.5))
    assert ours == pytest.approx(plus - minus, abs=1e-12)


def test_skew_form_gives_no_energy_but_outflow():
    problem = flow().skew()
    x = np.random.default_rng(4).standard_normal(problem.space.n)
    x[problem.fixed] = 0.0
    basis = problem.convection.outlet
    u = [basis.interpolate(c) for c in problem.space.split(x)[:2]]
    square = np.asarray(u[0]) ** 2 + np.asarray(u[1]) ** 2
    carried = 0.5 * float((basis.dx * np.asarray(u[0]) * square).sum())
    energy = float(x @ problem.convection.vector(x, problem.everywhere))
    assert energy == pytest.approx(carried, rel=1e-11)


@pytest.mark.parametrize("stress", [False, True])
@pytest.mark.parametrize("triangles", [False, True])
def test_developed_flow_is_exact(stress, triangles):
    problem = flow(mesh=channel(3, triangles), stress=stress)
    for form in (problem, problem.skew()):
        found = solve_robustly(form, form.everywhere)
        ux, uy, p = form.space.split(found.x)
        exact = parabola(form.space.velocity.doflocs)[0]
        assert found.ok
        assert ux == pytest.approx(exact, abs=1e-12)
        assert uy == pytest.approx(0.0, abs=1e-12)
        drop = 8.0 / form.reynolds * (2.0 - form.space.pressure.doflocs[0])
        assert p == pytest.approx(drop, abs=1e-12)


def test_dissection_orders_all_unknowns_with_little_fill():
    problem = flow(mesh=channel(32))
    space = problem.space
    last = np.arange(space.n) >= 2 * space.n_velocity
    order = dissection(space.element_dofs, space.centres, last)
    assert np.array_equal(np.sort(order), np.arange(space.n))
    factor = problem.tangent(problem.values, problem.everywhere)
    data = problem.viscous_data / problem.reynolds + problem.saddle_data
    default = splu(problem.pattern.matrix(data))
    assert factor.fill < 0.7 * default.nnz  # measured 0.60
    b = np.random.default_rng(5).standard_normal(problem.pattern.order.size)
    factor.solve(b)
    assert factor.residual < 1e-12


def test_a_wrong_factor_does_not_go_unnoticed():
    rng = np.random.default_rng(6)
    matrix = csc_array(rng.standard_normal((30, 30)) + 10 * np.eye(30))
    factor = Factor(matrix)
    b = rng.standard_normal(30)
    exact = np.linalg.solve(matrix.toarray(), b)
    factor._lu = splu(csc_array(np.eye(30)))  # as if a stale factor had been kept
    assert factor.solve(b) == pytest.approx(exact, rel=1e-9)
    singular = np.ones((3, 3))
    singular[2, 2] = 1.0 + 1e-15
    with pytest.raises((LinearSolveError, RuntimeError)):
        Factor(csc_array(singular)).solve(np.array([1.0, 2.0, 3.0]))


def test_newton_says_when_it_fails_and_continuation_helps():
    problem = flow(reynolds=400.0, mesh=channel(4))
    x = np.random.default_rng(7).standard_normal(problem.space.n)
    broken = solve(problem, problem.everywhere, x, max_iterations=1)
    assert broken.outcome is Newton.STALLED
    assert not broken.ok
    found = continuation(problem, problem.everywhere)
    assert found.ok
    assert found.residual < 1e-12


def test_stokes_takes_one_factorisation():
    problem = flow(reynolds=1000.0)
    found = solve_robustly(problem, problem.nowhere)
    assert (found.ok, found.factorisations) == (True, 1)


def test_bad_problems_are_named():
    with pytest.raises(ValueError, match="no boundary"):
        mixed_flow(channel(), {"left": parabola}, reynolds=1.0)
    with pytest.raises(ValueError, match="positive, got -1"):
        flow(reynolds=-1.0)
    with pytest.raises(ValueError, match="degree 3 on MeshQuad"):
        taylor_hood(channel(), 3)


def test_fields_move_between_spaces():
    coarse = taylor_hood(channel(3, triangles=True))
    richer = taylor_hood(coarse.mesh, 3)
    finer = taylor_hood(coarse.mesh.refined())

    def values(space):
        u, p = space.velocity.doflocs, space.pressure.doflocs
        return np.concatenate([u[0] * u[1], u[0] ** 2 - u[1], 1.0 + p[0] - 2 * p[1]])

    assert richer.nodal(coarse, values(coarse)) == pytest.approx(values(richer), abs=1e-13)
    assert coarse.nodal(richer, values(richer)) == pytest.approx(values(coarse), abs=1e-13)
    assert finer.transfer(coarse, values(coarse)) == pytest.approx(values(finer), abs=1e-11)


def test_stress_form_equals_its_definition():
    problem = flow(stress=True, mesh=channel(2, triangles=True))
    space = problem.space
    x = np.random.default_rng(8).standard_normal(space.n)
    u = [space.velocity.interpolate(c) for c in space.split(x)[:2]]
    g = np.array([[u[i].grad[j] for j in range(2)] for i in range(2)])
    strain = 0.5 * (g + g.transpose(1, 0, 2, 3))
    inside = float((2.0 * (strain**2).sum(axis=(0, 1)) * space.velocity.dx).sum())
    basis = problem.convection.outlet
    b = [basis.interpolate(c) for c in space.split(x)[:2]]
    rim = sum(b[j].grad[i] * basis.normals[j] * np.asarray(b[i]) for i in (0, 1) for j in (0, 1))
    outlet = float((rim * basis.dx).sum())
    assert float(x @ (problem.viscous @ x)) == pytest.approx(inside - outlet, rel=1e-11)
