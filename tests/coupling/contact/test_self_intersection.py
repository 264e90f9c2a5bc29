"""Distances against sampling; a motion is never certified across a contact."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.sparse import identity

from coupling.contact.self_intersection import Collision
from coupling.contact.triangle_distance import triangle_distances
from coupling.exchange import Result


def test_triangle_distances_against_quadratic_programs():
    rng = np.random.default_rng(1)
    a, b = rng.random((30, 3, 3)), rng.random((30, 3, 3)) + np.array([0.9, 0.4, 0.2])
    found = triangle_distances(a, b)
    bounds = [(0.0, 1.0)] * 4
    inside = [{"type": "ineq", "fun": lambda z, k=k: 1.0 - z[k] - z[k + 1]} for k in (0, 2)]
    for p, q, d in zip(a, b, found, strict=True):

        def square(z, p=p, q=q):
            x = p[0] + z[0] * (p[1] - p[0]) + z[1] * (p[2] - p[0])
            y = q[0] + z[2] * (q[1] - q[0]) + z[3] * (q[2] - q[0])
            return float((x - y) @ (x - y))

        best = minimize(square, 0.25 * np.ones(4), bounds=bounds, constraints=inside, tol=1e-14)
        if best.fun > 1e-3:  # apart: the candidates are exact
            assert d == pytest.approx(np.sqrt(best.fun), rel=1e-5)


def sheets(n=8, gap=0.1):
    """Two square sheets, facing; the second is marked as inlet where asked."""
    g = np.linspace(0.0, 1.0, n)
    x, y = (v.ravel() for v in np.meshgrid(g, g, indexing="ij"))
    low = np.stack([x, y, np.zeros_like(x)], axis=1)
    i, j = (v.ravel() for v in np.meshgrid(range(n - 1), range(n - 1), indexing="ij"))
    a, b, c, d = i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1
    cell = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    points = np.concatenate([low, low + np.array([0.03, 0.02, gap])])
    return (
        points,
        np.concatenate([cell, cell[:, ::-1] + n * n]),
        np.arange(2 * len(cell)) >= len(cell),
    )


@pytest.fixture(scope="module", params=["bound", "ipctk"])
def engine(request):
    return request.param


def test_motion_of_two_sheets(engine):
    points, triangles, upper = sheets()
    test = Collision(identity(len(points), format="csr"), triangles, 0 * upper > 0, engine)
    touching = Collision(test.sample, triangles, upper, engine)
    lowered = points + np.where(np.arange(len(points)) >= len(points) // 2, 1.0, 0.0)[:, None] * [
        0.0, 0.0, -0.25]  # fmt: skip
    assert (
        test.inspect(points, points + np.array([3.0, -2.0, 5.0])) is None
    )  # rigid motions are free
    assert test.inspect(points, points + 0.3 * (lowered - points)) is None
    # the sheets lie apart before and after: only the path tells
    assert test.inspect(points, lowered) is Result.SELF_INTERSECTION
    assert touching.inspect(points, lowered) is Result.INLET_CONTACT
    fraction = test.motion(points, lowered).fraction
    assert 0.35 < fraction < 0.4  # contact at 0.1 / 0.25


def test_folded_sheet():
    points, triangles, upper = sheets()
    test = Collision(identity(len(points), format="csr"), triangles, upper)
    folded = points.copy()
    folded[0] = [0.5, 0.5, 0.01]  # a corner turned over its neighbours
    assert test.inspect(points, folded) is Result.GEOMETRY
