"""The point kernel that is compressed: ``G`` between points in scaled positions, summed exactly."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from . import _cluster_sum_kernels as kernels

COINCIDENT = 1e-12  # distances below this fraction of the extent are the same point
GROUP = 64  # targets of a direct sum that share a sweep


@dataclass(frozen=True)
class PointKernel:
    """Plain kernel ``G = (I/r + r r/r^3)/8 pi``, or the double layer if normals are given.

    Positions are centred and scaled by their extent, so that thresholds have no units.

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
        Wrong shapes or values that are not finite.
    """

    points: np.ndarray
    normals: np.ndarray | None = None
    within: float = COINCIDENT**2

    def __post_init__(self) -> None:
        for name in ("points", "normals"):
            values = getattr(self, name)
            if values is None:
                continue
            values = np.ascontiguousarray(values, dtype=float)
            object.__setattr__(self, name, values)
            if values.ndim != 2 or values.shape[1] != 3 or not values.size:
                raise ValueError(f"{name} must be (n, 3), n > 0, got {values.shape}")
            if not np.isfinite(values).all():
                raise ValueError(f"{name} are not finite")
        if self.normals is not None and self.normals.shape != self.points.shape:
            raise ValueError(f"{self.normals.shape[0]} normals for {self.n} points")

    @property
    def n(self) -> int:
        return self.points.shape[0]

    @cached_property
    def extent(self) -> float:
        return float(np.linalg.norm(np.ptp(self.points, axis=0))) or 1.0

    @cached_property
    def scaled(self) -> np.ndarray:
        """Positions ``(3, n)``, centred, extent one."""
        middle = 0.5 * (self.points.max(axis=0) + self.points.min(axis=0))
        return np.ascontiguousarray(((self.points - middle) / self.extent).T)

    @cached_property
    def scaled_normals(self) -> np.ndarray:
        """Normals ``(3, n)``, or ``(3, 0)`` for the single layer."""
        return np.zeros((3, 0)) if self.normals is None else np.ascontiguousarray(self.normals.T)

    @property
    def factor(self) -> float:
        """Kernel in true units over kernel in scaled ones."""
        return self.extent ** (-1.0 if self.normals is None else -2.0)

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
        kernels.cluster_sums(
            targets[0], target_ptr, sources[0], source_ptr, sources[1], partner_ptr, partners, x,
            self.within, y,
        )  # fmt: skip

    def rows(self, targets: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Exact scaled sums at some points, ``(k, 3, n_targets)``, in double precision."""
        groups = np.append(np.arange(0, targets.size, GROUP), targets.size)
        out = np.zeros((x.shape[0], 3, targets.size))
        count = groups.size - 1
        kernels.cluster_sums(
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
