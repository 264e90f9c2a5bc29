"""The point kernel that is compressed, ``G`` between points, summed exactly; densities on points.

Differences of positions are taken of the points as given: centring them, or a scale that is no
power of two, would round, and next to a point of a graded mesh rounding is all that is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csc_matrix, spmatrix

from .._threads_kernels import over
from ..surfaces.configuration import REACH, real_array
from . import _cluster_sum_kernels as kernels

COINCIDENT = 1e-60  # of the extent: only equal positions are nearer, and powers stay numbers
TEST_RANDOM = 2  # random densities of a measurement; the constant ones are the three axes
GROUP = 64  # targets of a direct sum that share a sweep


@dataclass(frozen=True)
class PointKernel:
    """Plain kernel ``G = (I/r + r r/r^3)/8 pi``, or the double layer if normals are given.

    Positions are scaled by a power of two near their extent, so that thresholds have no units.

    Parameters
    ----------
    points : (n, 3) array
    normals : (n, 3) array, optional
    within : float
        Squared distance, in scaled positions, of points that count as coincident:
        their pairs are skipped.

    Raises
    ------
    ValueError
        Wrong shapes, values that are complex or not finite, or an extent beyond the reach of double
        precision.
    """

    points: np.ndarray
    normals: np.ndarray | None = None
    within: float = COINCIDENT**2

    def __post_init__(self) -> None:
        for name in ("points", "normals"):
            values = getattr(self, name)
            if values is None:
                continue
            values = np.ascontiguousarray(real_array(name, values))
            object.__setattr__(self, name, values)
            if values.ndim != 2 or values.shape[1] != 3 or not values.size:
                raise ValueError(f"{name} must be (n, 3), n > 0, got {values.shape}")
        if self.normals is not None and self.normals.shape != self.points.shape:
            raise ValueError(f"{self.normals.shape[0]} normals for {self.n} points")
        if not REACH[0] <= self.extent <= REACH[1]:
            raise ValueError(
                f"the points extend over {self.extent:.3g}: beyond double precision's reach "
                f"({REACH[0]:g} to {REACH[1]:g}); choose another unit of length"
            )

    @property
    def n(self) -> int:
        return self.points.shape[0]

    @cached_property
    def extent(self) -> float:
        """The power of two above the largest extent of the points along an axis; 1 of one point."""
        largest = float(np.ptp(self.points, axis=0).max())
        return float(np.ldexp(1.0, np.frexp(largest)[1])) if largest > 0.0 else 1.0

    @cached_property
    def scaled(self) -> np.ndarray:
        """Positions ``(3, n)`` over the extent, without rounding."""
        return np.ascontiguousarray(self.points.T / self.extent)

    @cached_property
    def scaled_normals(self) -> np.ndarray:
        """Normals ``(3, n)``, or ``(3, 0)`` for the single layer."""
        return np.zeros((3, 0)) if self.normals is None else np.ascontiguousarray(self.normals.T)

    @property
    def factor(self) -> float:
        """Kernel in true units over kernel in scaled ones."""
        return self.extent ** (-1.0 if self.normals is None else -2.0)

    def with_axes(self, axes: Sequence[int]) -> PointKernel:
        """The same kernel with the axes of coordinates in another order."""
        normals = None if self.normals is None else self.normals[:, axes]
        return replace(self, points=self.points[:, axes], normals=normals)

    def ordered(self, order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Scaled positions ``(3, n)`` and normals, ``(3, n)`` or ``(3, 0)``, in some order."""
        normals = self.scaled_normals if self.normals is None else self.scaled_normals[:, order]
        return np.ascontiguousarray(self.scaled[:, order]), np.ascontiguousarray(normals)

    def sums_between(
        self,
        targets: tuple[np.ndarray, np.ndarray],
        target_ptr: np.ndarray,
        sources: tuple[np.ndarray, np.ndarray],
        source_ptr: np.ndarray,
        partner_ptr: np.ndarray,
        partners: np.ndarray,
        x: np.ndarray,
        y: np.ndarray,
    ) -> None:
        """Add sums between clusters of `ordered` points to ``y (k, 3, n)``."""
        over(
            target_ptr.size - 1, kernels.cluster_sums, targets[0], target_ptr, sources[0],
            source_ptr, sources[1], partner_ptr, partners, x, self.within, y,
        )  # fmt: skip

    def rows(self, targets: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Exact scaled sums at some points, ``(k, 3, n_targets)``, in double precision."""
        groups = np.append(np.arange(0, targets.size, GROUP), targets.size)
        out = np.zeros((x.shape[0], 3, targets.size))
        count = groups.size - 1
        over(
            count,
            kernels.cluster_sums,
            np.ascontiguousarray(self.scaled[:, targets]),
            groups,
            self.scaled,
            np.array([0, self.n]),
            self.scaled_normals,
            np.arange(count + 1),
            np.zeros(count, dtype=np.int64),
            np.ascontiguousarray(x),
            self.within,
            out,
        )
        return out


def components_first(x: np.ndarray) -> np.ndarray:
    """Densities ``(n, 3, k)`` as ``(k, 3, n)``."""
    if np.iscomplexobj(x):
        raise ValueError("complex densities: multiply by real and imaginary part apart")
    return np.ascontiguousarray(np.moveaxis(x, 2, 0).swapaxes(1, 2), dtype=float)


def multiply_components(matrix: spmatrix, x: np.ndarray) -> np.ndarray:
    """Sparse ``matrix (m, n)`` times ``x (k, 3, n)``: ``(k, 3, m)``."""
    flat = matrix @ x.reshape(-1, x.shape[-1]).T
    return np.ascontiguousarray(flat.T).reshape(*x.shape[:2], -1)


def checked_basis(basis: spmatrix, kernel: PointKernel) -> csc_matrix:
    """Weighted functions as sorted columns.

    Raises
    ------
    ValueError
        Rows that are not the kernel's points, or functions without points.
    """
    basis = csc_matrix(basis)
    if basis.shape[0] != kernel.n:
        raise ValueError(f"basis has {basis.shape[0]} rows for {kernel.n} points")
    if (np.diff(basis.indptr) == 0).any():
        raise ValueError("basis has functions without points")
    basis.sort_indices()
    return basis


def probe_densities(n: int, seed: int) -> np.ndarray:
    """Random densities, then the three constant ones, ``(n, 3, TEST_RANDOM + 3)``."""
    random = np.random.default_rng(seed).standard_normal((n, 3, TEST_RANDOM))
    return np.concatenate([random, np.tile(np.eye(3), (n, 1, 1))], axis=2)
