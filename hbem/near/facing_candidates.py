"""Pairs of elements that may be the closest of facing walls, and where a search starts on them."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..surfaces.narrowest_gap import FAT, NEIGHBOURS, largest_extent, opposed_neighbours
from ..surfaces.surface_points import SampledSurface


def body_labels(surface: SampledSurface) -> np.ndarray:
    """Elements that share density functions, and what these share: a label each."""
    p = surface.patches
    ones = np.ones(p.dofs.size)
    owner = np.repeat(np.arange(p.n_elements), np.diff(p.indptr))
    n = p.n_elements + p.n_dofs
    graph = coo_matrix((ones, (owner, p.n_elements + p.dofs)), shape=(n, n))
    return connected_components(graph, directed=False)[1][: p.n_elements]


def facing_candidates(
    surface: SampledSurface, body: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs of elements and starts ``(n, 4)`` from their closest samples."""
    points, per = surface.outer.offsets, surface.outer.per_element
    reach = FAT * largest_extent(surface)
    pairs = [
        _flat(mine, index)
        for mine, index in opposed_neighbours(points, surface.outer.normals, reach)
    ]
    pairs += _between_bodies(points, np.repeat(body, per))
    if not pairs:
        return np.empty(0, np.int64), np.empty(0, np.int64), np.empty((0, 4))
    i, j = np.concatenate(pairs, axis=1)
    distance = np.linalg.norm(points[i] - points[j], axis=1)
    # what the true distance can be at least
    e, f = i // per, j // per
    least = distance - surface.radii[e] - surface.radii[f]
    apart = body[e] != body[f]
    kept = ~apart | (least <= distance[apart].min(initial=np.inf))
    i, j = np.where(i < j, i, j)[kept], np.where(i < j, j, i)[kept]
    e, f, distance = i // per, j // per, distance[kept]
    order = np.lexsort((distance, f, e))
    key = (e * surface.patches.n_elements + f)[order]
    order = order[np.flatnonzero(np.diff(key, prepend=-1))]
    st = np.stack([surface.outer.s, surface.outer.t], axis=1)
    start = np.concatenate([st[i[order] % per], st[j[order] % per]], axis=1)
    return e[order], f[order], start


def _flat(mine: np.ndarray, index: np.ndarray) -> np.ndarray:
    return np.stack([np.repeat(mine, index.shape[1]), index.ravel()])


def _between_bodies(points: np.ndarray, body: np.ndarray) -> list[np.ndarray]:
    """Nearest points of other bodies, of each body those with a larger label."""
    pairs = []
    for k in range(body.max()):
        mine, other = np.flatnonzero(body == k), np.flatnonzero(body > k)
        count = min(NEIGHBOURS, other.size)
        _, index = cKDTree(points[other]).query(points[mine], k=count)
        pairs.append(_flat(mine, other[index.reshape(mine.size, count)]))
    return pairs


def neighbouring_pairs(
    surface: SampledSurface, elements: np.ndarray, local: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs of elements that touch those of each pair, started at the middle."""
    tree = cKDTree(surface.centres)
    keys = []
    for e, f in np.unique(elements, axis=0):
        a, b = (
            np.asarray(tree.query_ball_point(surface.centres[k], 2.0 * surface.radii[k]))
            for k in (e, f)
        )
        a, b = (c.ravel() for c in np.meshgrid(a, b))
        keys.append(np.minimum(a, b) * surface.patches.n_elements + np.maximum(a, b))
    first, second = np.divmod(np.unique(np.concatenate(keys)), surface.patches.n_elements)
    kept = first < second
    return first[kept], second[kept], np.full((np.count_nonzero(kept), 4), 0.5)
