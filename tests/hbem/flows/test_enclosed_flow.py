"""Flow in a bag with an inlet: fluxes, loads and the linear response."""

import numpy as np
import pytest

from cases.geometry.bodies import fitted, sphere
from hbem.flows.enclosed_flow import EnclosedStokes
from hbem.surfaces.patches import union

MASS_RATIO = 0.02


def bag(**options):
    body = fitted(sphere(5, 6, degree=3, pole="c1"))
    inflow = np.arange(body.n_elements) < 6  # the row at the upper pole
    return EnclosedStokes(
        body, inflow, lambda x: np.maximum(x[:, 2], 0.0) ** 2, mass_ratio=MASS_RATIO, **options
    )


@pytest.fixture(scope="module")
def flow():
    model = bag()
    velocity = np.random.default_rng(1).standard_normal(model.patches.coefficients.shape)
    return model.assemble(model.patches.coefficients), velocity


def test_the_meshs_share_is_told_by_element(flow):
    operator, velocity = flow
    error = operator.traction(velocity).measure(0.0, False, True)
    assert error.elements.shape == (operator.problem.patches.n_elements,)
    assert np.linalg.norm(error.elements) == pytest.approx(error.mesh, rel=1e-12)
    assert operator.traction(velocity).measure(0.0, False, False).elements is None


def test_response_is_the_load_of_the_traction(flow):
    operator, velocity = flow
    traction = operator.traction(velocity)
    load = operator.load(traction).ravel()
    response = operator.response()
    assert np.abs(response @ velocity.ravel() - load).max() < 1e-10 * np.abs(load).max()
    dense = response.dense() @ velocity.ravel()
    assert np.abs(dense - load).max() < 1e-10 * np.abs(load).max()
    assert traction.residual < 1e-12


def test_influx_balances_the_membrane(flow):
    operator, velocity = flow
    outer = operator.surface.outer
    data = operator.boundary_velocity(velocity)
    total = outer.weights @ np.sum(data * outer.normals, axis=1)
    assert abs(total) < 1e-12 * max(1.0, abs(operator.flux(velocity)))


def test_drag_resists(flow):
    """A sphere moving past its lid at rest: about the Stokes drag, against the motion."""
    operator, _ = flow
    u = np.tile([0.0, 1.0, 0.0], (operator.problem.patches.n_coefficients, 1))
    assert abs(operator.flux(u)) < 1e-12
    load = operator.load(operator.traction(u)).sum(axis=0) / (6 * np.pi * MASS_RATIO)
    np.testing.assert_allclose(load, [0.0, -1.178, 0.0], atol=2e-3)


def test_response_dissipates_at_fixed_volume(flow):
    operator, _ = flow
    dense = operator.response().dense()
    q = operator.flux_form.ravel() / np.linalg.norm(operator.flux_form)
    keep = np.eye(q.size) - np.outer(q, q)
    symmetric = keep @ (dense + dense.T) @ keep
    eigenvalues = np.linalg.eigvalsh(symmetric)
    assert eigenvalues[-1] < 1e-4 * abs(eigenvalues[0])


def test_inflow_only_coefficients_feel_nothing(flow):
    operator, velocity = flow
    silent = np.flatnonzero(np.diff(operator.evaluation.tocsc().indptr) == 0)
    load = operator.load(operator.traction(velocity))
    assert np.abs(load[silent]).max(initial=0.0) == 0.0


def test_iterative_agrees_with_direct(flow):
    operator, velocity = flow
    model = bag(dense_limit=0, tolerance=1e-10)
    iterative = model.assemble(model.patches.coefficients).traction(velocity)
    direct = operator.traction(velocity)
    assert 0 < iterative.iterations < 20
    model.assemble(1.01 * model.patches.coefficients).traction(velocity)
    assert model.store.built == 1  # kept from one geometry to the next
    model.reset()
    model.assemble(model.patches.coefficients).traction(velocity)
    assert model.store.built == 2
    size = np.abs(direct.coefficients).max()
    assert np.abs(iterative.coefficients - direct.coefficients).max() < 1e-5 * size


def test_union_of_membrane_and_inlet():
    """Two separate spheres: blocks of the union are the single matrices."""
    from hbem.layers.single_layer import single_layer

    one = sphere(4, 5)
    both = union(one, one)
    assert both.n_dofs == 2 * one.n_dofs
    shifted = np.concatenate([one.coefficients, one.coefficients + np.array([0.0, 0.0, 5.0])])
    n = 3 * one.n_dofs
    A = single_layer(both, shifted).dense()
    alone = single_layer(one, one.coefficients).dense()
    np.testing.assert_allclose(A[:n, :n], alone, atol=1e-13 * np.abs(alone).max())
    np.testing.assert_allclose(A[:n, n:], A[n:, :n].T, atol=1e-4 * np.abs(alone).max())


def test_other_viscosity_ratios():
    """The dense response is the load of the traction; inner flow only costs less drag."""
    model = bag(viscosity_ratio=0.3)
    operator = model.assemble(model.patches.coefficients)
    velocity = np.random.default_rng(1).standard_normal(model.patches.coefficients.shape)
    load = operator.load(operator.traction(velocity)).ravel()
    dense = operator.response().dense() @ velocity.ravel()
    assert np.abs(dense - load).max() < 1e-9 * np.abs(load).max()
    assert operator.formulation.double.gauss_error < 1e-3
    u = np.tile([0.0, 1.0, 0.0], (model.patches.n_coefficients, 1))
    equal = bag().assemble(model.patches.coefficients)
    forces = [np.linalg.norm(o.load(o.traction(u)).sum(axis=0)) for o in (operator, equal)]
    assert 0.3 * forces[1] < forces[0] < forces[1]


def test_wrong_arguments():
    with pytest.raises(ValueError, match="not negative"):
        bag(viscosity_ratio=-0.5)
    body = sphere(4, 5)
    with pytest.raises(ValueError, match="preconditioner"):
        bag(preconditioner="ilu")
    with pytest.raises(ValueError, match="mass_ratio"):
        EnclosedStokes(body, np.arange(20) < 5, lambda x: x[:, 2], mass_ratio=0.0)
    with pytest.raises(ValueError, match="20 elements"):
        EnclosedStokes(body, np.arange(7) < 5, lambda x: x[:, 2], mass_ratio=1.0)
    with pytest.raises(ValueError, match="leave some"):
        EnclosedStokes(body, np.ones(20, bool), lambda x: x[:, 2], mass_ratio=1.0)
    with pytest.raises(ValueError, match="profile"):
        EnclosedStokes(body, np.zeros(20, bool), lambda x: x[:, 2], mass_ratio=1.0)
    with pytest.raises(ValueError, match="outer fluid"):
        bag(viscosity_ratio=0.0, background=lambda x: x)
    with pytest.raises(ValueError, match="degree"):
        union(body, fitted(body))
