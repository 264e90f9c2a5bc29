"""The coarse level: densities Z on clusters, and a single layer applied to all of them at once.

``A Z = B^T W G W B Z + N Z``; a stored matrix is multiplied, otherwise the sum is taken cheaply.

Each coarse density lives on one cluster of functions: between well separated boxes the kernel is
interpolated at Chebyshev nodes, ``G(x, y) = sum L_i(x) G(x_i, y_j) L_j(y)``, only neighbours are
summed point by point: some forty times less work than the sum over all points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from ..layers.dense_blocks import vector_dofs
from ..layers.dense_layer import StoredSingleLayer
from ..layers.layer import SingleLayer
from ..layers.point_sums import single_layer_sums
from ..near.near_rules import coincident_distance_squared
from ..surfaces.surface_points import SampledSurface

# A preconditioner needs no more. 5 nodes at separation 0.7 (errors of 1e-5) save at most two of 17
# iterations and take 1.6 times as long.
NODES = 3  # Chebyshev nodes along the longest side of a box
SEPARATION = 0.0  # gap of the balls around two boxes, in sums of radii, from which they are far


def bisect(positions: np.ndarray, largest: int) -> list[np.ndarray]:
    """Split points ``(n, 3)`` at medians of their longest side into sets of at most ``largest``."""
    pending, done = [np.arange(positions.shape[0])], []
    while pending:
        part = pending.pop()
        if part.size <= largest:
            done.append(np.sort(part))
            continue
        side = np.ptp(positions[part], axis=0).argmax()
        order = np.argsort(positions[part, side], kind="stable")
        middle = part.size // 2
        pending += [part[order[:middle]], part[order[middle:]]]
    return done


@dataclass(frozen=True)
class CoarseSpace:
    """Coarse densities, grouped by the cluster they live on.

    Attributes
    ----------
    clusters : list of int array
        Density functions of each cluster.
    densities : (3 n_dofs, k) sparse matrix
        Z, cluster by cluster.
    first : (n_clusters + 1,) int array
        Columns of cluster c are ``first[c]:first[c + 1]``.
    """

    clusters: list[np.ndarray]
    densities: csr_matrix
    first: np.ndarray


@dataclass(frozen=True)
class Box:
    """Chebyshev grid on the bounding box of some points."""

    grid: tuple[np.ndarray, np.ndarray, np.ndarray]
    centre: np.ndarray
    radius: float

    @classmethod
    def around(cls, points: np.ndarray) -> Box:
        low, high = points.min(axis=0), points.max(axis=0)
        size = np.maximum(high - low, 1e-12 * np.ptp(points))
        # short sides need fewer nodes for the same error
        counts = np.clip(np.ceil(NODES * (size / size.max()) ** 0.5), 2, NODES).astype(int)
        grid = tuple(
            a + s * (0.5 - 0.5 * np.cos(np.pi * (np.arange(n) + 0.5) / n))
            for a, s, n in zip(low, size, counts, strict=True)
        )
        return cls(grid, 0.5 * (low + high), 0.5 * float(np.linalg.norm(size)))

    @property
    def nodes(self) -> np.ndarray:
        return np.stack(np.meshgrid(*self.grid, indexing="ij"), axis=-1).reshape(-1, 3)

    def interpolation(self, points: np.ndarray) -> np.ndarray:
        """Lagrange polynomials of the nodes at points, ``(n_points, n_nodes)``."""
        lines = [_lagrange(self.grid[c], points[:, c]) for c in range(3)]
        table = np.einsum("pi,pj,pk->pijk", *lines, optimize=True)
        return table.reshape(points.shape[0], -1)


def _lagrange(nodes: np.ndarray, x: np.ndarray) -> np.ndarray:
    away = x[:, None, None] - nodes
    apart = nodes[:, None] - nodes
    np.fill_diagonal(apart, 1.0)
    ratio = np.broadcast_to(away, (x.size, nodes.size, nodes.size)) / apart
    i = np.arange(nodes.size)
    ratio[:, i, i] = 1.0
    return ratio.prod(axis=2)


def apply_to_coarse_space(layer: SingleLayer, coarse: CoarseSpace) -> np.ndarray:
    """``A Z``, ``(3 n_dofs, k)``: exact of a stored matrix, else to about 1e-3."""
    if isinstance(layer, StoredSingleLayer):
        # rows of a transposed product: both factors are then read in their storage order
        return np.asarray(coarse.densities.T.tocsr() @ layer.dense().T).T
    surface = layer.surface
    product = (layer.near.matrix() @ coarse.densities).toarray()
    product = product.reshape(surface.patches.n_dofs, 3, -1)
    sources = [_strengths(surface, coarse, c) for c in range(len(coarse.clusters))]
    targets = _target_clusters(surface, len(coarse.clusters))
    far_sources = [Box.around(points) for points, _ in sources]
    far_targets = [Box.around(surface.outer.offsets[t]) for t in targets]
    far = np.array([[_separated(a, b) for a in far_sources] for b in far_targets])
    _add_neighbours(surface, coarse, sources, targets, far, product)
    _add_far(surface, coarse, sources, targets, (far_sources, far_targets, far), product)
    return product.reshape(-1, product.shape[2])


def _separated(a: Box, b: Box) -> bool:
    distance = float(np.linalg.norm(a.centre - b.centre))
    return distance > (1.0 + SEPARATION) * (a.radius + b.radius)


def _strengths(
    surface: SampledSurface, coarse: CoarseSpace, c: int
) -> tuple[np.ndarray, np.ndarray]:
    """Source points of a cluster's densities and their strengths ``(n, 3, k)``."""
    columns = slice(coarse.first[c], coarse.first[c + 1])
    own = coarse.clusters[c]
    basis = surface.source_basis[:, own]
    points = np.flatnonzero(np.diff(basis.indptr))
    values = coarse.densities[vector_dofs(own), columns].toarray().reshape(own.size, -1)
    weighted = surface.source.weights[points, None] * (basis[points] @ values)
    return surface.source.offsets[points], weighted.reshape(points.size, 3, -1)


