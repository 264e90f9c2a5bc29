"""Chords of a flat bag: edges across a sheet that join two points of its seam.

Sheets share the points of the seam, so a chord of both sheets would be an edge of four
triangles; and a sheet lifted off the other stays down on it along a chord. Chords are bisected,
in each sheet by a point of its own.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..facet_mesh import FacetMesh
from .sheets import told_apart

# Children of a triangle by which of its edges are bisected, in corners 0, 1, 2 and middles
# 3 (of 01), 4 (of 12), 5 (of 20); others by turning these.
ONE = ((0, 3, 2), (3, 1, 2))
TWO = ((3, 1, 4), (0, 3, 4), (0, 4, 2))
THREE = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))
CORNERS = np.array(
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5]], dtype=float
)


def split_chords(facets: FacetMesh) -> FacetMesh:
    """Bisect the edges that join two points of the seam and are no seam.

    Parameters
    ----------
    facets : FacetMesh
        Flat, of no thickness; sheets share the points of their seam. Orientation does not matter.

    Returns
    -------
    FacetMesh
        The same mesh where it has no chords.

    Raises
    ------
    MeshError
        A mesh that is not flat, or sheets that cannot be told apart.
    """
    sheets = told_apart(facets)
    rim = np.concatenate([sheets.seam, sheets.open_edges])
    on_rim = np.zeros(facets.points.shape[0], dtype=bool)
    on_rim[rim] = True
    ends = np.sort(np.stack([facets.triangles, np.roll(facets.triangles, -1, axis=1)], 2), axis=2)
    chords = on_rim[ends].all(axis=2)
    known = {(int(a), int(b)) for a, b in rim}
    for t, k in np.argwhere(chords):
        chords[t, k] = (int(ends[t, k, 0]), int(ends[t, k, 1])) not in known
    if not chords.any():
        return facets
    split = bisected(facets, chords, sheets.upper.astype(np.int64))
    count = split.points.shape[0] - facets.points.shape[0]
    note = f"{count} edges across a sheet that joined two points of its seam bisected"
    return replace(split, notes=(*facets.notes, note))


def bisected(facets: FacetMesh, marked: np.ndarray, layer: np.ndarray | None = None) -> FacetMesh:
    """Bisect marked edges, and split the triangles beside them.

    Parameters
    ----------
    facets : FacetMesh
    marked : (m, 3) bool array
        Edges 01, 12, 20 of each triangle; both sides of an edge alike.
    layer : (m,) int array, optional
        Triangles share new points within a layer only.

    Returns
    -------
    FacetMesh
        With groups, middles and reference of the parents.
    """
    t = facets.triangles
    layer = np.zeros(t.shape[0], dtype=np.int64) if layer is None else layer
    ends = np.sort(np.stack([t, np.roll(t, -1, axis=1)], axis=2), axis=2)
    at = np.argwhere(marked)
    keys = np.column_stack([layer[at[:, 0]], ends[marked]])
    unique, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    n = facets.points.shape[0]
    made = np.full(t.shape, -1)
    made[marked] = n + inverse.ravel()
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
    return replace(
        facets,
        points=np.concatenate([facets.points, new]),
        triangles=local[parents[:, None], corners],
        groups={k: np.flatnonzero(np.isin(parents, g)) for k, g in facets.groups.items()},
        middles=middles,
        reference=reference,
    )


def _children(marked: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parent of each new triangle and its corners among the parent's corners and middles."""
    templates = [_template(edges) for edges in marked]
    parents = np.repeat(np.arange(len(templates)), [len(t) for t in templates])
    return parents, np.array([child for template in templates for child in template])


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
    place = CORNERS[corners]
    a, b, c = (0.5 * (place + np.roll(place, -1, axis=1))).transpose(2, 0, 1)
    shape = np.stack(
        [a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a], axis=2
    )
    nodes = np.concatenate([facets.points[facets.triangles], facets.middles], axis=1)
    return np.asarray(np.einsum("kij,kjd->kid", shape, nodes[parents]))
