"""A preconditioner kept from one geometry to the next while it serves."""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass, field

from .saddle_system import Builder, Preconditioner, SaddleSystem

logger = logging.getLogger(__name__)


@dataclass
class PreconditionerStore:
    """Keeps a preconditioner from one geometry to the next, until it degrades.

    The only mutable object of this package: a run must `drop` it at checkpoints, so that a
    resumed run does the same arithmetic.

    Parameters
    ----------
    build : callable
        Builds a preconditioner from a `SaddleSystem`.
    growth, slack : float, int
        It is rebuilt once a solve took more than ``growth`` times the iterations of its first
        solve plus ``slack``.

    Attributes
    ----------
    seconds : float
        Time of all builds.
    built : int
        Their number.
    """

    build: Builder
    growth: float = 1.5
    slack: int = 4
    seconds: float = 0.0
    built: int = 0
    _kept: Preconditioner | None = field(default=None, repr=False)
    _first: int | None = field(default=None, repr=False)
    _size: int = field(default=0, repr=False)

    def __call__(self, system: SaddleSystem) -> Preconditioner:
        """The kept preconditioner, or a new one."""
        if self._kept is None or self._size != system.size:
            start = time.perf_counter()
            self._kept, self._first, self._size = self.build(system), None, system.size
            self.seconds += time.perf_counter() - start
            self.built += 1
        return self._kept

    def note(self, iterations: int) -> None:
        """Tell how many iterations a solve took; drops a preconditioner that has degraded."""
        if self._first is None:
            self._first = iterations
        elif iterations > self.growth * self._first + self.slack:
            logger.info(
                "preconditioner dropped: %d iterations, %d at first", iterations, self._first
            )
            self.drop()

    def drop(self) -> None:
        """Forget the preconditioner."""
        self._kept, self._first = None, None
