"""IQN-ILS: interface quasi-Newton with an inverse Jacobian from least squares.

From residuals r and outputs y = G(x), columns dR = r_k - r_{k-1} and dY = y_k - y_{k-1} give
``x_{k+1} = y_k + dY c``, c minimising ``|r_k + dR c|`` (Degroote et al. 2009). Columns of past
steps are reused. Filter: Gram-Schmidt from the newest to the oldest, a column whose orthogonal
part is below ``filter`` of its length is dropped; the newest is always kept.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class QuasiNewtonMemory:
    """Differences, newest first, the step each belongs to (0 the present one), last iterate.

    ``residuals`` and ``outputs`` are ``(n, k)``; ``factor`` is what the log shows: 1 once
    columns are in use, else the starting relaxation.
    """

    factor: float
    residuals: np.ndarray | None = None
    outputs: np.ndarray | None = None
    ages: np.ndarray | None = None
    residual: np.ndarray | None = None
    output: np.ndarray | None = None

    @property
    def columns(self) -> int:
        return 0 if self.residuals is None else self.residuals.shape[1]


@dataclass(frozen=True)
class QuasiNewton:
    """IQN-ILS as a `relaxation.Relaxation`.

    Parameters
    ----------
    initial : float
        Relaxation while there are no columns.
    reuse : int
        Past steps whose columns are kept.
    filter : float
        Smallest relative orthogonal part of a column.
    most : int
        Largest number of columns.
    """

    initial: float = 0.5
    reuse: int = 8
    filter: float = 1e-2
    most: int = 60

    def init(self) -> QuasiNewtonMemory:
        return QuasiNewtonMemory(self.initial)

    def step(
        self, memory: QuasiNewtonMemory, x: np.ndarray, residual: np.ndarray
    ) -> tuple[np.ndarray, QuasiNewtonMemory]:
        """Next iterate after ``x`` with ``residual = G(x) - x``, and memory."""
        r, y = residual.ravel(), (x + residual).ravel()
        memory = replace(self._extended(memory, r, y), residual=r, output=y)
        if memory.columns == 0:
            return x + self.initial * residual, memory
        kept, q, upper = filtered(memory.residuals, self.filter)
        memory = replace(
            memory,
            factor=1.0,
            residuals=memory.residuals[:, kept],
            outputs=memory.outputs[:, kept],
            ages=memory.ages[kept],
        )
        weights = np.linalg.solve(upper, -(q.T @ r))
        return (y + memory.outputs @ weights).reshape(x.shape), memory

    def _extended(self, m: QuasiNewtonMemory, r: np.ndarray, y: np.ndarray) -> QuasiNewtonMemory:
        """Memory with the newest difference in front, unless it vanishes."""
        if m.residual is None or not np.any(r - m.residual):
            return m
        dr, dy, age = (r - m.residual)[:, None], (y - m.output)[:, None], np.zeros(1, dtype=int)
        if m.columns:
            dr = np.hstack([dr, m.residuals])[:, : self.most]
            dy = np.hstack([dy, m.outputs])[:, : self.most]
            age = np.append(age, m.ages)[: self.most]
        return replace(m, residuals=dr, outputs=dy, ages=age)

    def next_step(self, memory: QuasiNewtonMemory) -> QuasiNewtonMemory:
        """Memory for a new step: columns age, differences across steps are not formed."""
        fresh = QuasiNewtonMemory(self.initial)
        if not memory.columns:
            return fresh
        keep = memory.ages < self.reuse
        if not keep.any():
            return fresh
        return replace(
            fresh,
            residuals=memory.residuals[:, keep],
            outputs=memory.outputs[:, keep],
            ages=memory.ages[keep] + 1,
        )

    def pack(self, memory: QuasiNewtonMemory) -> dict[str, np.ndarray]:
        """Arrays for a checkpoint."""
        if not memory.columns:
            return {}
        return {"residuals": memory.residuals, "outputs": memory.outputs, "ages": memory.ages}

    def unpack(self, arrays: Mapping[str, np.ndarray]) -> QuasiNewtonMemory:
        """Memory from what `pack` wrote."""
        return replace(self.init(), **{k: arrays[k] for k in ("residuals", "outputs", "ages")
                                       if k in arrays})  # fmt: skip


def filtered(columns: np.ndarray, limit: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Indices kept, Q and R of the kept columns; the first column is never dropped.

    Parameters
    ----------
    columns : (n, k) array
        Newest first.
    limit : float
        Smallest orthogonal part relative to a column's length.
    """
    kept: list[int] = []
    q = np.empty((columns.shape[0], min(columns.shape)))
    upper = np.zeros((q.shape[1], q.shape[1]))
    for j in range(columns.shape[1]):
        k = len(kept)
        if k == q.shape[1]:
            break
        v, c = columns[:, j].copy(), np.zeros(k)
        for _ in range(2):  # twice is enough for orthogonality to rounding
            d = q[:, :k].T @ v
            v -= q[:, :k] @ d
            c += d
        size = np.linalg.norm(v)
        if kept and size < limit * np.linalg.norm(columns[:, j]):
            continue
        q[:, k], upper[:k, k], upper[k, k] = v / size, c, size
        kept.append(j)
    k = len(kept)
    return np.array(kept), q[:, :k], upper[:k, :k]
