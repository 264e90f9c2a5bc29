"""A fluid that keeps its operator while the geometry moves too little to matter.

In a film of thickness H the traction goes with H^-3: both sheets moved by d change it by the
fraction ``6 d / H``. Within that share of the traction error which the fluid allows anyway, a new
assembly tells nothing new.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..protocols import Fluid, FluidOperator


def reach(tolerance: float, gap: float, share: float) -> float:
    """Displacement that changes the traction by ``share`` of its tolerance in a gap."""
    return share * tolerance * gap / 6.0


@dataclass
class KeptOperators:
    """`Fluid` around another one.

    Parameters
    ----------
    fluid : Fluid
    reach : float
        Largest displacement of a coefficient, which bounds that of the surface.

    Attributes
    ----------
    saved : int
        Assemblies that were not needed.
    """

    fluid: Fluid
    reach: float
    saved: int = 0
    _geometry: np.ndarray | None = field(default=None, repr=False)
    _operator: FluidOperator | None = field(default=None, repr=False)

    def assemble(self, coefficients: np.ndarray) -> FluidOperator:
        """The operator of this geometry, or the last one if that is as good."""
        if self._geometry is not None:
            moved = np.linalg.norm(coefficients - self._geometry, axis=-1).max()
            if moved <= self.reach:
                self.saved += 1
                return self._operator
        self._geometry, self._operator = coefficients.copy(), self.fluid.assemble(coefficients)
        return self._operator

    def reset(self) -> None:
        """Forget the operator, at checkpoints: a resumed run starts without it."""
        self._geometry = self._operator = None
        self.fluid.reset()

    @property
    def statistics(self) -> Any:
        """Those of the fluid."""
        return getattr(self.fluid, "statistics", {})
