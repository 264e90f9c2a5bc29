"""Identities and invariances of the assembled single layer."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from cases.geometry.bodies import fitted, sphere, spheroid, torus
from hbem.layers._plain_block_kernels import add_block
from hbem.layers.dense_blocks import vector_dofs
from hbem.layers.layer import SingleLayer
from hbem.layers.single_layer import single_layer
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.surface_points import sample


def matrix(body, coefficients=None, orders=None):
    return single_layer(body, body.coefficients if coefficients is None else coefficients, orders)


def test_constant_density_on_the_sphere():
    """V[c] = 2/3 c; measured 4e-6, and 9e-10 with denser plain points."""
    body = sphere(8, 8)
    c = np.array([1.0, -2.0, 3.0])
    for orders, bound in ((None, 6e-6), (replace(QuadratureOrders.fine(), far=6), 2e-9)):
        layer = matrix(body, orders=orders)
        exact = 2.0 / 3.0 * layer.surface.mass @ np.tile(c, (body.n_dofs, 1))
        found = (layer @ np.tile(c, body.n_dofs)).reshape(-1, 3)
        assert np.abs(found - exact).max() < bound * np.abs(exact).max()


@pytest.mark.parametrize(("n", "bound"), [(6, 1e-5), (8, 2e-6)])
def test_normal_is_in_the_kernel(n, bound):
    """V n = 0 up to the approximation of n; measured 6.0e-6, 1.0e-6."""
    body = sphere(n, n)
    layer = matrix(body)
    surface = layer.surface
    normal = spsolve(surface.mass.tocsc(), surface.constraint)
    constant = np.tile([1.0, 0.0, 0.0], body.n_dofs)
    assert np.linalg.norm(layer @ normal.ravel()) < bound * np.linalg.norm(layer @ constant)


def test_nearly_symmetric_but_not_symmetrised():
    """The asymmetry is the error of single entries, far above that of a traction."""
    layer = matrix(torus(8, 8)).dense()
    asymmetry = np.linalg.norm(layer - layer.T) / np.linalg.norm(layer)
    assert asymmetry == pytest.approx(2.4e-4, rel=0.2)


@pytest.mark.parametrize(
    "body", [sphere(4, 8), fitted(sphere(4, 8, degree=3, pole="merged")), torus(6, 8)]
)
def test_rotation_by_whole_elements(body):
    """Turning a body by the angle of one element changes nothing; measured 7e-16."""
    angle = 2 * np.pi / 8
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    first = matrix(body).dense()
    turned = matrix(body, body.coefficients @ turn.T).dense()
    n = body.n_dofs
    back = np.einsum("ji,ajbk,kl->aibl", turn, turned.reshape(n, 3, n, 3), turn, optimize=True)
    assert np.abs(back.reshape(3 * n, -1) - first).max() < 1e-12 * np.abs(first).max()


def test_symmetric_body_gives_a_symmetric_matrix():
    """Eight equal sectors of a torus: the matrix commutes with the turn; measured 6e-15."""
    n = 8
    body = torus(5, n)
    angle = -2 * np.pi / n  # t runs clockwise
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    A = matrix(body).dense().reshape(5, n, 3, 5, n, 3)
    moved = np.roll(A, (1, 1), axis=(1, 4))
    moved = np.einsum("ij,abjcdk,lk->abicdl", turn, moved, turn, optimize=True)
    assert np.abs(moved - A).max() < 1e-12 * np.abs(A).max()


def test_scaling():
    """The matrix scales with the cube of the length."""
    body = sphere(4, 5)
    small = matrix(body, 1e-3 * body.coefficients).dense()
    large = matrix(body).dense()
    np.testing.assert_allclose(1e9 * small, large, atol=1e-12 * np.abs(large).max())


def test_translation_invariance():
    body = torus(4, 5)
    moved = matrix(body, body.coefficients + np.array([3.0, -2.0, 1.0])).dense()
    first = matrix(body).dense()
    np.testing.assert_allclose(moved, first, atol=1e-11 * np.abs(first).max())


def test_separate_source_points():
    """Denser plain points change the matrix by the error of the far rule only."""
    body = torus(8, 8)
    first = matrix(body).dense()
    other = matrix(body, orders=QuadratureOrders(far=5)).dense()
    change = np.linalg.norm(other - first) / np.linalg.norm(first)
    assert 1e-9 < change < 2e-5


def test_thin_spheroid():
    """Finer rules change the matrix of a thin graded spheroid by little; measured 9e-6."""
    body = spheroid(8, 8, c=0.05, grading=0.85)
    first = matrix(body).dense()
    finer = matrix(body, orders=QuadratureOrders.fine()).dense()
    assert np.linalg.norm(finer - first) < 2e-5 * np.linalg.norm(finer)


def test_threads_do_not_change_the_result():
    numba = pytest.importorskip("numba")
    body = sphere(4, 5)
    threads = numba.get_num_threads()
    several = matrix(body).dense()
    try:
        numba.set_num_threads(1)
        one = matrix(body).dense()
    finally:
        numba.set_num_threads(threads)
    np.testing.assert_array_equal(one, several)


def test_wrong_arguments():
    body = sphere(4, 5)
    with pytest.raises(ValueError, match="expected coefficients"):
        matrix(body, np.zeros((3, 3)))
    with pytest.raises(ValueError, match="finite"):
        matrix(body, np.full_like(body.coefficients, np.nan))
    with pytest.raises(ValueError, match="orders"):
        QuadratureOrders(radial=40)
    orders = QuadratureOrders()
    assert sample(body, body.coefficients, orders).collapsed.sum() == 10


@pytest.mark.parametrize("body", [fitted(torus(4, 5)), sphere(4, 5)])
def test_direct_form_agrees_with_the_stored_matrix(body):
    """Same near field, same plain sums: equal to rounding, for one vector and several."""
    stored = single_layer(body, body.coefficients, storage="dense")
    direct = single_layer(body, body.coefficients, storage="direct")
    x = np.random.default_rng(2).standard_normal((stored.shape[0], 3))
    size = np.abs(stored @ x).max()
    assert np.abs(direct @ x - stored @ x).max() < 1e-13 * size
    assert np.abs(direct @ x[:, 1] - (stored @ x)[:, 1]).max() < 1e-13 * size
    np.testing.assert_array_equal(direct.dense(), stored.dense())
    assert np.abs(direct.T @ x - stored.dense().T @ x).max() < 1e-13 * size
    with pytest.raises(ValueError, match="complex densities"):
        _ = direct @ (1j * x)
    with pytest.raises(ValueError, match="storage"):
        single_layer(body, body.coefficients, storage="sparse")


def test_the_layer_itself_is_abstract():
    body = sphere(4, 5)
    layer = single_layer(body, body.coefficients)
    with pytest.raises(TypeError, match="abstract"):
        SingleLayer(layer.surface, layer.near)


def test_near_field_parts():
    """The sparse blocks as scipy matrix and as part of a dense block are the same numbers."""
    body = torus(4, 5)
    near = single_layer(body, body.coefficients).near
    x = np.random.default_rng(3).standard_normal((3 * body.n_dofs, 2))
    product = near.apply(x.reshape(-1, 3, 2)).reshape(x.shape)
    np.testing.assert_allclose(near.matrix() @ x, product, atol=1e-13 * np.abs(product).max())
    functions, block = np.array([3, 11, 4, 19, 0]), np.zeros((15, 15))
    add_block(functions, near.indptr, near.indices, near.data, False, block)
    at = vector_dofs(functions)
    np.testing.assert_array_equal(block, near.matrix().toarray()[np.ix_(at, at)])
