"""Sheets drawn in: points moved along their plane until edges have their flat lengths again.

Lifting two sheets off each other stretches them beside the seam, by a third where triangles are
as narrow as the opening; real sheets draw their seam in instead. The least squares of all edges'
strains, weighted by their lengths as springs of one material are, by Gauss and Newton.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, identity
from scipy.sparse.linalg import spsolve

from ..mending.topology import edges_of

PASSES = 30
STILL = 1e-6  # of an edge's length: the largest move of the last pass
HELD = 1e-6  # stiffness that keeps the bag where it is, of the springs'


def drawn_in(
    points: np.ndarray, flat: np.ndarray, triangles: np.ndarray, plane: np.ndarray
) -> np.ndarray:
    """Lifted points moved along the plane.

    Parameters
    ----------
    points, flat : (n, 3) array
        Lifted and flat.
    triangles : (m, 3) int array
    plane : (2, 3) array
        Orthonormal directions in which points may move.

    Returns
    -------
    (n, 3) array
    """
    i, j = edges_of(triangles).ends.T
    rest = np.linalg.norm(flat[i] - flat[j], axis=1)
    weight = np.sqrt(1.0 / rest)
    rows = np.repeat(np.arange(i.size), 4)
    columns = np.stack([2 * i, 2 * i + 1, 2 * j, 2 * j + 1], axis=1).ravel()
    moved = points.copy()
    for _ in range(PASSES):
        d = moved[i] - moved[j]
        length = np.linalg.norm(d, axis=1)
        along = (d @ plane.T) * (weight / length)[:, None]
        slopes = np.concatenate([along, -along], axis=1).ravel()
        jacobian = coo_matrix((slopes, (rows, columns)), shape=(i.size, 2 * len(points))).tocsc()
        stiff = jacobian.T @ jacobian
        held = HELD * stiff.diagonal().mean() * identity(stiff.shape[0], format="csc")
        step = -spsolve((stiff + held).tocsc(), jacobian.T @ (weight * (length - rest)))
        step = step.reshape(-1, 2)
        moved += step @ plane
        if np.abs(step).max() < STILL * rest.min():
            break
    return moved
