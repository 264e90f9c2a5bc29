"""Polygons around parts of a mesh, and what quadratic elements give on them.

Each edge becomes some segments with continuous linear velocities and discontinuous linear
tractions. Where parts touch in a point the polygon stays with one part.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.spatial import cKDTree
from skfem import Mesh

from ..navier_stokes.spaces import FlowSpace


def boundary_loops(mesh: Mesh, part: np.ndarray) -> list[np.ndarray]:
    """Closed loops of vertices around a part, the part on their left."""
    start, end = _oriented_edges(mesh, part)
    leaving: dict[int, list[int]] = {}
    for e, v in enumerate(start):
        leaving.setdefault(int(v), []).append(e)
    loops, left = [], set(range(start.size))
    while left:
        edge = min(left)
        loop = []
        while edge in left:
            left.remove(edge)
            loop.append(int(start[edge]))
            choices = [e for e in leaving[int(end[edge])] if e in left]
            if not choices:
                break
            # where pieces touch in a point, stay with the one on the left
            edge = max(choices, key=lambda e: _turn(mesh.p, start, end, edge, e))
        loops.append(np.array(loop))
    return loops


def _oriented_edges(mesh: Mesh, part: np.ndarray) -> tuple[np.ndarray, ...]:
    t = mesh.t
    inside = np.flatnonzero(part)
    a = t[:, inside].T
    corners = mesh.p[:, a]
    x, y = corners
    area = (x * np.roll(y, -1, 1) - np.roll(x, -1, 1) * y).sum(axis=1)
    a[area < 0] = a[area < 0, ::-1]
    start, end = a.ravel(), np.roll(a, -1, axis=1).ravel()
    n = mesh.p.shape[1]
    outer = ~np.isin(start * n + end, end * n + start)
    return start[outer], end[outer]


def _turn(p: np.ndarray, start: np.ndarray, end: np.ndarray, a: int, b: int) -> float:
    """Angle to the left from edge a to edge b."""
    u, v = p[:, end[a]] - p[:, start[a]], p[:, end[b]] - p[:, start[b]]
    return float(np.arctan2(u[0] * v[1] - u[1] * v[0], u @ v))


def edge_unknowns(space: FlowSpace, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar unknowns of edges: start, middle, end, ``(n_edges, 3)``."""
    points = np.stack([a, 0.5 * (a + b), b], axis=1).reshape(-1, 2)
    distance, index = cKDTree(space.velocity.doflocs.T).query(points)
    if distance.max() > 1e-9:
        raise ValueError("an edge has no unknown in its middle: boundary coupling needs degree 2")
    return index.reshape(-1, 3)


def _quadratics(s: np.ndarray) -> np.ndarray:
    """Shape functions of start, middle and end at ``s`` in [0, 1], ``(3, ...)``."""
    return np.stack([(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)])


def trace(space: FlowSpace, dofs: np.ndarray, s: np.ndarray) -> csr_array:
    """Field to polygon velocities ``(2 m, n)``."""
    m = dofs.shape[0] * s.size
    node = np.arange(m).reshape(-1, s.size)
    value = np.broadcast_to(_quadratics(s)[:, None], (3, *node.shape))
    row = np.broadcast_to(node, value.shape)
    column = np.broadcast_to(dofs.T[:, :, None], value.shape)
    parts = [
        (value.ravel(), 2 * row.ravel() + i, column.ravel() + i * space.n_velocity)
        for i in range(2)
    ]
    data, rows, columns = (np.concatenate([p[k] for p in parts]) for k in range(3))
    return csr_array((data, (rows, columns)), shape=(2 * m, space.n))


def tractions(space: FlowSpace, dofs: np.ndarray, length: np.ndarray, segments: int) -> csr_array:
    """``int phi_i t`` over edges for tractions ordered by segment, end, component."""
    x, w = np.polynomial.legendre.leggauss(3)
    x, w = 0.5 * (x + 1.0), 0.5 * w / segments
    ends = np.stack([1.0 - x, x])
    edges = dofs.shape[0]
    entries = []
    for k in range(segments):
        local = np.einsum("q,iq,lq->il", w, _quadratics((k + x) / segments), ends)
        for i in range(3):
            for end in range(2):
                segment = np.arange(edges) * segments + k
                for c in range(2):
                    column = 4 * segment + 2 * end + c
                    entries.append(
                        (local[i, end] * length, dofs[:, i] + c * space.n_velocity, column)
                    )
    data, rows, columns = (np.concatenate([e[k] for e in entries]) for k in range(3))
    shape = (space.n, 4 * edges * segments)
    return csr_array(coo_array((data, (rows, columns)), shape=shape))
