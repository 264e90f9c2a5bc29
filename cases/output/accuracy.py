"""The fluid's accuracy over a run: the budget before it, and what came of it.

Collects the smallest gap, the largest residual and the largest multiplier of the accepted steps;
`hbem.accuracy.review` judges them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hbem.accuracy import Budget, review

if TYPE_CHECKING:
    from coupling import AcceptedStep


@dataclass
class Accuracy:
    """Budget of a run and the extremes along it.

    Attributes
    ----------
    budget : Budget
    gap, extent : float
        Smallest gap so far and the extent of the narrowest region.
    residual, zeta : float
        Largest true residual, and largest multiplier over the largest velocity.
    """

    budget: Budget
    gap: float
    extent: float
    residual: float = 0.0
    zeta: float = 0.0

    def note(self, step: AcceptedStep) -> None:
        """Take an accepted step into account."""
        row = step.row
        self.gap = min(self.gap, row.get("min_gap", self.gap))
        fastest = row.get("velocity_max", 0.0)
        if step.traction is not None and fastest > 0.0:
            self.zeta = max(self.zeta, abs(step.traction.zeta) / fastest)
            self.residual = max(self.residual, step.traction.residual)

    def before(self) -> Mapping[str, object]:
        """The budget as plain numbers, with its warnings."""
        return {**self.budget.describe(), "warnings": list(self.budget.warnings)}

    def after(self) -> Mapping[str, object]:
        """What the run achieved."""
        return review(
            self.budget,
            gap=self.gap,
            extent=self.extent,
            residual=self.residual,
            zeta=self.zeta,
        )
