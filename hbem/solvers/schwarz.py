"""Preconditioners of the saddle system ``[A C; C^T 0]`` of a single layer.

Fat bodies: the mass matrix. Gaps: two-level restricted additive Schwarz [Cai, Sarkis 1999] with a
multiplicative coarse level, ``y = Z E^-1 Z^T v + R (v - S Z E^-1 Z^T v)``, ``E = Z^T S Z``.
Subdomains are balls in space, so they hold both sheets of a gap; each cluster of functions
carries seven coarse densities: three constants, the normal, and the normal times three offsets.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree

from ..layers.dense_blocks import vector_dofs
from ..layers.layer import SingleLayer
from ..surfaces.surface_points import SampledSurface
from .coarse_level import CoarseSpace, apply_to_coarse_space, bisect
from .saddle_system import SaddleSystem

COARSE = 7  # densities a cluster
LARGEST_COARSE = 2000  # unknowns of the coarse level; its clusters grow beyond


@dataclass(frozen=True)
class SchwarzOptions:
    """Sizes of the two-level preconditioner.

    Parameters
    ----------
    own : int
        Density functions a cluster. Those of the coarse level are as large as 2000 coarse unknowns
        need; subdomains around larger clusters would cost more than the iterations they save.
    overlap : float
        Reach of a subdomain around its cluster, in square roots of the area of a function.

    Raises
    ------
    ValueError
        ``own < 1`` or a negative overlap.
    """

    own: int = 64
    overlap: float = 2.5

    def __post_init__(self) -> None:
        if self.own < 1 or self.overlap < 0.0:
            raise ValueError(f"need own >= 1 and overlap >= 0, got {self.own}, {self.overlap}")

    def coarse_size(self, n_functions: int) -> int:
        """Functions a cluster of the coarse level for a surface of this size."""
        return max(self.own, -(-COARSE * n_functions // LARGEST_COARSE))


@dataclass(frozen=True)
class Functions:
    """Where density functions sit: means over their supports.

    Attributes
    ----------
    positions, normals : (n, 3) array
        Positions relative to the origin of the surface.
    sizes : (n,) array
        Square roots of their areas ``int N_a``.
    """

    positions: np.ndarray
    normals: np.ndarray
    sizes: np.ndarray

    @classmethod
    def of(cls, surface: SampledSurface) -> Functions:
        area = surface.project(np.ones((surface.outer.weights.size, 1)))
        normals = surface.constraint
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        positions = surface.project(surface.outer.offsets) / area
        return cls(positions, normals / np.maximum(length, 1e-300), np.sqrt(np.abs(area[:, 0])))


def subdomains_around(
    functions: Functions, clusters: Sequence[np.ndarray], overlap: float
) -> list[np.ndarray]:
    """All functions within reach of each cluster, the cluster itself first."""
    tree = cKDTree(functions.positions)
    subdomains = []
    for own in clusters:
        reach = overlap * functions.sizes[own]
        found = tree.query_ball_point(functions.positions[own], reach, return_sorted=False)
        halo = np.setdiff1d(np.unique(np.concatenate([np.asarray(f, int) for f in found])), own)
        subdomains.append(np.concatenate([own, halo]))
    return subdomains


def coarse_space(functions: Functions, clusters: Sequence[np.ndarray]) -> CoarseSpace:
    """Orthonormal coarse densities of all clusters, at most seven each."""
    data, rows, cols, first = [], [], [], [0]
    for own in clusters:
        x, n = functions.positions[own], functions.normals[own]
        x = x - x.mean(axis=0)
        x = x / max(np.abs(x).max(), 1e-300)
        constant = np.broadcast_to(np.eye(3), (own.size, 3, 3))
        rough = np.concatenate(
            [constant, n[:, :, None], n[:, :, None] * x[:, None, :]], axis=2
        ).reshape(3 * own.size, COARSE)
        left, sigma, _ = np.linalg.svd(rough, full_matrices=False)
        q = left[:, sigma > 1e-8 * sigma[0]]
        data.append(q.ravel())
        rows.append(np.repeat(vector_dofs(own), q.shape[1]))
        cols.append(np.tile(first[-1] + np.arange(q.shape[1]), q.shape[0]))
        first.append(first[-1] + q.shape[1])
    entries = (np.concatenate(data), (np.concatenate(rows), np.concatenate(cols)))
    densities = csr_matrix(entries, shape=(3 * functions.sizes.size, first[-1]))
    return CoarseSpace(list(clusters), densities, np.array(first))


@dataclass(frozen=True)
class TwoLevelSchwarz:
    """Two-level restricted additive Schwarz of one saddle system.

    Attributes
    ----------
    own, subdomains : lists of int array
        Vector dofs of each cluster and of the subdomain around it.
    inverses : list of (n_own, n_subdomain) array
        Rows of the inverses of the subdomains' matrices.
    coarse : (3 n, k) sparse matrix
        Coarse densities Z; multipliers are coarse unknowns too.
    product : (3 n, k) array
        ``A Z``, the largest array by far.
    columns, tested : (3 n, m), (k, m) array
        C of the saddle system and ``Z^T C``.
    factors : tuple
        LU of ``E = Z^T S Z``.
    seconds : dict
        Build time of subdomains and coarse level.
    """

    own: list[np.ndarray]
    subdomains: list[np.ndarray]
    inverses: list[np.ndarray]
    coarse: csr_matrix
    product: np.ndarray
    columns: np.ndarray
    tested: np.ndarray
    factors: tuple[np.ndarray, np.ndarray]
    seconds: dict[str, float]

    def __call__(self, v: np.ndarray) -> np.ndarray:
        n, k = self.coarse.shape
        a = lu_solve(self.factors, np.concatenate([self._transposed @ v[:n], v[n:]]))
        r = v[:n] - self.columns @ a[k:] - self.product @ a[:k]
        y = np.concatenate([self.coarse @ a[:k], a[k:]])
        for own, around, inverse in zip(self.own, self.subdomains, self.inverses, strict=True):
            y[own] += inverse @ r[around]
        return y

    @cached_property
    def _transposed(self) -> csr_matrix:
        return self.coarse.T.tocsr()

    @property
    def nbytes(self) -> int:
        return self.product.nbytes + sum(m.nbytes for m in self.inverses) + self.factors[0].nbytes

    def __repr__(self) -> str:
        size = np.mean([s.size for s in self.subdomains]) / 3.0
        return (
            f"TwoLevelSchwarz({len(self.own)} clusters, subdomains of {size:.0f} functions, "
            f"{self.factors[0].shape[0]} coarse unknowns, {self.nbytes / 1e6:.0f} MB)"
        )


def two_level_schwarz(
    system: SaddleSystem, options: SchwarzOptions | None = None
) -> TwoLevelSchwarz:
    """Build the preconditioner of a saddle system.

    Parameters
    ----------
    system : SaddleSystem
        Its operator is a `hbem.SingleLayer`.
    options : SchwarzOptions, optional

    Returns
    -------
    TwoLevelSchwarz
        Callable: ``(size,)`` to ``(size,)``, multipliers last.

    Raises
    ------
    TypeError
        An operator that is no single layer: it has no surface to cluster.
    """
    options = SchwarzOptions() if options is None else options
    layer = system.operator
    if not isinstance(layer, SingleLayer):
        raise TypeError(f"two-level Schwarz needs a SingleLayer, got {type(layer).__name__}")
    start = time.perf_counter()
    own, around, inverses = local_inverses(layer, options)
    middle = time.perf_counter()
    functions = Functions.of(layer.surface)
    wide = bisect(functions.positions, options.coarse_size(functions.sizes.size))
    coarse = coarse_space(functions, wide)
    return TwoLevelSchwarz(
        own,
        around,
        inverses,
        coarse.densities,
        *_coarse_level(layer, system.columns, coarse),
        {"subdomains": middle - start, "coarse": time.perf_counter() - middle},
    )


def local_inverses(
    layer: SingleLayer, options: SchwarzOptions
) -> tuple[list[np.ndarray], list[np.ndarray], list[np.ndarray]]:
    """Vector dofs of clusters and of the subdomains around them, rows of their inverses."""
    functions = Functions.of(layer.surface)
    clusters = bisect(functions.positions, options.own)
    around = subdomains_around(functions, clusters, options.overlap)
    inverses = layer.blocks(around, lambda k, block: _own_rows(block, 3 * clusters[k].size))
    return [vector_dofs(c) for c in clusters], [vector_dofs(p) for p in around], inverses


def _own_rows(block: np.ndarray, n_own: int) -> np.ndarray:
    """First rows of the inverse of a subdomain's matrix."""
    unit = np.eye(block.shape[0], n_own)
    return lu_solve(lu_factor(block, check_finite=False), unit, trans=1, check_finite=False).T


def _coarse_level(
    layer: SingleLayer, columns: np.ndarray, coarse: CoarseSpace
) -> tuple[np.ndarray, np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """``A Z``, C, ``Z^T C`` and the factors of ``Z^T S Z``, multipliers last."""
    z = coarse.densities
    product, tested = apply_to_coarse_space(layer, coarse), z.T @ columns
    k, m = tested.shape
    matrix = np.zeros((k + m, k + m))
    matrix[:k, :k] = z.T @ product
    matrix[:k, k:], matrix[k:, :k] = tested, tested.T
    return product, columns, tested, lu_factor(matrix)
