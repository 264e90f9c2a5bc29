"""Rigid obstacles: their distances, forces where they enter the sheet, and motion."""

from itertools import product

import numpy as np
import pytest
from scipy.sparse import identity

from coupling import (
    BarrierContact,
    BoxObstacle,
    CylinderObstacle,
    PlaneObstacle,
    SampledMesh,
)

TURN = np.linalg.qr(np.random.default_rng(7).standard_normal((3, 3)))[0]
OBSTACLES = (
    PlaneObstacle([0.1, 0.2, 0.3], [1.0, 2.0, -2.0]),
    CylinderObstacle([0.1, 0.0, -0.2], [1.0, 1.0, 0.5], 0.4),
    BoxObstacle([0.2, 0.1, 0.0], [0.5, 0.3, 0.4], TURN),
)


@pytest.mark.parametrize("obstacle", OBSTACLES)
def test_distances_are_those_of_convex_bodies(obstacle):
    """Gradients of length 1 by differences, and no chord lies below the graph."""
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-1.0, 1.0, (2, 400, 3))
    (d, normal), (e, _) = obstacle.distance(x, 0.0), obstacle.distance(y, 0.0)
    assert d.min() < -0.1
    assert d.max() > 0.3
    assert np.linalg.norm(normal, axis=1) == pytest.approx(np.ones(400))
    step = 1e-6 * rng.standard_normal((400, 3))
    change = obstacle.distance(x + step, 0.0)[0] - obstacle.distance(x - step, 0.0)[0]
    assert change == pytest.approx(2.0 * np.einsum("ij,ij->i", normal, step), abs=1e-11)
    middle = obstacle.distance(0.5 * (x + y), 0.0)[0]
    assert (middle <= 0.5 * (d + e) + 1e-12).all()
    moved = type(obstacle)(**{**vars(obstacle), "motion": lambda t: [t, 0.0, 2.0 * t]})
    assert moved.distance(x + np.array([3.0, 0.0, 6.0]), 3.0)[0] == pytest.approx(d)


def test_box_distance_by_its_corners():
    box = BoxObstacle([1.0, 2.0, 3.0], [0.5, 1.0, 1.5])
    for sign in product((-1.0, 1.0), repeat=3):
        corner = np.array([1.0, 2.0, 3.0]) + np.array(sign) * [0.5, 1.0, 1.5]
        out = corner + np.array(sign) * 0.3
        assert box.distance(out[None], 0.0)[0] == pytest.approx([0.3 * np.sqrt(3.0)])
    inside, normal = box.distance(np.array([[1.4, 2.0, 3.0]]), 0.0)
    assert inside == pytest.approx([-0.1])
    assert normal[0].tolist() == [1.0, 0.0, 0.0]
    with pytest.raises(ValueError, match="orthonormal"):
        BoxObstacle([0, 0, 0], [1, 1, 1], 2.0 * np.eye(3))
    with pytest.raises(ValueError, match="direction"):
        PlaneObstacle([0, 0, 0], [0, 0, 0]).distance(np.zeros((1, 3)), 0.0)


def cloud(obstacle):
    """Loose samples in and around an obstacle."""
    rng = np.random.default_rng(4)
    mesh = SampledMesh(identity(60, format="csr"), np.empty((0, 3), int), np.arange(0))
    contact = BarrierContact(mesh, rng.uniform(0.5, 1.0, 60), 0.5, 2.0, (obstacle,))
    return contact, rng.uniform(-0.8, 0.8, (60, 3))


@pytest.mark.parametrize("obstacle", OBSTACLES)
def test_forces_and_tangents_also_inside(obstacle):
    contact, c = cloud(obstacle)
    assert contact.distance(c) < -0.1
    gradient, tangent = contact.derivatives(c)
    direction = np.random.default_rng(2).standard_normal(c.shape)
    h = 1e-6
    slope = (contact.energy(c + h * direction) - contact.energy(c - h * direction)) / (2 * h)
    assert gradient @ direction.ravel() == pytest.approx(slope, rel=1e-7)
    force = -gradient.reshape(-1, 3)
    assert contact.reactions(c)[0] == pytest.approx(-force.sum(axis=0))
    assert contact.force(c) == pytest.approx(force.sum(axis=0))
    pressed = (contact.areas * contact.pressure(c)).sum()
    assert np.linalg.norm(force, axis=1).sum() == pytest.approx(pressed)
    # the tangent is the second derivative with its negative part cut off, sample by sample
    for i in range(0, 60, 7):
        exact = np.zeros((3, 3))
        for k in range(3):
            e = np.zeros_like(c)
            e[i, k] = h
            change = contact.derivatives(c + e)[0] - contact.derivatives(c - e)[0]
            exact[:, k] = change[3 * i : 3 * i + 3] / (2 * h)
        values, vectors = np.linalg.eigh(0.5 * (exact + exact.T))
        cut = vectors * np.maximum(values, 0.0) @ vectors.T
        found = tangent[3 * i : 3 * i + 3, 3 * i : 3 * i + 3].toarray()
        assert found == pytest.approx(cut, abs=2e-6 * max(1.0, np.abs(exact).max()))


def test_a_plane_that_enters_the_sheet_is_left_again():
    """Newton from a start inside of the plane comes to rest at the pressure that presses it."""
    motion = lambda t: [0.0, 0.0, t]  # noqa: E731
    plane = PlaneObstacle([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], motion)
    mesh = SampledMesh(identity(3, format="csr"), np.array([[0, 1, 2]]), np.arange(1))
    rest = np.array([[0.0, 0.0, 0.05], [1.0, 0.0, 0.05], [0.0, 1.0, 0.05]])
    areas = mesh.areas(rest)
    assert areas.sum() == pytest.approx(0.5)
    contact = BarrierContact(mesh, areas, 0.1, 1.0, (plane,))
    assert contact.at(0.0).energy(rest) > 0.0
    assert contact.at(-1.0).energy(rest) == 0.0
    later = contact.at(0.3)
    assert later.distance(rest) == pytest.approx(-0.25)
    assert later.within_reach(rest) == 3
    c, weight = rest.copy(), 12.0  # the pressure at a tenth of the reach: where beta is continued
    for _ in range(30):
        gradient, tangent = later.derivatives(c)
        z = slice(2, None, 3)
        down = gradient[z] + weight * areas
        c[:, 2] -= np.linalg.solve(tangent.toarray()[z, z], down)
    assert later.pressure(c) == pytest.approx(3 * [weight])
    assert later.reactions(c)[0] == pytest.approx([0.0, 0.0, -weight * 0.5])
    assert 0.009 < later.distance(c) < 0.0105
