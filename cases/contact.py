"""The sampled surface on which a run tests for self-intersection."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
from scipy.sparse import block_diag, csr_matrix, diags
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from coupling.collision import Collision

from .geometry.bag import Bag


def collision(body: Bag, tessellate: int = 3, engine: str = "auto") -> Collision:
    """Test of motions of a bag; samples of neighbouring elements are made one.

    Parameters
    ----------
    tessellate : int
        Cells per element side, two triangles each.
    engine : str
        "ipctk", "bound", or "auto": ipctk where it is installed.

    Raises
    ------
    ValueError
        "ipctk" asked for and not installed.
    """
    installed = find_spec("ipctk") is not None
    if engine == "ipctk" and not installed:
        raise ValueError("contact.engine: 'ipctk' needs the extra: pip install airfold[contact]")
    n = tessellate + 1
    x = np.linspace(0.0, 1.0, n)
    xi, eta = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    parts = (body.membrane, body.patch)
    sample = block_diag([part.sample(xi, eta) for part in parts], format="csr")
    group = _merged(sample @ body.coefficients)
    average = csr_matrix((np.ones(len(group)), (group, np.arange(len(group)))))
    average = diags(1.0 / np.asarray(average.sum(axis=1)).ravel()) @ average
    triangles = group[_triangles(sum(part.n_elements for part in parts), tessellate)]
    proper = np.array([len(set(t)) == 3 for t in triangles.tolist()])
    on_patch = np.repeat([0, 1], [2 * tessellate**2 * part.n_elements for part in parts]) == 1
    chosen = "ipctk" if engine != "bound" and installed else "bound"
    return Collision((average @ sample).tocsr(), triangles[proper], on_patch[proper], chosen)


def _triangles(elements: int, tessellate: int) -> np.ndarray:
    """Triangles of the samples of all elements, before merging."""
    n = tessellate + 1
    i, j = (g.ravel() for g in np.meshgrid(range(tessellate), range(tessellate), indexing="ij"))
    a, b, c, d = i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1
    cell = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return (np.arange(elements)[:, None, None] * n * n + cell).reshape(-1, 3)


def _merged(points: np.ndarray) -> np.ndarray:
    """Index of the merged sample of each point."""
    near = 1e-7 * float(np.ptp(points, axis=0).max())
    pairs = cKDTree(points).query_pairs(near, output_type="ndarray")
    graph = csr_matrix((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
    return connected_components(graph, directed=False)[1]
