"""Forces and tangents between a sample and the triangle that faces it.

With ``z = (1, -b_0, -b_1, -b_2)`` over the sample and the corners, the distance ``d = |r|`` has
the gradient ``z (x) m``, ``m = r / d``, and

    ``d'' = (z z^T (x) (1 - m m^T) - G A^-1 G^T) / d``,

where the directions ``e_k`` in which the closest point is free (two edges inside the triangle, one
on an edge, none at a corner) give ``G_k = -(z (x) e_k + eps_k (x) r)`` and ``A_kl = e_k . e_l``.
Everything lives in five directions: ``u (x) m`` with the three ``u`` of sum zero, ``z (x) t`` with
the two tangents ``t``. Negative eigenvalues are cut off there.
"""

from __future__ import annotations

import numpy as np

from .facing_search import Facing

# orthonormal rows of sum zero: no block pushes a sample and its triangle the same way
_BALANCED = np.array([[3.0, -1.0, -1.0, -1.0], [0.0, 2.0, -1.0, -1.0], [0.0, 0.0, 1.0, -1.0]])
_BALANCED /= np.linalg.norm(_BALANCED, axis=1, keepdims=True)


def pair_forces(facing: Facing, slope: np.ndarray) -> np.ndarray:
    """Gradients ``(k, 4, 3)`` of functions of the distance with slopes ``(k,)``."""
    normal = facing.arrow / facing.distance[:, None]
    return slope[:, None, None] * _signs(facing)[:, :, None] * normal[:, None]


def pair_tangents(
    facing: Facing, points: np.ndarray, slope: np.ndarray, bend: np.ndarray, projected: bool = True
) -> np.ndarray:
    """Second derivatives ``(k, 4, 3, 4, 3)`` of functions of the distance.

    Parameters
    ----------
    facing : Facing
    points : (n, 3) array
        All samples.
    slope, bend : (k,) array
        First and second derivative of the functions.
    projected : bool
        Cut off negative eigenvalues.
    """
    count = len(facing.distance)
    z = _signs(facing)
    size = np.linalg.norm(z, axis=1)
    normal = facing.arrow / facing.distance[:, None]
    tangents = _tangents(normal)
    edges, ends = _free_directions(facing, points)
    gram = np.einsum("kaj,kbj->kab", edges, edges)
    gram[:, [0, 1], [0, 1]] += np.where(np.any(edges, axis=2), 0.0, 1.0)  # none: any number serves
    free = np.concatenate(
        [
            facing.distance[:, None, None] * np.einsum("kav,uv->kau", ends, _BALANCED),
            size[:, None, None] * np.einsum("kaj,ktj->kat", edges, tangents),
        ],
        axis=2,
    )
    reduced = -np.einsum("kai,kab,kbj->kij", free, np.linalg.inv(gram), free)
    reduced[:, [3, 4], [3, 4]] += size[:, None] ** 2
    reduced *= (slope / facing.distance)[:, None, None]
    along = z @ _BALANCED.T
    reduced[:, :3, :3] += bend[:, None, None] * along[:, :, None] * along[:, None, :]
    if projected:
        values, vectors = np.linalg.eigh(reduced)
        reduced = np.einsum(
            "kia,ka,kja->kij", vectors, np.maximum(values, 0.0), vectors, optimize=True
        )
    basis = np.concatenate(
        [
            _BALANCED[None, :, :, None] * normal[:, None, None],
            (z / size[:, None])[:, None, :, None] * tangents[:, :, None],
        ],
        axis=1,
    ).reshape(count, 5, 12)
    blocks = np.swapaxes(basis, 1, 2) @ reduced @ basis
    return blocks.reshape(count, 4, 3, 4, 3)


def _signs(facing: Facing) -> np.ndarray:
    return np.concatenate([np.ones((len(facing.weights), 1)), -facing.weights], axis=1)


def _tangents(normal: np.ndarray) -> np.ndarray:
    """Two unit vectors normal to each normal ``(k, 3)`` and to each other: ``(k, 2, 3)``."""
    axis = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = np.cross(normal, axis)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normal, first)], axis=1)


def _free_directions(facing: Facing, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges ``(k, 2, 3)`` along which the closest point is free, 0 for none, and their ends.

    The ends are the edges' coefficients ``(k, 2, 4)`` over the sample and the corners.
    """
    count = len(facing.weights)
    on = facing.weights > 0.0
    first = on.argmax(axis=1)
    second = 2 - on[:, ::-1].argmax(axis=1)
    ends, rows = np.zeros((count, 2, 4)), np.arange(count)
    at = second > first
    ends[rows[at], 0, 1 + first[at]] = -1.0
    ends[rows[at], 0, 1 + second[at]] = 1.0
    ends[on.all(axis=1), 1] = [0.0, -1.0, 1.0, 0.0]
    edges = np.einsum("kav,kvj->kaj", ends, points[facing.vertices])
    return edges, ends
