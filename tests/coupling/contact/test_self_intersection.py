"""Distances against sampling; motions into and through a contact against an oracle."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.sparse import identity

from coupling.contact.crossing import Crossing
from coupling.contact.sampled_mesh import SampledMesh
from coupling.contact.self_intersection import Collision
from coupling.contact.smallest_gap import facing_pairs, minimum_gap
from coupling.contact.triangle_distance import triangle_distances
from coupling.contact.watch import Watch
from coupling.exchange import Result

from .advancement import Advancement


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


def collision(points, triangles, inlet):
    mesh = SampledMesh(identity(len(points), format="csr"), triangles, np.arange(len(triangles)))
    return Collision(mesh, inlet, mesh.cells, 0.1)


def lowered(points, by):
    """The second sheet moved down."""
    upper = np.arange(len(points)) >= len(points) // 2
    return points - np.where(upper, by, 0.0)[:, None] * [0.0, 0.0, 1.0]


def test_motion_of_two_sheets():
    points, triangles, upper = sheets()
    test, touching = (collision(points, triangles, inlet) for inlet in (upper & ~upper, upper))
    through = lowered(points, 0.25)
    assert (
        test.inspect(points, points + np.array([3.0, -2.0, 5.0])) is None
    )  # rigid motions are free
    assert test.inspect(points, lowered(points, 0.075)) is None
    # the sheets lie apart before and after: only the path tells
    assert test.mesh.intersects(through) is False
    assert test.inspect(points, through) is Result.SELF_INTERSECTION
    assert touching.inspect(points, through) is Result.INLET_CONTACT
    assert 0.35 < test.mesh.free_step(points, through) < 0.4  # contact at 0.1 / 0.25
    # where contact carries: margins and the inlet are no matter, and for what a step reached
    # neither is the straight way
    crossing = Crossing(test.mesh)
    assert crossing.inspect(points, lowered(points, 0.0999)) is None
    assert crossing.inspect(points, through) is Result.SELF_INTERSECTION
    assert crossing.inspect(through, through) is None
    crossed = points.copy()
    crossed[10, 2] += 0.2
    assert crossing.inspect(crossed, crossed) is Result.SELF_INTERSECTION
    assert crossing.counts == {"tests": 4, "blocked": 2}
    assert test.counts == {"tests": 3, "blocked": 1}


def test_motions_against_conservative_advancement():
    """Nothing passes that the oracle does not certify; at most a third of a way is given away."""
    points, triangles, upper = sheets(6)
    oracle, mesh = Advancement(triangles, len(points)), collision(points, triangles, upper).mesh
    rng = np.random.default_rng(3)
    blocked = 0
    for _ in range(20):
        turn = 0.1 * rng.standard_normal((3, 3))
        way = np.where(np.arange(len(points)) < len(points) // 2, -1.0, 1.0)[:, None]
        end = points + way * (points @ turn + [0.0, 0.0, -0.1 * rng.random()])
        certified, free = oracle.fraction(points, end), mesh.free_step(points, end)
        blocked += free < 1.0
        assert 0.65 * certified < free < 1.05 * certified  # measured 0.70 to 1
        assert mesh.reaches(points, points + 0.65 * certified * (end - points))
        assert certified == 1.0 or not mesh.reaches(points, end)
    assert 10 < blocked < 20


def test_smooth_sheets_that_cross_between_triangles():
    """Arcs of radius 1 and 1.01 turned against each other: their chords miss, the arcs do not."""

    def arc(radius, shift, n):
        angle = np.linspace(0.0, 0.5, n)
        x, y = radius * np.sin(angle), np.linspace(0.0, 0.5, n)
        x, y = (v.ravel() for v in np.meshgrid(x, y, indexing="ij"))
        return np.stack([x, y, np.sqrt(radius**2 - x**2) + shift], axis=1)

    def tests(n, shift):
        _, triangles, upper = sheets(n)
        points = np.concatenate([arc(1.0, 0.0, n), arc(1.0, shift, n)])
        return points, collision(points, triangles, upper & ~upper)

    (coarse, rough), (fine, sharp) = tests(4, 2e-3), tests(13, 2e-3)
    assert rough.mesh.reaches(coarse, coarse)
    assert rough.inspect(coarse, coarse) is Result.SELF_INTERSECTION  # chords 3.5e-3 off
    assert sharp.inspect(fine, fine) is None  # 2.2e-4 off


def test_folded_sheet():
    points, triangles, upper = sheets()
    test = collision(points, triangles, upper & ~upper)
    folded = points.copy()
    folded[0] = [0.2, 0.1, 0.06]  # a corner turned over the edge between its neighbours
    assert test.inspect(points, folded) is Result.GEOMETRY


def test_gap_of_tilted_sheets():
    """Sheets that dip towards each other: the distance, not its part along the normals."""
    points, triangles, upper = sheets(9, 0.2)
    assert minimum_gap(points, triangles, 0.1) == pytest.approx(0.2, rel=1e-12)
    tilted = points.copy()
    half = np.arange(len(points)) >= len(points) // 2
    tilted[half, 2] -= 0.1 * tilted[half, 0]
    assert minimum_gap(tilted, triangles, 0.1) == pytest.approx(0.1 / np.hypot(1.0, 0.1), rel=1e-9)
    assert minimum_gap(points, triangles[~upper], 0.1) == np.inf


def test_when_a_test_is_due():
    watch = Watch(gap=2.0, volume=10.0)
    assert watch.reason(1.1, 10.0, 0.2) == ""
    assert "gap 0.9 is below half of its initial 2" in watch.reason(0.9, 10.0, 0.2)
    assert "volume 9.9 falls below" in watch.reason(1.1, 9.9, 0.2)
    assert "long against" in watch.reason(1.1, 10.0, 0.3)


def test_smallest_gap_leaves_no_pair_out():
    """Crumpled sheets: the smallest of all distances of facing pairs."""
    points, triangles, _ = sheets(9, 0.1)
    points = points + 0.02 * np.random.default_rng(0).standard_normal(points.shape)
    i, j = facing_pairs(points, triangles, 0.1).T
    every = triangle_distances(points[triangles[i]], points[triangles[j]])
    assert minimum_gap(points, triangles, 0.1) == pytest.approx(every.min(), rel=1e-10)
