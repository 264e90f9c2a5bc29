"""Pieces of elements on which one closest point and one near rule suffice.

A piece is a box of an element's local coordinates. Elements whose normal turns by more than
`TURN` along s or t are bisected, across the direction that turns more, until every piece is nearly
flat: then a point nearer than the piece's size has a single closest point on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .patches import bernstein, bernstein_derivative

TURN = np.pi / 4.0  # largest angle between normals along a coordinate line
DEEPEST = 4  # bisections of one element at most
GRID = 0.5 - 0.5 * np.cos(np.pi * (np.arange(5) + 0.5) / 5)  # interior: normals exist at poles too


@dataclass(frozen=True)
class Pieces:
    """Pieces by element.

    Attributes
    ----------
    indptr : (n_elements + 1,) int array
    elements : (n_pieces,) int array
    boxes : (n_pieces, 4) array
        ``s`` from and to, ``t`` from and to.
    centres : (n_pieces, 3) array
    radii : (n_pieces,) array
        Balls around the pieces. Centres are means of the piece's own points, so that they rotate
        with it: an axis-aligned box would break the symmetry of a scene.
    """

    indptr: np.ndarray
    elements: np.ndarray
    boxes: np.ndarray
    centres: np.ndarray
    radii: np.ndarray

    @property
    def n(self) -> int:
        return self.elements.size


def divide(control: np.ndarray) -> Pieces:
    """Pieces of Bezier patches ``control (n_elements, g + 1, g + 1, 3)``."""
    elements = np.arange(control.shape[0])
    boxes = np.tile([0.0, 1.0, 0.0, 1.0], (elements.size, 1))
    for _ in range(DEEPEST):
        along_s, along_t = _turning(control[elements], boxes)
        split = np.maximum(along_s, along_t) > TURN
        if not split.any():
            break
        across_s = along_s >= along_t
        elements, boxes = _bisect(elements, boxes, split, across_s)
    ordered = np.lexsort((boxes[:, 2], boxes[:, 0], elements))
    elements, boxes = elements[ordered], boxes[ordered]
    centres, radii = balls(control[elements], boxes)
    indptr = np.searchsorted(elements, np.arange(control.shape[0] + 1))
    return Pieces(indptr, elements, boxes, centres, radii)


def balls(control: np.ndarray, boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres ``(n, 3)`` and radii ``(n,)`` of balls around boxes of patches, edges included."""
    y = _grid(control, boxes, np.linspace(0.0, 1.0, 5))[0]
    # the mean over a symmetric grid does not depend on how the patch is turned
    inner = _grid(control, boxes, GRID)[0]
    centres = inner.mean(axis=1)
    return centres, np.linalg.norm(y - centres[:, None], axis=2).max(axis=1)


def grid_points(control: np.ndarray, boxes: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Points of boxes of patches on the tensor grid of ``x (k,)``, ``(n, k * k, 3)``."""
    return np.ascontiguousarray(_grid(control, boxes, x)[0])


def _bisect(elements, boxes, split, across_s):
    """Halve the marked boxes, across s or t."""
    first, second = boxes.copy(), boxes[split].copy()
    at = np.where(across_s, 0, 2)
    rows = np.flatnonzero(split)
    middle = 0.5 * (boxes[rows, at[rows]] + boxes[rows, at[rows] + 1])
    first[rows, at[rows] + 1] = middle
    second[np.arange(rows.size), at[rows]] = middle
    return np.concatenate([elements, elements[rows]]), np.concatenate([first, second])


def _grid(control, boxes, x):
    """Positions and both slopes on a tensor grid of every box, ``(n, k * k, 3)`` each."""
    degree = control.shape[1] - 1
    n = boxes.shape[0]
    tables = []
    for low, high in ((boxes[:, 0], boxes[:, 1]), (boxes[:, 2], boxes[:, 3])):
        nodes = (low[:, None] + (high - low)[:, None] * x).ravel()
        for table in (bernstein(degree, nodes), bernstein_derivative(degree, nodes)):
            tables.append(table.reshape(n, x.size, degree + 1))
    s, ds, t, dt = tables
    return tuple(
        np.einsum("nki,nijc,nlj->nklc", a, control, b, optimize=True).reshape(n, -1, 3)
        for a, b in ((s, t), (ds, t), (s, dt))
    )


def _turning(control, boxes):
    """Largest angle between normals along s and along t on each box."""
    _, along_s, along_t = _grid(control, boxes, GRID)
    normal = np.cross(along_s, along_t)
    size = np.linalg.norm(normal, axis=2, keepdims=True)
    normal = normal / np.maximum(size, 1e-300)
    k = GRID.size
    grid = normal.reshape(-1, k, k, 3)
    by_s = np.einsum("nklc,nmlc->nlkm", grid, grid, optimize=True).min(axis=(1, 2, 3))
    by_t = np.einsum("nklc,nkmc->nklm", grid, grid, optimize=True).min(axis=(1, 2, 3))
    return tuple(np.arccos(np.clip(c, -1.0, 1.0)) for c in (by_s, by_t))
