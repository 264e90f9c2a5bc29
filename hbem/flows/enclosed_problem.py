"""What a flow enclosed by a membrane is, apart from its configuration and from any numerics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..surfaces.patches import SurfacePatches
from .admissible import check_viscosities

Profile = Callable[[np.ndarray], np.ndarray]
Velocity = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class EnclosedProblem:
    """A checked problem; the parameters are those of `hbem.EnclosedStokes`.

    Parameters
    ----------
    patches : SurfacePatches
    inflow : (n_elements,) bool array
    profile : callable or None
    mass_ratio, viscosity_ratio : float
    background : callable or None

    Raises
    ------
    ValueError
        Values that are impossible or contradict each other.
    """

    patches: SurfacePatches
    inflow: np.ndarray
    profile: Profile | None
    mass_ratio: float
    viscosity_ratio: float = 1.0
    background: Velocity | None = None

    def __post_init__(self) -> None:
        inflow = np.asarray(self.inflow, dtype=bool)
        object.__setattr__(self, "inflow", inflow)
        check_viscosities(1.0, self.viscosity_ratio, background=self.background is not None)
        if np.iscomplexobj(self.mass_ratio) or not 0.0 < self.mass_ratio < np.inf:
            raise ValueError(f"mass_ratio must be finite and positive, got {self.mass_ratio}")
        if inflow.shape != (self.patches.n_elements,):
            raise ValueError(
                f"inflow must mark {self.patches.n_elements} elements, got shape {inflow.shape}"
            )
        if inflow.all():
            raise ValueError("inflow must leave some elements to the membrane")
        if inflow.any() != (self.profile is not None):
            raise ValueError(
                "an inlet needs a profile, a membrane without inlet takes profile = None"
            )
