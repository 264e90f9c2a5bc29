"""A fluid whose operator is reused while the geometry moves too little to matter.

In a film of thickness H the traction goes with H^-3: both sheets moved by d change it by the
fraction ``6 d / H``. The operator is reused while the traction would change by less than a given
share of its tolerance.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..protocols import Fluid, FluidOperator
from ..schemes.scheme import StepResult


def reach(tolerance: float, gap: float, share: float) -> float:
    """Displacement that changes the traction by ``share`` of its tolerance in a gap.

    Parameters
    ----------
    tolerance : float
        Relative error of the traction.
    gap : float
        Narrowest thickness H of a film.
    share : float
    """
    return share * tolerance * gap / 6.0


@dataclass
class OperatorReuse:
    """A `Fluid` around another one that assembles only where the geometry has moved.

    Parameters
    ----------
    fluid : Fluid
    reach : float
        Largest displacement of a coefficient, which bounds that of the surface.
    saved : int
        Count of assemblies that were not needed.
    """

    fluid: Fluid
    reach: float
    saved: int = 0
    _geometry: np.ndarray | None = field(default=None, init=False, repr=False)
    _operator: FluidOperator[Any] | None = field(default=None, init=False, repr=False)

    @property
    def statistics(self) -> Mapping[str, Any]:
        """What the fluid tells of its operators, for run.json; empty if it tells nothing."""
        return getattr(self.fluid, "statistics", {})

    def assemble(self, coefficients: np.ndarray) -> FluidOperator[Any]:
        """Assemble a geometry, or return the last operator if that is as good.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        FluidOperator
        """
        if self._geometry is not None and self._operator is not None:
            moved = np.linalg.norm(coefficients - self._geometry, axis=-1).max()
            if moved <= self.reach:
                self.saved += 1
                return self._operator
        operator = self.fluid.assemble(coefficients)
        self._geometry, self._operator = coefficients.copy(), operator
        return operator

    def reset(self) -> None:
        """Forget the operator, at checkpoints: a resumed run starts without it."""
        self._geometry = self._operator = None
        self.fluid.reset()


def without_reused(
    fluid: Fluid | None, attempt: Callable[[], StepResult]
) -> tuple[StepResult, int]:
    """A scheme's answer in which reused operators are no assemblies, but notes; and their number.

    Parameters
    ----------
    fluid : Fluid or None
    attempt : callable

    Returns
    -------
    StepResult
    int
    """
    if not isinstance(fluid, OperatorReuse):
        return attempt(), 0
    before, result = fluid.saved, attempt()
    reused = fluid.saved - before
    note = "operator reused: the geometry moved less than the traction's tolerance"
    notes = (*[note] * reused, *result.notes)
    return replace(result, assemblies=result.assemblies - reused, notes=notes), reused
