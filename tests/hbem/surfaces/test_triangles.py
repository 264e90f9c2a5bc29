"""Triangulated bodies through the same interface; a triangle is a contracted square."""

from itertools import permutations
from math import factorial

import numpy as np
import pytest
from scipy.sparse import csr_matrix, identity

from hbem.layers.single_layer import single_layer
from hbem.solvers.saddle import DenseSaddle
from hbem.surfaces.bernstein import tensor_bernstein
from hbem.surfaces.patches import BezierPatches
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.topology import closed_components
from hbem.surfaces.triangles import collapse_table, quadrilaterals, triangle_index


def functions(degree, u, v, w):
    """Bernstein functions of a triangle, ``(n, n_functions)``."""
    return np.stack(
        [
            factorial(degree) / (factorial(a) * factorial(b) * factorial(c)) * u**a * v**b * w**c
            for a, b, c in triangle_index(degree)
        ],
        axis=1,
    )


def icosphere():
    """Icosahedron, each face quartered: 80 triangles with outward normals."""
    phi = 0.5 * (1 + np.sqrt(5))
    x = np.array([(0, a, b * phi) for a in (-1, 1) for b in (-1, 1)], float)
    x = np.vstack([np.roll(x, k, axis=1) for k in range(3)])
    x /= np.linalg.norm(x[0])
    near = np.linalg.norm(x[:, None] - x, axis=2).round(3) < 1.1
    faces = [f for f in permutations(range(12), 3) if f[0] < min(f[1:])]
    faces = [f for f in faces if near[f[0], f[1]] and near[f[1], f[2]] and near[f[0], f[2]]]
    corners = np.array([x[list(f)] for f in faces if np.linalg.det(x[list(f)]) > 0])
    a, b, c = np.swapaxes(corners, 0, 1)
    ab, bc, ca = a + b, b + c, c + a
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    corners = np.concatenate([np.stack(p, axis=1) for p in parts])
    return corners / np.linalg.norm(corners, axis=2, keepdims=True)


def triangulated_sphere(degree):
    """Continuous Bezier triangles that interpolate the sphere; density of the same degree."""
    corners = icosphere()
    at = triangle_index(degree) / degree
    x = at @ corners
    x /= np.linalg.norm(x, axis=2, keepdims=True)
    inverse = np.linalg.inv(functions(degree, *at.T))
    control = inverse @ x
    flat = control.reshape(-1, 3)
    _, first, dofs = np.unique(flat.round(7), axis=0, return_index=True, return_inverse=True)
    n, m = len(corners), at.shape[0]
    return BezierPatches(
        n_dofs=first.size,
        geometry_degree=degree,
        density_degree=degree,
        indptr=m * np.arange(n + 1),
        dofs=dofs.ravel(),
        extraction=np.tile(np.eye(m), (n, 1)),
        bezier=csr_matrix(identity(first.size).tocsr()[dofs.ravel()]),
        coefficients=flat[first],
        shape="triangle",
    )


@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("vertex", [0, 1, 2])
def test_contracted_square_is_the_triangle(degree, vertex):
    s, t = np.random.default_rng(1).random((2, 20))
    uvw = np.roll(np.stack([1 - s, s * (1 - t), s * t]), vertex, axis=0)
    values = tensor_bernstein(degree, s, t) @ collapse_table(degree, vertex)
    np.testing.assert_allclose(values, functions(degree, *uvw), atol=1e-14)


@pytest.mark.parametrize("degree", [2, 3])
def test_translating_sphere(degree):
    """Drag 6 pi, uniform traction 1.5 U: measured 7e-4 and 2e-4, at most 0.011 and 0.023 off."""
    body = triangulated_sphere(degree)
    assert np.all(closed_components(body, body.coefficients) == 0)
    layer = single_layer(body, body.coefficients, QuadratureOrders(), storage="dense")
    surface = layer.surface
    u = np.tile([0.0, 0.0, 1.0], (surface.outer.points.shape[0], 1))
    solved = DenseSaddle(layer, surface.constraint, surface.mass).solve(surface.project(u).ravel())
    tau = surface.basis @ solved.solution.reshape(-1, 3)
    drag = surface.outer.weights @ tau
    error = np.abs(tau - np.array([0.0, 0.0, 1.5])).max()
    assert abs(drag[2] / (6 * np.pi) - 1) < 1e-3
    assert error < 0.1


def test_wrong_tables_are_named():
    body = triangulated_sphere(1)
    with pytest.raises(ValueError, match="triangular"):
        quadrilaterals(quadrilaterals(body))
