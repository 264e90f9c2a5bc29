"""Membrane and bending energy at one set of points of all elements, with its variations."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from .. import _shell_kernels as kernels
from ..material import Material
from .jet_sums import JetSums
from .point_tables import PointTables


class PointEnergy:
    """What one set of points adds to a shell's energy.

    Parameters
    ----------
    tables : PointTables
    material : Material
    dofs : (n_elements, n_functions) int array
    share : float
        As in `KirchhoffLove`.
    """

    def __init__(self, tables: PointTables, material: Material, dofs: np.ndarray, share: float):
        self._tables, self._share = tables, share
        self._sums = JetSums(tables.jets, dofs)
        self._weights = tables.weights.copy()
        self._weights[1] *= material.flexural_rigidity
        self._stretches, self._bends = (bool(w.any()) for w in self._weights)

    @cached_property
    def _base(self) -> np.ndarray | None:
        return self._tables.base if self._tables.base.any() else None

    def _jets(self, x: np.ndarray, part: slice) -> np.ndarray:
        g = self._sums.jets(x, part)
        return g if self._base is None else g + self._base[part].reshape(g.shape)

    def energy(self, x: np.ndarray, part: slice) -> np.ndarray:
        """Membrane and bending energy (2,) of some elements at coefficients ``x (n, 3)``."""
        t, g = self._tables, self._jets(x, part)
        out = np.empty((len(g), 2))
        metric, curvature, C = _flat(part, t.metric, t.curvature, t.elasticity)
        weights = np.ascontiguousarray(self._weights[:, part]).reshape(2, -1)
        kernels.energy(g, weights, metric, curvature, C, self._share, out, np.empty(kernels.WORK))
        return out.sum(axis=0)

    def variations(
        self, x: np.ndarray, tangent: bool, part: slice
    ) -> tuple[np.ndarray, np.ndarray]:
        """First variation (n, m, 3) of some elements and, if asked for, second (n, m, 6, m)."""
        t, g = self._tables, self._jets(x, part)
        (S, H), work = self._sums.zeros(part, tangent), np.empty(kernels.WORK)
        stretch, bend, metric, curvature, C = _flat(
            part, *self._weights, t.metric, t.curvature, t.elasticity
        )
        if self._stretches:
            kernels.membrane(g, stretch, metric, C, self._share, tangent, S, H, work)
        if self._bends:
            kernels.bending(g, bend, curvature, C, tangent, S, H, work)
        return self._sums.force(S, part), self._sums.tangent(H, part)


def _flat(part: slice, *arrays: np.ndarray) -> list[np.ndarray]:
    """Arrays (n_elements, n_points, ...) by points of some elements."""
    return [a[part].reshape(-1, *a.shape[2:]) for a in arrays]
