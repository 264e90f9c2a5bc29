"""Nodes of Lagrange triangles in their usual order: vertices, edges, then the same inside.

Files (VTK) hold curved triangles so.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from ..local_elements import lattice, triangle_exponents


@cache
def lagrange_order(order: int) -> np.ndarray:
    """Point of ``lattice("triangle", order)`` at each node, ``(n,)``."""
    place = {tuple(e): k for k, e in enumerate(triangle_exponents(order).tolist())}
    return np.array([place[e] for e in _nested(order, 0)])


def _nested(order: int, inside: int) -> list[tuple[int, ...]]:
    """Exponents of a triangle of an order, ``inside`` rows within the whole one."""
    if order < 0:
        return []
    corners = [tuple(inside + order * (k == c) for k in range(3)) for c in range(3)]
    if order == 0:
        return corners[:1]
    points = list(corners)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        for k in range(1, order):
            steps = [inside] * 3
            steps[a] += order - k
            steps[b] += k
            points.append(tuple(steps))
    return points + _nested(order - 3, inside + 1)


@cache
def flat_cells(points: int) -> np.ndarray:
    """Flat triangles between the nodes of a Lagrange triangle, ``(order ** 2, 3)``."""
    order = round((np.sqrt(8 * points + 1) - 3) / 2)
    position = np.argsort(lagrange_order(order))
    return position[lattice("triangle", order).cells]
