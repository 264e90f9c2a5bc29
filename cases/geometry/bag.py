"""A bag: a membrane and its inlet, if any, with one array of coefficients."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from shells.surfaces.surface import Surface

from .folding import Folding


@dataclass(frozen=True)
class Bag:
    """Initial geometry of a scene.

    Attributes
    ----------
    membrane, inlet : Surface
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
    flat : (n_full, 3) array, optional
        The unfolded bag.
    folding : Folding, optional
        How it was folded from that.
    notes : tuple of str
        How it came about, where that is worth a line each.
    """

    membrane: Surface
    inlet: Surface | None
    coefficients: np.ndarray
    support: Callable[[str], csr_matrix]
    profile: Callable[[np.ndarray], np.ndarray] | None
    gap: float
    extent: float
    exact_volume: float
    fit_error: float
    flat: np.ndarray | None = None
    folding: Folding | None = None
    notes: tuple[str, ...] = ()

    @property
    def n_membrane(self) -> int:
        return self.membrane.n_coefficients

    @property
    def parts(self) -> tuple[Surface, ...]:
        """Membrane, then inlet where there is one."""
        return (self.membrane,) if self.inlet is None else (self.membrane, self.inlet)

    @property
    def cut(self) -> np.ndarray:
        """Coefficients of the cloth as it was cut: the unfolded bag, or the bag itself."""
        return self.coefficients if self.flat is None else self.flat

    @property
    def folds(self) -> Folding:
        """How it was folded; a ValueError for a bag that was not."""
        if self.folding is None:
            raise ValueError("this bag was not folded")
        return self.folding
