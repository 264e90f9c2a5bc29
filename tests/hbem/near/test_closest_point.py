"""The certified search finds the closest point where Newton's method alone does not."""

import numpy as np

from hbem.near import _closest_point_kernels as kernels
from hbem.surfaces.bernstein import tensor_bernstein
from hbem.surfaces.subdivision import bounds

BOX = np.array([0.0, 1.0, 0.0, 1.0])


def trough(depth, cubic=0.0):
    """Bezier patch bent along s: a second, nearer foot point exists for points above it."""
    x = np.linspace(0.0, 1.0, 5)
    z = np.array([0.0, -depth, -depth - cubic, -depth, cubic])
    s, t = np.meshgrid(x, x, indexing="ij")
    return np.stack([s, t, np.broadcast_to(z[:, None], s.shape)], axis=2)


def both(control, x, start):
    """Distances that Newton and the search find from one start, and the best of a fine grid."""
    scratch, out, r, stack = np.empty(45), np.empty((6, 3)), np.empty(3), np.empty((64, 4))
    patch = (0.0,) * len(control), control
    s, t, newton, stationary = kernels.closest(*patch, x, BOX, *start, scratch, out, r)
    convexity, speeds, nets = bounds(control[None], BOX[None])
    sure = kernels.behind(nets[0], x, r, kernels.NEARER * kernels.dot(r, r))
    *_, found = kernels.search(
        *patch, x, BOX, speeds[0], convexity[0], 1e-6, s, t, newton, stationary, scratch, out, r,
        stack,
    )  # fmt: skip
    s, t = (g.ravel() for g in np.meshgrid(*2 * [np.linspace(0.0, 1.0, 401)]))
    points = tensor_bernstein(4, s, t) @ control.reshape(-1, 3)
    exact = np.linalg.norm(points - x, axis=1).min()
    assert not sure or newton * kernels.NEARER <= exact
    return newton, found, exact


def test_search_repairs_newton():
    rng = np.random.default_rng(3)
    failures = 0
    for _ in range(60):
        control = trough(rng.uniform(0.5, 3.0), rng.uniform(-0.5, 0.5))
        x = np.array([rng.uniform(0.1, 0.9), rng.uniform(0.0, 1.0), rng.uniform(-1.0, 0.5)])
        newton, found, exact = both(control, x, (rng.choice([0.05, 0.95]), 0.5))
        failures += newton * kernels.NEARER > exact
        assert found * kernels.NEARER <= exact
        assert found <= newton * (1 + 1e-12)
    assert failures >= 10  # Newton alone misses


def test_search_leaves_convex_patches_alone():
    control = trough(0.05)
    newton, found, exact = both(control, np.array([0.4, 0.3, 0.1]), (0.5, 0.5))
    assert found == newton
    np.testing.assert_allclose(found, exact, rtol=1e-2)
