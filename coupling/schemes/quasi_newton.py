"""IQN-ILS: interface quasi-Newton with an inverse Jacobian from least squares.

From residuals r and outputs y = G(x), columns dR = r_k - r_{k-1} and dY = y_k - y_{k-1} give
``x_{k+1} = y_k + dY c``, c minimising ``|r_k + dR c|`` (Degroote et al. 2009). Columns of past
steps are reused. Filter: Gram-Schmidt from the newest to the oldest, a column whose orthogonal
part is below ``filter`` of its length is dropped; the newest always stays.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from .relaxation import Relaxation


@dataclass(frozen=True)
class Differences:
    """Columns dR and dY, newest first.

    Attributes
    ----------
    residuals, outputs : (n, k) arrays
    ages : (k,) int array
        Time steps since each column was made; 0 in the present one.
    """

    residuals: np.ndarray
    outputs: np.ndarray
    ages: np.ndarray

    def select(self, index: np.ndarray | slice) -> Differences:
        """Some of the columns."""
        return Differences(self.residuals[:, index], self.outputs[:, index], self.ages[index])


@dataclass(frozen=True)
class QuasiNewtonMemory:
    """What IQN-ILS remembers.

    Attributes
    ----------
    factor : float
        What the log shows: 1 once columns are in use, else the starting relaxation.
    differences : Differences, optional
    last : tuple of two (n,) arrays, optional
        Residual and output of the last iteration of this time step.
    """

    factor: float
    differences: Differences | None = None
    last: tuple[np.ndarray, np.ndarray] | None = None

    @property
    def columns(self) -> int:
        """Number of columns."""
        return 0 if self.differences is None else self.differences.ages.size


@dataclass(frozen=True)
class QuasiNewton(Relaxation[QuasiNewtonMemory]):
    """IQN-ILS: a relaxation by differences of the last iterations and time steps.

    Parameters
    ----------
    initial : float
        Relaxation while there are no columns.
    reuse : int
        Past time steps whose columns are reused.
    filter : float
        Smallest relative orthogonal part of a column.
    max_columns : int
        Largest number of columns.
    """

    initial: float = 0.5
    reuse: int = 8
    filter: float = 1e-2
    max_columns: int = 60

    def init(self) -> QuasiNewtonMemory:
        return QuasiNewtonMemory(self.initial)

    def step(
        self, memory: QuasiNewtonMemory, x: np.ndarray, residual: np.ndarray
    ) -> tuple[np.ndarray, QuasiNewtonMemory]:
        r, y = residual.ravel(), (x + residual).ravel()
        found = self._extend(memory, r, y)
        if found is None:
            return x + self.initial * residual, replace(memory, differences=None, last=(r, y))
        selected, q, upper = filter_columns(found.residuals, self.filter)
        found = found.select(selected)
        weights = np.linalg.solve(upper, -(q.T @ r))
        new = (y + found.outputs @ weights).reshape(x.shape)
        return new, QuasiNewtonMemory(1.0, found, (r, y))

    def _extend(self, m: QuasiNewtonMemory, r: np.ndarray, y: np.ndarray) -> Differences | None:
        """Differences with the newest in front, unless it vanishes."""
        old = m.differences
        if m.last is None or not np.any(r - m.last[0]):
            return old
        dr, dy = (r - m.last[0])[:, None], (y - m.last[1])[:, None]
        new = Differences(dr, dy, np.zeros(1, dtype=int))
        if old is None:
            return new
        joined = Differences(
            np.hstack([dr, old.residuals]),
            np.hstack([dy, old.outputs]),
            np.append(new.ages, old.ages),
        )
        return joined.select(slice(self.max_columns))

    def next_step(self, memory: QuasiNewtonMemory) -> QuasiNewtonMemory:
        old = memory.differences
        if old is None or not (old.ages < self.reuse).any():
            return QuasiNewtonMemory(self.initial)
        # columns age; differences across time steps are not formed
        young = old.select(old.ages < self.reuse)
        return QuasiNewtonMemory(self.initial, replace(young, ages=young.ages + 1))

    def pack(self, memory: QuasiNewtonMemory) -> dict[str, np.ndarray]:
        return {} if memory.differences is None else dict(vars(memory.differences))

    def unpack(self, arrays: Mapping[str, np.ndarray]) -> QuasiNewtonMemory:
        if "residuals" not in arrays:
            return self.init()
        columns = Differences(arrays["residuals"], arrays["outputs"], arrays["ages"])
        return QuasiNewtonMemory(self.initial, columns)


def filter_columns(columns: np.ndarray, limit: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Indices of independent columns, their Q and R; the first column is never dropped.

    Parameters
    ----------
    columns : (n, k) array
        Newest first.
    limit : float
        Smallest orthogonal part relative to a column's length.
    """
    chosen: list[int] = []
    q = np.empty((columns.shape[0], min(columns.shape)))
    upper = np.zeros((q.shape[1], q.shape[1]))
    for j in range(columns.shape[1]):
        k = len(chosen)
        if k == q.shape[1]:
            break
        v, c = columns[:, j].copy(), np.zeros(k)
        for _ in range(2):  # twice is enough for orthogonality to rounding
            d = q[:, :k].T @ v
            v -= q[:, :k] @ d
            c += d
        size = np.linalg.norm(v)
        if chosen and size < limit * np.linalg.norm(columns[:, j]):
            continue
        q[:, k], upper[:k, k], upper[k, k] = v / size, c, size
        chosen.append(j)
    k = len(chosen)
    return np.array(chosen), q[:, :k], upper[:k, :k]
