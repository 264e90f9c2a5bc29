"""The sampled surface on which a run tests for self-intersection."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
from scipy.sparse import block_diag, csr_matrix, diags
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from coupling.certify import grid_cells, halved
from coupling.collision import Collision

from .geometry.bag import Bag
from .loader import SceneError

FINEST = 12  # cells per element side


def certified(body: Bag, tessellate: int, engine: str) -> Collision:
    """Test of motions, refined until it finds the initial configuration free of contact.

    Raises
    ------
    SceneError
        Not even the finest test does.
    """
    while True:
        test = collision(body, tessellate, engine)
        cause = test.inspect(body.coefficients, body.coefficients)
        if cause is None:
            return test
        if 2 * tessellate > FINEST:
            raise SceneError(
                [
                    f"contact.tessellate: the initial bag cannot be certified free of contact on "
                    f"{tessellate} cells a side ({cause.value}); refine the mesh at its folds, or "
                    "set contact.test = 'off'"
                ]
            )
        tessellate *= 2


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
    samples = (average @ sample).tocsr()
    cells = group[grid_cells(sum(part.n_elements for part in parts), n)]
    triangles = halved(cells, samples @ body.coefficients)
    proper = np.array([len(set(t)) == 3 for t in triangles.tolist()])
    on_patch = np.repeat([0, 1], [tessellate**2 * part.n_elements for part in parts]) == 1
    chosen = "ipctk" if engine != "bound" and installed else "bound"
    return Collision(samples, triangles[proper], np.tile(on_patch, 2)[proper], chosen)


def _merged(points: np.ndarray) -> np.ndarray:
    """Index of the merged sample of each point."""
    near = 1e-7 * float(np.ptp(points, axis=0).max())
    pairs = cKDTree(points).query_pairs(near, output_type="ndarray")
    graph = csr_matrix((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
    return connected_components(graph, directed=False)[1]
