"""Edges bisected, and the triangles beside them divided, with groups, middles and references."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..facet_mesh import FacetMesh
from ..flat_triangles import sides_of

# Children of a triangle by how many of its edges are bisected, in corners 0, 1, 2 and middles
# 3 (of 01), 4 (of 12), 5 (of 20); other edges by turning these.
ONE = ((0, 3, 2), (3, 1, 2))
TWO = ((3, 1, 4), (0, 3, 4), (0, 4, 2))
THREE = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))
CORNERS = np.array(
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5]], dtype=float
)


def bisected(
    facets: FacetMesh, marked: np.ndarray, layer: np.ndarray | None = None
) -> tuple[FacetMesh, np.ndarray]:
    """Bisect marked edges, and divide the triangles beside them.

    Parameters
    ----------
    facets : FacetMesh
    marked : (m, 3) bool array
        Edges 01, 12, 20 of each triangle; both sides of an edge alike.
    layer : (m,) int array, optional
        Triangles share new points within a layer only.

    Returns
    -------
    facets : FacetMesh
        With groups, middles and reference of the parents; new points behind the old ones.
    parents : (k,) int array
        Triangle of the given mesh that each is part of, increasing.
    """
    t = facets.triangles
    layer = np.zeros(t.shape[0], dtype=np.int64) if layer is None else layer
    ends = np.sort(sides_of(t), axis=2)
    at = np.argwhere(marked)
    keys = np.column_stack([layer[at[:, 0]], ends[marked]])
    unique, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    made = np.full(t.shape, -1)
    made[marked] = facets.points.shape[0] + inverse.ravel()
    local = np.concatenate([t, made], axis=1)
    parents, corners = _children(marked)
    new = facets.points[unique[:, 1:]].mean(axis=1)
    middles = None
    if facets.middles is not None:
        new = facets.middles[at[first, 0], at[first, 1]]
        middles = _middles(facets, parents, corners)
    reference = facets.reference
    if reference is not None:
        reference = np.concatenate([reference, reference[unique[:, 1:]].mean(axis=1)])
    divided = replace(
        facets,
        points=np.concatenate([facets.points, new]),
        triangles=local[parents[:, None], corners],
        groups={k: np.flatnonzero(np.isin(parents, g)) for k, g in facets.groups.items()},
        middles=middles,
        reference=reference,
    )
    return divided, parents


def _children(marked: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parent of each new triangle and its corners among the parent's corners and middles."""
    kinds, kind = np.unique(marked @ np.array([1, 2, 4]), return_inverse=True)
    parents, corners = [], []
    for number, code in enumerate(kinds.tolist()):
        shape = np.array(_template(np.array([code & 1, code & 2, code & 4], dtype=bool)))
        own = np.flatnonzero(kind.ravel() == number)
        parents.append(np.repeat(own, len(shape)))
        corners.append(np.tile(shape, (own.size, 1)))
    order = np.argsort(np.concatenate(parents), kind="stable")
    return np.concatenate(parents)[order], np.concatenate(corners)[order]


def _template(edges: np.ndarray) -> tuple[tuple[int, ...], ...]:
    count = int(edges.sum())
    if count in (0, 3):
        return THREE if count else ((0, 1, 2),)
    # turn the triangle until the lone edge is where the template has it
    lone = int(np.flatnonzero(edges if count == 1 else ~edges)[0])
    turn = lone if count == 1 else lone + 1
    shape = ONE if count == 1 else TWO
    return tuple(tuple((c + turn) % 3 + 3 * (c > 2) for c in child) for child in shape)


def _middles(facets: FacetMesh, parents: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Middles ``(k, 3, 3)`` of children of second-order triangles, on their parents' surface."""
    assert facets.middles is not None
    at = CORNERS[corners]
    a, b, c = (0.5 * (at + np.roll(at, -1, axis=1))).transpose(2, 0, 1)
    shape = np.stack(
        [a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a], axis=2
    )
    nodes = np.concatenate([facets.points[facets.triangles], facets.middles], axis=1)
    return np.asarray(np.einsum("kij,kjd->kid", shape, nodes[parents]))
