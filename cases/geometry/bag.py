"""A bag: a membrane and its inlet, if any, with one array of coefficients."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from shells.surfaces.tensor_surface import TensorSurface


@dataclass(frozen=True)
class Bag:
    """Initial geometry of a scene.

    Attributes
    ----------
    membrane, inlet : TensorSurface
        The moving surface and the fixed inlet (None of a closed membrane); both normals point
        out of the bag.
    coefficients : (n_full, 3) array
        Membrane coefficients, then those of the inlet.
    support : callable
        Extraction ``(3 n_full, n_free)`` of a rim that is "hinged" or "clamped" to the inlet.
    profile : callable
        Inflow profile X on points (n, 3) of the inlet, zero at its rim [T 6.3.3]; None without.
    gap, extent : float
        Sheet distance H and lateral extent l of the narrowest region, for forecasts.
    exact_volume : float
        Volume of the body that was fitted.
    fit_error : float
        Largest distance between the fitted and the exact surface.
    """

    membrane: TensorSurface
    inlet: TensorSurface | None
    coefficients: np.ndarray
    support: Callable[[str], csr_matrix]
    profile: Callable[[np.ndarray], np.ndarray] | None
    gap: float
    extent: float
    exact_volume: float
    fit_error: float

    @property
    def n_membrane(self) -> int:
        return self.membrane.n_coefficients

    @property
    def parts(self) -> tuple[TensorSurface, ...]:
        """Membrane, then inlet where there is one."""
        return (self.membrane,) if self.inlet is None else (self.membrane, self.inlet)
