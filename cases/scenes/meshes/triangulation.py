"""Better triangles on the same points: edges flipped as long as their smallest angle grows."""

from __future__ import annotations

import numpy as np

from ...geometry.meshes.flat_triangles import facet_normals, smallest_angles

PASSES = 50


def flipped(points: np.ndarray, triangles: np.ndarray, curve: np.ndarray) -> np.ndarray:
    """Flip edges whose two triangles have a larger smallest angle with the other diagonal.

    Parameters
    ----------
    points : (n, 3) array
    triangles : (m, 3) int array
        Closed and oriented.
    curve : (n,) int array
        Edges between two points of one curve stay; negative for points on none.
    """
    t = triangles.copy()
    for _ in range(PASSES):
        changed = False
        edges = {(int(u[k]), int(u[k - 2])): i for i, u in enumerate(t) for k in range(3)}
        for (a, b), i in list(edges.items()):
            j = edges.get((b, a))
            if a > b or j is None or 0 <= curve[a] == curve[b] or (a, b) not in edges:
                continue
            if edges[a, b] != i or not _has(t[i], a, b) or not _has(t[j], b, a):
                continue
            c, d = int(t[i][(t[i] != a) & (t[i] != b)][0]), int(t[j][(t[j] != a) & (t[j] != b)][0])
            if (c, d) in edges or (d, c) in edges:
                continue
            now = smallest_angles(points, np.array([[a, b, c], [b, a, d]])).min()
            other = np.array([[a, d, c], [d, b, c]])
            if smallest_angles(points, other).min() > now + 1e-6 and _flat(points, a, b, c, d):
                t[i], t[j] = other
                edges = {(int(u[k]), int(u[k - 2])): n for n, u in enumerate(t) for k in range(3)}
                changed = True
        if not changed:
            return t
    return t


def _has(triangle: np.ndarray, a: int, b: int) -> bool:
    k = np.flatnonzero(triangle == a)
    return bool(k.size) and int(triangle[(k[0] + 1) % 3]) == b


def _flat(points: np.ndarray, a: int, b: int, c: int, d: int) -> bool:
    """Whether all four triangles of a quadrilateral face about the same way."""
    normals = facet_normals(points, np.array([[a, b, c], [b, a, d], [a, d, c], [d, b, c]]))
    return bool((normals @ normals.T).min() > 0.5)
