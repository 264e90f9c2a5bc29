"""The contact potential: derivatives, momentum, pressure, against brute force."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix, identity

from coupling import BarrierContact, SampledMesh
from coupling.contact.potential.barrier import barrier
from coupling.contact.potential.facing_search import OPPOSING, FacingSearch

GAP, REACH = 0.05, 0.2


def sheet(n, height, up, warp=0.0):
    """A warped square sheet of triangles whose outward normal points up or down."""
    g = np.linspace(0.0, 1.0, n)
    x, y = (v.ravel() for v in np.meshgrid(g, g, indexing="ij"))
    i, j = (v.ravel() for v in np.meshgrid(range(n - 1), range(n - 1), indexing="ij"))
    a, b, c, d = i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1
    cells = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return np.stack([x, y, height + warp * np.sin(5 * x + 3 * y)], axis=1), (
        cells if up else cells[:, ::-1]
    )


def facing_sheets(outer=True, shake=0.02, n=8):
    """Two sheets GAP apart, seen from between (outer) or from beyond them (inner)."""
    (low, a), (high, b) = sheet(n, 0.0, outer, 0.03), sheet(n + 1, GAP, not outer, 0.03)
    points = np.concatenate([low, high])
    points += shake * GAP * np.random.default_rng(2).standard_normal(points.shape)
    mesh = SampledMesh(
        identity(len(points), format="csr"), np.concatenate([a, b + len(low)]), np.arange(0)
    )
    return BarrierContact(mesh, mesh.areas(points), REACH, 3.0), points


def test_barrier_and_its_continuation():
    s = np.array([0.05, 0.1, 0.2, 0.3, 0.5, 0.8, 1.0, 1.5])
    for floor in (0.0, 0.25):
        value, slope, bend = barrier(s, floor)
        h = 1e-6
        (low, low1, _), (high, high1, _) = barrier(s - h, floor), barrier(s + h, floor)
        assert slope == pytest.approx((high - low) / (2 * h), rel=1e-6, abs=1e-9)
        assert bend == pytest.approx((high1 - low1) / (2 * h), rel=1e-6, abs=1e-5)
        assert list(value[-2:]) == list(slope[-2:]) == list(bend[-2:]) == [0.0, 0.0]
    table = -barrier(s[[5, 4, 3, 2, 1, 0]])[1]
    assert table == pytest.approx([0.14, 1.19, 3.3, 5.8, 12.0, 24.0], rel=0.03)
    deep = barrier(np.array([-1.0, 0.0]), 0.1)
    assert np.isfinite(deep).all()
    assert deep[0][0] > deep[0][1]


@pytest.mark.parametrize("outer", [True, False])
def test_derivatives_and_momentum(outer):
    contact, c = facing_sheets(outer)
    assert contact.state(c).facing.outer.all() == outer
    step = np.random.default_rng(5).standard_normal(c.shape)
    gradient, tangent = contact.derivatives(c)
    h = 1e-7
    slope = (contact.energy(c + h * step) - contact.energy(c - h * step)) / (2 * h)
    assert gradient @ step.ravel() == pytest.approx(slope, rel=1e-7)
    change = (contact.derivatives(c + h * step)[0] - contact.derivatives(c - h * step)[0]) / (2 * h)
    exact = contact.state(c).tangent(projected=False)
    assert exact @ step.ravel() == pytest.approx(change, abs=1e-6 * np.abs(change).max())
    values = np.linalg.eigvalsh(tangent.toarray())
    assert values[0] > -1e-12 * values[-1]
    assert np.linalg.eigvalsh(exact.toarray())[0] < -1e-3 * values[-1]  # the projection acts
    forces = -gradient.reshape(-1, 3)
    size = np.abs(forces).sum()
    assert np.abs(contact.force(c)).max() < 1e-14 * size
    assert np.abs(np.cross(c, forces).sum(axis=0)).max() < 1e-14 * size


def test_tangent_through_a_sampling_matrix():
    contact, c = facing_sheets()
    rng, n = np.random.default_rng(1), 30
    weights = rng.random((len(c), n)) * (rng.random((len(c), n)) < 0.2) + 1e-3 * np.eye(len(c), n)
    mesh = SampledMesh(csr_matrix(weights), contact.mesh.triangles, contact.mesh.cells)
    coarse = np.linalg.lstsq(weights, c, rcond=None)[0]
    sampled = BarrierContact(mesh, contact.areas, 2.0, 1.0)
    points = BarrierContact(contact.mesh, contact.areas, 2.0, 1.0)
    S = np.kron(weights, np.eye(3))
    (g, K), (gp, Kp) = sampled.derivatives(coarse), points.derivatives(weights @ coarse)
    assert np.abs(gp).max() > 0.0
    assert g == pytest.approx(S.T @ gp, abs=1e-12 * np.abs(g).max())
    full = S.T @ Kp.toarray() @ S
    assert K.toarray() == pytest.approx(full, abs=1e-12 * np.abs(full).max())


def brute(points, triangles, reach):
    """Nearest opposing triangle on each side, by dense sampling of the definition."""
    from coupling.contact.smallest_gap import unit_normals

    normals = unit_normals(points[triangles])
    corners = points[triangles]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    nodes = np.zeros_like(points)
    np.add.at(nodes, triangles.ravel(), np.repeat(area, 3, axis=0))
    nodes /= np.linalg.norm(nodes, axis=1, keepdims=True)
    found = {}
    for i, p in enumerate(points):
        for t, corner in enumerate(corners):
            if i in triangles[t] or nodes[i] @ normals[t] >= OPPOSING:
                continue
            y = nearest(p, corner)
            r = p - y
            own, other = r @ nodes[i], r @ normals[t]
            if own * other < 0.0 and (d := np.linalg.norm(r)) < reach:
                key = i, own < 0.0
                found[key] = min(found.get(key, np.inf), d)
    return found


def nearest(p, corner):
    """Closest point of a triangle: inside by least squares, else on an edge by clipping."""
    a, e = corner[0], (corner[1:] - corner[0]).T
    inner = np.linalg.lstsq(e, p - a, rcond=None)[0]
    if inner.min() >= 0.0 and inner.sum() <= 1.0:
        return a + e @ inner
    trials = []
    for q, w in zip(corner, np.roll(corner, -1, axis=0), strict=True):
        trials.append(q + np.clip((p - q) @ (w - q) / ((w - q) @ (w - q)), 0, 1) * (w - q))
    return min(trials, key=lambda y: np.linalg.norm(y - p))


def test_closest_features_against_brute_force():
    for outer in (True, False):
        contact, c = facing_sheets(outer, shake=0.3, n=6)
        c[:20, :2] *= 1.3  # part of it hangs over the other sheet's edge
        facing = contact.state(c).facing
        found = dict(
            zip(zip(facing.vertices[:, 0], facing.outer, strict=True), facing.distance, strict=True)
        )
        right = brute(c, contact.mesh.triangles, REACH)
        assert found.keys() == right.keys()
        assert len(right) > 60
        assert [found[k] for k in right] == pytest.approx(list(right.values()), rel=1e-12)


def test_candidates_serve_until_samples_move():
    contact, c = facing_sheets()
    triangles = contact.mesh.triangles
    kept = FacingSearch(triangles, REACH)
    rng = np.random.default_rng(3)
    for size, builds in ((0.0, 1), (0.1 * REACH, 1), (2.0 * REACH, 2)):
        moved = c + np.array([5.0, 0.0, 1.0]) * size  # a common translation counts for nothing
        moved[:10] += size * rng.uniform(-0.5, 0.5, (10, 3))
        new, fresh = kept.facing(moved), FacingSearch(triangles, REACH, slack=0.0).facing(moved)
        assert kept.builds == builds
        assert np.array_equal(new.vertices, fresh.vertices)
        assert np.array_equal(new.distance, fresh.distance)


def test_steps_stop_before_contact():
    contact, c = facing_sheets(shake=0.0)
    upper = np.arange(len(c))[:, None] >= 64
    through = c - upper * [0.0, 0.0, 3.0 * GAP]
    step = contact.free_step(c, through)
    assert 0.2 < step < 1.0 / 3.0  # ipctk and we keep a tenth each
    assert contact.free_step(c, c - upper * [0.0, 0.0, 0.5 * GAP]) == 1.0
    near = contact.distance(c + step * (through - c))
    assert 0.0 < near < 0.5 * GAP
    assert contact.energy(c + step * (through - c)) > contact.energy(c)
    apart = c + upper * [0.0, 0.0, 2.0 * REACH]
    assert contact.distance(apart) == np.inf
    assert contact.energy(apart) == 0.0
    assert contact.derivatives(apart)[1].nnz == 0


def test_surfaces_of_quadrilaterals_and_of_triangles_side_by_side():
    """The same sheets as cells, as triangles and as two surfaces: one energy, one matrix."""
    contact, c = facing_sheets(shake=0.0)
    triangles, half = contact.mesh.triangles, 64
    doubled = np.concatenate([np.arange(len(c)), np.arange(10)])  # some samples twice
    sampling = identity(len(c), format="csr")[doubled]
    again = triangles.copy()
    again[:40][again[:40] < 10] += len(c)  # these triangles see the other one of the two
    empty = np.array([[0, len(c), 3]])  # between two samples that are one vertex
    whole = SampledMesh.of_triangles(sampling, np.concatenate([again, empty]), c)
    assert len(whole.triangles) == len(triangles)
    low = triangles.max(axis=1) < half
    parts = [
        SampledMesh.of_triangles(identity(n, format="csr"), t, points)
        for n, t, points in (
            (half, triangles[low], c[:half]),
            (len(c) - half, triangles[~low] - half, c[half:]),
        )
    ]
    i, j = (v.ravel() for v in np.meshgrid(range(7), range(7), indexing="ij"))
    cells = np.stack([i * 8 + j, (i + 1) * 8 + j, (i + 1) * 8 + j + 1, i * 8 + j + 1], axis=1)
    parts.append(SampledMesh.of(identity(half, format="csr"), cells, c[:half]))
    assert parts[2].areas(c[:half]).sum() == pytest.approx(parts[0].areas(c[:half]).sum(), rel=0.01)
    union = SampledMesh.union(parts[:2])
    right = contact.derivatives(c)
    for mesh in (whole, union):
        other = BarrierContact(mesh, mesh.areas(c), REACH, 3.0)
        assert other.energy(c) == pytest.approx(contact.energy(c), rel=1e-13)
        gradient, tangent = other.derivatives(c)
        assert gradient == pytest.approx(right[0], abs=1e-13 * np.abs(right[0]).max())
        assert np.abs((tangent - right[1]).toarray()).max() < 1e-12 * np.abs(right[1]).max()
    with pytest.raises(ValueError, match="area for each of"):
        BarrierContact(union, np.ones(3), REACH, 3.0)
    with pytest.raises(ValueError, match="positive reach"):
        BarrierContact(union, union.areas(c), 0.0, 3.0)
    assert contact.energy(np.nan * c) == np.inf
