"""Two-level Schwarz in a thin gap, several components, reuse.

Measured (true residual 1e-6, disc bag of gap/extent 0.05, 1176 unknowns): Schwarz 7 iterations,
mass matrix 60.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse.linalg import aslinearoperator

from cases.geometry.bodies import sphere
from cases.geometry.pillows.pillow import round_bag
from hbem import StokesFlow
from hbem.layers.direct_layer import DirectSingleLayer
from hbem.layers.single_layer import single_layer
from hbem.solvers.coarse_level import apply_to_coarse_space, bisect
from hbem.solvers.gmres import KrylovResult, gmres
from hbem.solvers.nested import nested_schwarz
from hbem.solvers.preconditioner_reuse import PreconditionerStore
from hbem.solvers.saddle import DenseSaddle, IterativeSaddle
from hbem.solvers.saddle_system import MassPreconditioner, SaddleSystem
from hbem.solvers.schwarz import (
    Functions,
    SchwarzOptions,
    coarse_space,
    subdomains_around,
    two_level_schwarz,
)
from hbem.surfaces.patches import union
from hbem.surfaces.topology import closed_components


@pytest.fixture(scope="module")
def gap():
    """A thin disc bag, its single layer and the data of a squeezing, shearing motion."""
    bag = round_bag(28, gap=0.05)
    layer = single_layer(bag.patches(), bag.coefficients)
    x = layer.surface.outer.points
    velocity = np.cross([0.3, 0.5, 1.0], x) + x * [1.0, 1.0, -2.0]
    return layer, layer.surface.project(velocity).ravel()


def test_clusters_cover_every_function_once(gap):
    layer, _ = gap
    functions = Functions.of(layer.surface)
    clusters = bisect(functions.positions, 40)
    assert max(c.size for c in clusters) <= 40
    np.testing.assert_array_equal(np.sort(np.concatenate(clusters)), np.arange(392))
    for own, around in zip(clusters, subdomains_around(functions, clusters, 2.5), strict=True):
        np.testing.assert_array_equal(around[: own.size], own)
        assert np.unique(around).size == around.size
        # both sheets of the gap
        assert np.ptp(np.sign(functions.positions[around, 2])) == 2.0


def test_coarse_densities_hold_constants_and_the_normal(gap):
    layer, _ = gap
    functions = Functions.of(layer.surface)
    Z = coarse_space(functions, bisect(functions.positions, 64)).densities
    gram = (Z.T @ Z).toarray()
    np.testing.assert_allclose(gram, np.eye(Z.shape[1]), atol=1e-12)
    for density in (np.tile([1.0, 2.0, 3.0], (392, 1)), functions.normals):
        v = density.ravel()
        assert np.linalg.norm(v - Z @ (Z.T @ v)) < 1e-10 * np.linalg.norm(v)


def test_few_iterations_in_a_gap(gap):
    layer, data = gap
    surface = layer.surface
    schwarz = two_level_schwarz(
        SaddleSystem(layer, surface.constraint, surface.mass), SchwarzOptions(own=32)
    )
    direct = DenseSaddle(layer, surface.constraint, surface.mass).solve(data).solution

    def solve(preconditioner):
        return IterativeSaddle(
            layer, surface.constraint, surface.mass, 1e-6, preconditioner=preconditioner
        ).solve(data)

    found, plain = solve(lambda system: schwarz), solve(MassPreconditioner)
    assert found.result is KrylovResult.CONVERGED
    assert found.residual <= 1e-6
    assert found.iterations <= 9
    assert plain.iterations > 50
    error = np.linalg.norm(found.solution - direct) / np.linalg.norm(direct)
    assert error < 1e-4  # 2e-5: a good preconditioner makes the residual meaningful
    assert "clusters" in repr(schwarz)


def test_direct_blocks_and_coarse_products_agree_with_the_stored_matrix(gap):
    """Near part and plain kernel are the operator's own entries; coarse products are smooth."""
    stored, _ = gap
    direct = DirectSingleLayer(stored.surface, stored.near)
    functions = Functions.of(stored.surface)
    clusters = bisect(functions.positions, 25)
    around = subdomains_around(functions, clusters, 1.0)
    blocks = (layer.blocks(around, lambda k, block: block) for layer in (direct, stored))
    for found, exact in zip(*blocks, strict=True):
        np.testing.assert_allclose(found, exact, atol=1e-13 * np.abs(exact).max())
    coarse = coarse_space(functions, clusters)
    found, exact = (apply_to_coarse_space(layer, coarse) for layer in (direct, stored))
    np.testing.assert_allclose(exact, stored.dense() @ coarse.densities.toarray(), atol=1e-15)
    error = np.linalg.norm(found - exact) / np.linalg.norm(exact)
    assert error < 3e-3
    assert error > 1e-12  # some boxes were far


