"""FoldPanels of a folded bag: which elements they are, and how far they have turned."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from shells.surfaces.local_elements import middle

from .bag import Bag
from .folding import Folding


@dataclass(frozen=True)
class FoldPanels:
    """The panels between the folds of a bag.

    Attributes
    ----------
    bag : Bag
    folding : Folding
    flat : (n_full, 3) array
        The unfolded bag, as the folding takes it.
    """

    bag: Bag
    folding: Folding
    flat: np.ndarray

    @classmethod
    def of(cls, bag: Bag) -> FoldPanels | None:
        """Those of a folded bag; None of others."""
        if bag.folding is None or bag.flat is None:
            return None
        return cls(bag, bag.folding, bag.flat)

    @cached_property
    def cells(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Membrane elements of the upper and the lower sheet of each panel."""
        membrane = self.bag.membrane
        xi, eta, _ = middle(membrane.shape)
        x, z = (membrane.sample(xi, eta) @ self._sheet)[:, [0, 2]].T
        return [
            (np.flatnonzero((x >= a) & (x <= b) & (z > 0)),
             np.flatnonzero((x >= a) & (x <= b) & (z < 0)))
            for a, b in self.folding.panels
        ]  # fmt: skip

    @property
    def _sheet(self) -> np.ndarray:
        return self.flat[: self.bag.n_membrane]

    def _rotation(self, c: np.ndarray) -> np.ndarray:
        """Rotation that takes the flat membrane nearest to coefficients ``c`` (Kabsch)."""
        flat = self._sheet
        moved = (flat - flat.mean(axis=0)).T @ (c - c.mean(axis=0))
        u, _, vt = np.linalg.svd(moved)
        sign = np.sign(np.linalg.det(u @ vt))
        return vt.T @ np.diag([1.0, 1.0, sign]) @ u.T

    @cached_property
    def _tangents(self) -> tuple[csr_matrix, csr_matrix]:
        membrane = self.bag.membrane
        xi, eta, _ = middle(membrane.shape)
        s, t = (membrane.sample(xi, eta, k) for k in (0, 1))
        return s, t

    def angles(self, coefficients: np.ndarray, *, aligned: bool = True) -> np.ndarray:
        """Angle in degrees of each panel's normal with that of the flat bag.

        A panel's normal is the mean of both its sheets, by area. The flat bag lies in the
        rigid position nearest to the configuration, because an open bag may tilt about its
        inlet; ``aligned=False`` leaves it where it was cut, normal to z.
        """
        c = coefficients[: self.bag.n_membrane]
        s, t = (tangent @ c for tangent in self._tangents)
        normal = np.cross(s, t)
        means = np.array(
            [normal[upper].sum(axis=0) - normal[lower].sum(axis=0) for upper, lower in self.cells]
        )
        up = self._rotation(c)[:, 2] if aligned else np.array([0.0, 0.0, 1.0])
        cosine = means @ up / np.linalg.norm(means, axis=1)
        return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
