"""Planar Stokes operators: constants, normals, an exact flow, closed forms of self integrals."""

from __future__ import annotations

import numpy as np
import pytest

from hbem.planar.polygon_stokes import PolygonStokes


def square(n: int) -> np.ndarray:
    s = np.arange(n) / n
    zero, one = np.zeros(n), np.ones(n)
    sides = [(s, zero), (one, s), (1 - s, one), (zero, 1 - s)]
    return np.concatenate([np.stack(side, axis=1) for side in sides])


def normals(body: PolygonStokes) -> np.ndarray:
    t = (np.roll(body.vertices, -1, axis=0) - body.vertices) / body.lengths[:, None]
    return np.repeat(np.stack([t[:, 1], -t[:, 0]], axis=1), 2, axis=0).ravel()


def test_constants_and_normals_are_in_the_kernels():
    body = PolygonStokes(square(6))
    constant = np.tile([0.7, -0.3], 24)
    # the outer rule's error: 7e-6 measured
    assert np.abs(body.double @ constant).max() < 2e-5 * np.abs(body.double).max()
    assert np.abs(body.single @ normals(body)).max() < 2e-5 * np.abs(body.single).max()
    assert body.single == pytest.approx(body.single.T, abs=1e-6)
    # off the boundary the closed forms are exact
    single, double = body.evaluate(np.array([[0.5, 0.5], [0.2, 0.01]]))
    assert double @ constant == pytest.approx(np.tile(constant[:2], 2), abs=1e-13)
    assert single @ normals(body) == pytest.approx(0.0, abs=1e-13)


def test_self_integral_is_the_closed_form():
    a = 0.5
    body = PolygonStokes(np.array([[0, 0], [a, 0], [a, a], [0, a]]), scale=1.0)
    block = body.single[:4, :4].reshape(2, 2, 2, 2)
    for m in range(2):
        for n in range(2):
            shared = 6 + (-1) ** (m + n) - 4 * np.log(a)
            exact = (a / 8) ** 2 / np.pi * (shared * np.eye(2) + 4 * np.diag([1.0, 0.0]))
            assert block[m, :, n] == pytest.approx(exact, abs=1e-7)


def test_channel_flow_converges():
    """u = (y (1 - y), 0), p = -2 x inside a square."""
    errors, tractions = [], []
    for n in (8, 16):
        body = PolygonStokes(square(n))
        x, y = body.vertices.T
        u = np.stack([y * (1 - y), 0 * x], axis=1).ravel()
        normal = normals(body)
        bordered = np.block([[body.single, normal[:, None]], [normal[None], np.zeros((1, 1))]])
        t = np.linalg.solve(bordered, np.r_[body.double @ u, 0.0])[:-1]
        points = np.array([[0.5, 0.5], [0.3, 0.2], [0.1, 0.98]])
        single, double = body.evaluate(points)
        found = (single @ t + double @ u).reshape(-1, 2)
        exact = np.stack([points[:, 1] * (1 - points[:, 1]), np.zeros(3)], axis=1)
        errors.append(np.abs(found - exact).max())
        tractions.append(t)
    assert errors[1] < errors[0] / 3.5
    # shear on the lower wall, away from the corners
    n = 16
    assert tractions[1].reshape(-1, 2, 2)[n // 2, 0, 0] == pytest.approx(-1.0, abs=0.03)
