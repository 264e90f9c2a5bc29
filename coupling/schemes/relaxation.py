"""Relaxation of fixed-point iterations ``x <- x + w (G(x) - x)``.

All schemes have one shape: `init` makes an immutable memory, `step` returns the next iterate and
memory, `next_step` carries memory to the next time step. Aitken: ``w <- -w <r_old, dr> /
<dr, dr>``; a new step starts with ``sign(w) min(w0, |w|)``; rejections start afresh.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np


@dataclass(frozen=True)
class Memory:
    """Relaxation factor of the last iteration and its residual (None at a step's start)."""

    factor: float
    residual: np.ndarray | None = None


class Relaxation(Protocol):
    """What `fixed_point` asks of a relaxation; memories have a ``factor`` for the log."""

    def init(self) -> Any: ...

    def step(self, memory: Any, x: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, Any]: ...

    def next_step(self, memory: Any) -> Any: ...

    def pack(self, memory: Any) -> dict[str, np.ndarray]:
        """What a checkpoint keeps, as arrays."""

    def unpack(self, arrays: Mapping[str, np.ndarray]) -> Any:
        """Memory from what `pack` wrote."""


class _Factor:
    """Checkpoints of relaxations whose memory is a factor."""

    def pack(self, memory: Memory) -> dict[str, np.ndarray]:
        return {"factor": np.array(memory.factor)}

    def unpack(self, arrays: Mapping[str, np.ndarray]) -> Memory:
        return Memory(float(arrays["factor"]))


@dataclass(frozen=True)
class Constant(_Factor):
    """A fixed factor in (0, 1]; 1 is Gauss-Seidel.

    Raises
    ------
    ValueError
        For a factor outside (0, 1].
    """

    factor: float = 0.5

    def __post_init__(self) -> None:
        if not 0.0 < self.factor <= 1.0:
            raise ValueError(f"a relaxation factor lies in (0, 1], got {self.factor}")

    def init(self) -> Memory:
        return Memory(self.factor)

    def step(
        self, memory: Memory, x: np.ndarray, residual: np.ndarray
    ) -> tuple[np.ndarray, Memory]:
        return x + self.factor * residual, memory

    def next_step(self, memory: Memory) -> Memory:
        return memory


def GaussSeidel() -> Constant:
    """No relaxation [T tab. 5.1]."""
    return Constant(1.0)


@dataclass(frozen=True)
class Aitken(_Factor):
    """Dynamic relaxation from the last two residuals."""

    initial: float = 0.5

    def init(self) -> Memory:
        return Memory(self.initial)

    def step(
        self, memory: Memory, x: np.ndarray, residual: np.ndarray
    ) -> tuple[np.ndarray, Memory]:
        factor = memory.factor
        if memory.residual is not None:
            change = residual - memory.residual
            square = float(np.vdot(change, change))
            if square > 0.0:
                factor = -factor * float(np.vdot(memory.residual, change)) / square
        return x + factor * residual, Memory(factor, residual)

    def next_step(self, memory: Memory) -> Memory:
        bounded = np.sign(memory.factor) * min(self.initial, abs(memory.factor))
        return replace(memory, factor=float(bounded) or self.initial, residual=None)
