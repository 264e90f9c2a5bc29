"""The same thing elsewhere, in another unit, turned, renumbered: what must not change a result."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from hbem.surfaces.patches import BezierPatches

AWAY = np.array([0.6, 0.64, 0.48])
Cloud = tuple[np.ndarray, np.ndarray]  # points and normals, (n, 3) each


def _turned(points: np.ndarray, normals: np.ndarray) -> Cloud:
    """Rotated by a random orthogonal matrix."""
    q, _ = np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))
    return points @ q.T, normals @ q.T


def _permuted(points: np.ndarray, normals: np.ndarray) -> Cloud:
    order = np.random.default_rng(2).permutation(points.shape[0])
    return points[order], normals[order]


def _with_duplicates(points: np.ndarray, normals: np.ndarray) -> Cloud:
    """A tenth of the points twice."""
    again = np.random.default_rng(3).permutation(points.shape[0])[: points.shape[0] // 10]
    return np.concatenate([points, points[again]]), np.concatenate([normals, normals[again]])


CLOUD_DISGUISES: Mapping[str, Callable[[np.ndarray, np.ndarray], Cloud]] = {
    "turned": _turned,
    "shifted by 1e6": lambda x, n: (x + 1e6 * AWAY, n),
    "1e-6 times the size": lambda x, n: (1e-6 * x, n),
    "1e6 times the size": lambda x, n: (1e6 * x, n),
    "permuted": _permuted,
    "a tenth twice": _with_duplicates,
}


def reordered(body: BezierPatches, seed: int) -> BezierPatches:
    """The same body with elements, density functions and coefficients in random order."""
    assert body.coefficients is not None
    rng = np.random.default_rng(seed)
    elements, dofs = rng.permutation(body.n_elements), rng.permutation(body.n_dofs)
    columns = rng.permutation(body.n_coefficients)
    counts = np.diff(body.indptr)[elements]
    rows = np.concatenate([np.arange(*body.indptr[e : e + 2]) for e in elements])
    net = (body.geometry_degree + 1) ** 2
    control = (elements[:, None] * net + np.arange(net)).ravel()
    return replace(
        body,
        indptr=np.concatenate([[0], np.cumsum(counts)]),
        dofs=np.argsort(dofs)[body.dofs[rows]],
        extraction=body.extraction[rows],
        bezier=body.bezier[control][:, columns],
        coefficients=body.coefficients[columns],
    )
