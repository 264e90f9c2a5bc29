"""Triangles halved at marked sides, with their middles and references."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..facet_mesh import FacetMesh

# values of the six functions of a second-order triangle (corners, middles of 01, 12, 20) at the
# quarter points of side 01 and at the middle of the line from its middle to corner 2
_QUARTER = np.array([0.375, -0.125, 0.0, 0.75, 0.0, 0.0])
_THREE_QUARTERS = np.array([-0.125, 0.375, 0.0, 0.75, 0.0, 0.0])
_INNER = np.array([-0.125, -0.125, 0.0, 0.25, 0.5, 0.5])


def halved(facets: FacetMesh, marked: np.ndarray) -> tuple[FacetMesh, np.ndarray]:
    """Bisect marked edges by one new point each.

    Parameters
    ----------
    facets : FacetMesh
        Without groups: these follow by the second result.
    marked : (n, 2) int array
        FacetEdges, smaller vertex first.

    Returns
    -------
    facets : FacetMesh
        Halves stand at the places of their parents and behind all others.
    parents : (m,) int array
        Triangle of the given mesh that each is part of.
    """
    parents = np.arange(len(facets.triangles))
    for low, high in marked.tolist():
        facets, parents = _one(facets, parents, low, high)
    return facets, parents


def _one(
    facets: FacetMesh, parents: np.ndarray, low: int, high: int
) -> tuple[FacetMesh, np.ndarray]:
    ends = np.sort(np.stack([facets.triangles, np.roll(facets.triangles, -1, axis=1)], 2), axis=2)
    own, sides = np.nonzero(np.all(ends == (low, high), axis=2))
    turn = (sides[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(facets.triangles[own], turn, axis=1).T
    middle = facets.points[[low, high]].mean(axis=0)
    middles = facets.middles
    if middles is not None:
        around = np.take_along_axis(middles[own], turn[:, :, None], axis=1)
        middle = around[0, 0]
        nodes = np.concatenate([facets.points[np.stack([a, b, c], axis=1)], around], axis=1)
        quarter, three, inner = (
            np.einsum("j,kjd->kd", w, nodes) for w in (_QUARTER, _THREE_QUARTERS, _INNER)
        )
        middles = middles.copy()
        middles[own] = np.stack([quarter, inner, around[:, 2]], axis=1)
        middles = np.concatenate([middles, np.stack([three, around[:, 1], inner], axis=1)])
    new = np.full(len(own), len(facets.points))
    triangles = facets.triangles.copy()
    triangles[own] = np.stack([a, new, c], axis=1)
    triangles = np.concatenate([triangles, np.stack([new, b, c], axis=1)])
    reference = facets.reference
    if reference is not None:
        reference = np.concatenate([reference, reference[[low, high]].mean(axis=0)[None]])
    points = np.concatenate([facets.points, middle[None]])
    split = replace(
        facets, points=points, triangles=triangles, middles=middles, reference=reference
    )
    return split, np.append(parents, parents[own])
