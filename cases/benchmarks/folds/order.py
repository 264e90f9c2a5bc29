"""In which order the folds of a run open: angles between neighbouring panels, frame by frame.

A fold has opened where the angle between its panels' normals has fallen below half of the first
one; folds count from the end of the bag that lies at x = 0 when flat.
"""

from __future__ import annotations

import numpy as np

from ...geometry.panels import FoldPanels
from ...kinds.inflation.views.equal_volumes import RunByVolume
from ...output.vtk import flat_cells_of, read_grid

OPEN = 0.5  # of the first angle
TOLD = 3  # folds that are named


def fold_angles(panels: FoldPanels, points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Angle in degrees between the normals of neighbouring panels.

    Parameters
    ----------
    panels : FoldPanels
    points : (n, 3) array
    quads : (m, 4) int array
        Of a grid of the whole bag, equally many an element, the membrane's first.
    """
    a, b, c, d = (points[quads[:, k]] for k in range(4))
    elements = sum(part.n_elements for part in panels.bag.parts)
    normal = np.cross(c - a, d - b).reshape(elements, -1, 3).sum(axis=1)
    means = np.array(
        [normal[upper].sum(axis=0) - normal[lower].sum(axis=0) for upper, lower in panels.cells]
    )
    means /= np.linalg.norm(means, axis=1, keepdims=True)
    cosine = np.einsum("ij,ij->i", means[:-1], means[1:])
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def opened_at(panels: FoldPanels, run: RunByVolume) -> np.ndarray:
    """V/V0 at which each fold has opened, NaN for those that have not; empty for another mesh."""
    grids = [read_grid(run.folder / name) for _, name in run.frames]
    cells = flat_cells_of(grids[0]).corners
    if len(cells) % sum(part.n_elements for part in panels.bag.parts):
        return np.empty(0)
    angles = np.array([fold_angles(panels, g.points, cells) for g in grids])
    share = angles / angles[0]
    found = np.full(angles.shape[1], np.nan)
    for k, column in enumerate(share.T):
        after = np.flatnonzero(column < OPEN)
        if after.size:
            i = int(after[0])
            between = (column[i - 1] - OPEN) / (column[i - 1] - column[i])
            found[k] = run.volumes[i - 1] + between * (run.volumes[i] - run.volumes[i - 1])
    return found


def told(volumes: np.ndarray) -> str:
    """How many folds have opened, and the first of them with their V/V0."""
    order = np.argsort(volumes)[: int(np.isfinite(volumes).sum())]
    first = ", ".join(f"{k + 1} at {volumes[k]:.2f}" for k in order[:TOLD])
    return f"{len(order)} of {len(volumes)}" + (f": {first}" if first else "")
