"""Contact of planar curves: whether the sampled membrane meets itself or the inlet."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from coupling import Result
from hbem.planar.polygon import crossing, meeting


@dataclass(frozen=True)
class CurveCollision:
    """Test of motions of a closed curve, in the shape of `Collision`.

    Parameters
    ----------
    curve : callable
        Coefficients ``(n_full, 2)`` to points ``(n, 2)`` in order, those of the inlet last.
    n_inlet : int
        Segments of the inlet.
    """

    curve: Callable[[np.ndarray], np.ndarray]
    n_inlet: int

    def inspect(self, before: np.ndarray, after: np.ndarray) -> Result | None:
        """Why ``after`` cannot be reached straight from the free ``before``; None if it can."""
        start, end = self.curve(before), self.curve(after)
        pair = crossing(end) or meeting(start, end)
        if pair is None:
            return None
        inlet = max(pair) >= end.shape[0] - self.n_inlet
        return Result.INLET_CONTACT if inlet else Result.SELF_INTERSECTION
