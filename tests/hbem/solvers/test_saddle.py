"""Direct and iterative solves of the saddle system."""

import numpy as np
import pytest
from scipy.sparse.linalg import aslinearoperator

from cases.geometry.bodies import sphere, torus
from hbem.layers.single_layer import single_layer
from hbem.solvers.saddle import DenseSaddle, IterativeSaddle, KrylovResult, saddle


@pytest.fixture(scope="module")
def system():
    body = torus(6, 6)
    layer = single_layer(body, body.coefficients)
    velocity = np.sin(layer.surface.outer.points @ np.ones((3, 3)) + np.arange(3))
    return layer, layer.surface, layer.surface.project(velocity).ravel()


def test_gmres_agrees_with_lu(system):
    layer, surface, data = system
    direct = DenseSaddle(layer, surface.constraint, surface.mass).solve(data)
    operator = aslinearoperator(layer.dense())
    found = IterativeSaddle(operator, surface.constraint, surface.mass, 1e-10).solve(data)
    assert direct.result is KrylovResult.DIRECT
    assert direct.residual < 1e-12
    assert found.result is KrylovResult.CONVERGED
    assert found.residual <= 1e-10
    assert found.iterations < 60
    assert len(found.history) == found.iterations
    size = np.abs(direct.solution).max()
    assert np.abs(found.solution - direct.solution).max() < 1e-7 * size
    assert found.zeta == pytest.approx(direct.zeta, abs=1e-8)


def test_constraint_holds(system):
    layer, surface, data = system
    found = DenseSaddle(layer, surface.constraint, surface.mass).solve(data)
    scale = np.linalg.norm(surface.constraint) * np.linalg.norm(found.solution)
    assert abs(surface.constraint.ravel() @ found.solution) < 1e-13 * scale


def test_missed_tolerance_is_reported(system):
    layer, surface, data = system
    found = IterativeSaddle(layer, surface.constraint, surface.mass, 1e-12, 5).solve(data)
    assert found.result is KrylovResult.ITERATIONS
    assert not found.result.ok
    assert found.iterations == 5
    assert found.residual > 1e-12


def test_counts_do_not_depend_on_units():
    body = sphere(6, 6)
    counts, solutions = [], []
    for scale in (1.0, 1e-3):
        layer = single_layer(body, scale * body.coefficients)
        surface = layer.surface
        velocity = np.cross([0.0, 1.0, 0.0], surface.outer.points / scale)
        data = surface.project(velocity).ravel()
        found = IterativeSaddle(layer, surface.constraint, surface.mass, 1e-9).solve(data)
        counts.append(found.iterations)
        solutions.append(scale * found.solution)
    assert abs(counts[0] - counts[1]) <= 1
    np.testing.assert_allclose(solutions[0], solutions[1], atol=1e-6 * np.abs(solutions[0]).max())


def test_choice_by_size(system):
    layer, surface, _ = system
    assert isinstance(saddle(layer, surface.constraint, surface.mass), DenseSaddle)
    small = saddle(layer, surface.constraint, surface.mass, dense_limit=10)
    assert isinstance(small, IterativeSaddle)