def _target_clusters(surface: SampledSurface, count: int) -> list[np.ndarray]:
    """Outer points in ``count`` groups of whole elements that are close together."""
    nt = surface.outer.per_element
    largest = -(-surface.patches.n_elements // count)
    groups = bisect(surface.centres, largest)
    return [(g[:, None] * nt + np.arange(nt)).ravel() for g in groups]


def _test(surface: SampledSurface, points: np.ndarray) -> tuple[np.ndarray, csr_matrix]:
    """Functions that some outer points test, and their weighted values ``(n, n_points)``."""
    rows = surface.basis[points]
    functions = np.unique(rows.indices)
    return functions, rows[:, functions].multiply(surface.outer.weights[points, None]).T.tocsr()


def _add_neighbours(
    surface: SampledSurface,
    coarse: CoarseSpace,
    sources: Sequence[tuple[np.ndarray, np.ndarray]],
    targets: Sequence[np.ndarray],
    far: np.ndarray,
    product: np.ndarray,
) -> None:
    within = coincident_distance_squared(surface)
    for c, (points, strengths) in enumerate(sources):
        close = np.concatenate([t for t, away in zip(targets, far[:, c], strict=True) if not away])
        # single precision, in units of the cluster: the far part is worse by four digits
        centre, size = points.mean(axis=0), np.ptp(points, axis=0).max()
        x, y = ((p - centre) / size for p in (surface.outer.offsets[close], points))
        kind = np.float32
        sums = single_layer_sums(
            x.astype(kind), y.astype(kind), (strengths / size).astype(kind), within / size**2
        )
        functions, test = _test(surface, close)
        tested = (test @ sums.reshape(close.size, -1)).reshape(functions.size, 3, -1)
        product[functions, :, coarse.first[c] : coarse.first[c + 1]] += tested


def _add_far(
    surface: SampledSurface,
    coarse: CoarseSpace,
    sources: Sequence[tuple[np.ndarray, np.ndarray]],
    targets: Sequence[np.ndarray],
    boxes: tuple[list[Box], list[Box], np.ndarray],
    product: np.ndarray,
) -> None:
    far_sources, far_targets, far = boxes
    nodes = [box.nodes for box in far_targets]
    potentials = [np.zeros((x.shape[0], 3, product.shape[2])) for x in nodes]
    for c, (points, strengths) in enumerate(sources):
        chosen = np.flatnonzero(far[:, c])
        if not chosen.size:
            continue
        table = far_sources[c].interpolation(points)
        lumped = (table.T @ strengths.reshape(points.shape[0], -1)).reshape(table.shape[1], 3, -1)
        x = np.concatenate([nodes[t] for t in chosen])
        sums = single_layer_sums(x, far_sources[c].nodes, lumped, 0.0)
        ends = np.cumsum([nodes[t].shape[0] for t in chosen])[:-1]
        for t, part in zip(chosen, np.split(sums, ends), strict=True):
            potentials[t][:, :, coarse.first[c] : coarse.first[c + 1]] = part
    for points, box, potential in zip(targets, far_targets, potentials, strict=True):
        functions, test = _test(surface, points)
        table = test @ box.interpolation(surface.outer.offsets[points])
        values = table @ potential.reshape(table.shape[1], -1)
        product[functions] += values.reshape(functions.size, *product.shape[1:])