def test_only_single_layers_have_a_surface_to_cluster(gap):
    layer, _ = gap
    surface = layer.surface
    system = SaddleSystem(aslinearoperator(layer.dense()), surface.constraint, surface.mass)
    with pytest.raises(TypeError, match="needs a SingleLayer"):
        two_level_schwarz(system)


def test_one_multiplier_for_each_component():
    """Two spheres drift apart: each component's traction is orthogonal to its own normal."""
    one = sphere(5, 6)
    both = union(one, one)
    coefficients = np.concatenate([one.coefficients, one.coefficients + np.array([0.0, 0.0, 2.3])])
    layer = single_layer(both, coefficients)
    surface = layer.surface
    components = closed_components(both, coefficients)
    upper = surface.outer.points[:, 2] > 1.15
    data = surface.project(np.where(upper[:, None], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0])).ravel()
    direct = DenseSaddle(layer, surface.constraint, surface.mass, components).solve(data)
    assert direct.zeta.shape == (2,)
    for k in range(2):
        mask = components == k
        flux = np.sum(surface.constraint[mask] * direct.solution.reshape(-1, 3)[mask])
        assert abs(flux) < 1e-12 * np.abs(direct.solution).max()
    iterative = IterativeSaddle(
        layer, surface.constraint, surface.mass, 1e-9, components=components
    ).solve(data)
    assert iterative.result.ok
    np.testing.assert_allclose(iterative.solution, direct.solution, atol=1e-6)


def test_store_keeps_until_it_degrades():
    store = PreconditionerStore(lambda system: lambda v: v, growth=1.5, slack=2)
    system = SimpleNamespace(size=10)
    kept = []
    for iterations in (10, 12, 17, 18, 30):
        kept.append(store(system))
        store.note(iterations)
    assert kept[0] is kept[3] is not kept[4]  # 18 > 1.5 * 10 + 2 drops the first
    assert store(system) is kept[4]  # 30 counts as the second one's first
    store.drop()
    assert store(system) is not kept[4]
    store(SimpleNamespace(size=11))
    assert store.built == 4


def test_gmres_reports_the_true_residual():
    rng = np.random.default_rng(0)
    A = np.diag(np.geomspace(1.0, 1e3, 60)) + 0.1 * rng.standard_normal((60, 60))
    f = rng.standard_normal(60)
    found = gmres(lambda x: A @ x, lambda v: v, f, tolerance=1e-10, max_iterations=100)
    assert found.result is KrylovResult.CONVERGED
    assert abs(np.linalg.norm(A @ found.x - f) / np.linalg.norm(f) - found.residual) < 1e-14
    again = gmres(
        lambda x: A @ x, lambda v: v, f, tolerance=1e-10, max_iterations=100, start=found.x
    )
    assert again.history == ()
    short = gmres(lambda x: A @ x, lambda v: v, f, tolerance=1e-10, max_iterations=20, restart=8)
    assert short.result is KrylovResult.ITERATIONS
    assert len(short.history) == 20
    lost = gmres(lambda x: A @ x, lambda v: 0.0 * v + 1.0, f, tolerance=1e-10, max_iterations=99)
    assert lost.result is KrylovResult.STAGNATED
    assert not lost.result.ok
    zero = gmres(lambda x: A @ x, lambda v: v, 0.0 * f, tolerance=1e-10, max_iterations=9)
    assert zero.result.ok


def test_larger_space_over_the_solver_of_the_smaller():
    flow = StokesFlow(sphere(4, 6))
    larger, rng = flow.larger, np.random.default_rng(0)
    exact = larger.formulation.system
    assert isinstance(exact, DenseSaddle)
    residual = rng.standard_normal(exact.operator.shape[0])
    none = 0.0 * residual
    nested = IterativeSaddle(
        exact.operator,
        exact.constraint,
        exact.mass,
        preconditioner=lambda s: nested_schwarz(s, flow.formulation.system, larger.injection),
    )
    found = nested.correction(residual, none, 1e-8)
    assert found.result.ok
    assert found.iterations < 25
    wanted = exact.correction(residual, none, 0.0).solution
    np.testing.assert_allclose(found.solution, wanted, atol=1e-6 * abs(wanted).max())
