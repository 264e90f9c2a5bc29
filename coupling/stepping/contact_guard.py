"""What stands between a run and a configuration that it must not reach."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..contact.watch import Watch
from ..exchange import Result
from ..protocols import CollisionTest


@dataclass
class ContactGuard:
    """Tests configurations from when on that is due, and tells once when it starts.

    Parameters
    ----------
    test : CollisionTest or None
    watch : Watch or None
        None: a test is always due.
    tell : callable
        Receives the sentence that says why the test starts.
    """

    test: CollisionTest | None
    watch: Watch | None
    tell: Callable[[str], None]
    started: bool = False

    def inspect(
        self,
        step: int,
        before: np.ndarray,
        after: np.ndarray,
        gap: float,
        volume: float,
        straight: bool = True,
    ) -> Result | None:
        """Say why a configuration cannot be reached from the accepted one; None if it can.

        Parameters
        ----------
        step : int
            That leads from one to the other.
        before, after : (n_full, 3) array
        gap : float
            Smallest gap before.
        volume : float
            The smaller of the volumes before and after.
        straight : bool
            Whether the straight way between them counts; else only where it ends.
        """
        if not np.all(np.isfinite(after)):
            return Result.GEOMETRY
        if self.test is None or not self._due(step, after - before, gap, volume):
            return None
        return self.test.inspect(before if straight else after, after)

    def _due(self, step: int, motion: np.ndarray, gap: float, volume: float) -> bool:
        if self.watch is None:
            return True
        why = self.watch.reason(gap, volume, float(np.linalg.norm(motion, axis=1).max()))
        if why and not self.started:
            self.started = True
            self.tell(f"self-intersection test: on since step {step}, because {why}")
        return bool(why)
