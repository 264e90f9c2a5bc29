"""Relaxation of fixed-point iterations ``x <- x + w (G(x) - x)``.

All relaxations have one shape: `init` makes an immutable memory, `step` returns the next iterate
and memory, `next_step` carries memory to the next time step. Aitken: ``w <- -w <r_old, dr> /
<dr, dr>``, dr = r - r_old; a new step starts with ``sign(w) min(w0, |w|)``; rejections start
afresh.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

import numpy as np


class HasFactor(Protocol):
    """A relaxation's memory: whatever it holds, it has a factor for the log."""

    @property
    def factor(self) -> float: ...


M = TypeVar("M", bound=HasFactor)


@dataclass(frozen=True)
class RelaxationMemory:
    """Relaxation factor of the last iteration and its residual (None at a step's start)."""

    factor: float
    residual: np.ndarray | None = None


class Relaxation(Protocol[M]):
    """What `fixed_point` and `implicit` ask of a relaxation with memories of type M."""

    def init(self) -> M:
        """Make the memory of a first iteration.

        Returns
        -------
        M
        """

    def step(self, memory: M, x: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, M]:
        """Find the next iterate.

        Parameters
        ----------
        memory : M
        x : array
            Iterate.
        residual : array
            ``G(x) - x``.

        Returns
        -------
        array
            Next iterate.
        M
        """

    def next_step(self, memory: M) -> M:
        """Carry memory over to the next time step.

        Parameters
        ----------
        memory : M

        Returns
        -------
        M
        """

    def pack(self, memory: M) -> dict[str, np.ndarray]:
        """Store memory as arrays, for checkpoints.

        Parameters
        ----------
        memory : M

        Returns
        -------
        dict of arrays
        """

    def unpack(self, arrays: Mapping[str, np.ndarray]) -> M:
        """Make memory of what `pack` returned.

        Parameters
        ----------
        arrays : mapping of arrays

        Returns
        -------
        M
        """


class _FactorOnly:
    """Checkpoints of relaxations whose memory is a factor."""

    def pack(self, memory: RelaxationMemory) -> dict[str, np.ndarray]:
        return {"factor": np.array(memory.factor)}

    def unpack(self, arrays: Mapping[str, np.ndarray]) -> RelaxationMemory:
        return RelaxationMemory(float(arrays["factor"]))


@dataclass(frozen=True)
class Constant(_FactorOnly, Relaxation[RelaxationMemory]):
    """A fixed relaxation factor.

    Parameters
    ----------
    factor : float
        In (0, 1]; 1 is Gauss-Seidel.

    Raises
    ------
    ValueError
        For a factor outside (0, 1].
    """

    factor: float = 0.5

    def __post_init__(self) -> None:
        if not 0.0 < self.factor <= 1.0:
            raise ValueError(f"a relaxation factor lies in (0, 1], got {self.factor}")

    def init(self) -> RelaxationMemory:
        return RelaxationMemory(self.factor)

    def step(
        self, memory: RelaxationMemory, x: np.ndarray, residual: np.ndarray
    ) -> tuple[np.ndarray, RelaxationMemory]:
        return x + self.factor * residual, memory

    def next_step(self, memory: RelaxationMemory) -> RelaxationMemory:
        return memory


def GaussSeidel() -> Constant:
    """Iterate without relaxation [T tab. 5.1].

    Returns
    -------
    Constant
        With factor 1.
    """
    return Constant(1.0)


@dataclass(frozen=True)
class Aitken(_FactorOnly, Relaxation[RelaxationMemory]):
    """Dynamic relaxation from the last two residuals (Aitken's formula).

    Parameters
    ----------
    initial : float
        First factor of a run, and the largest magnitude that a later step starts with.
    """

    initial: float = 0.5

    def init(self) -> RelaxationMemory:
        return RelaxationMemory(self.initial)

    def step(
        self, memory: RelaxationMemory, x: np.ndarray, residual: np.ndarray
    ) -> tuple[np.ndarray, RelaxationMemory]:
        factor = memory.factor
        if memory.residual is not None:
            change = residual - memory.residual
            square = float(np.vdot(change, change))
            if square > 0.0:
                factor = -factor * float(np.vdot(memory.residual, change)) / square
        return x + factor * residual, RelaxationMemory(factor, residual)

    def next_step(self, memory: RelaxationMemory) -> RelaxationMemory:
        bounded = np.sign(memory.factor) * min(self.initial, abs(memory.factor))
        return replace(memory, factor=float(bounded) or self.initial, residual=None)
