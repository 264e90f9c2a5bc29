"""Isotropic St. Venant-Kirchhoff material of a thin shell, in plane stress.

Non-dimensional: membrane stiffness E h / (1 - nu^2) = 1 by default; ``flexural_rigidity`` is the
ratio of bending to membrane stiffness, h^2 / 12 in units of length squared [T 2.8, 2.17].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Material:
    """What a thin isotropic shell is made of.

    Parameters
    ----------
    flexural_rigidity : float
        Bending over membrane stiffness, a length squared.
    stiffness : float
        Membrane stiffness ``E h / (1 - nu^2)``, force over length.
    poisson_ratio : float
    density : float
        Mass per reference area.

    Raises
    ------
    ValueError
        Non-positive stiffness, negative rigidity or density, Poisson ratio outside (-1, 1).
    """

    flexural_rigidity: float
    stiffness: float = 1.0
    poisson_ratio: float = 0.0
    density: float = 1.0

    def __post_init__(self) -> None:
        if self.stiffness <= 0 or self.flexural_rigidity < 0 or self.density < 0:
            raise ValueError("stiffness must be positive, rigidity and density not negative")
        if not -1.0 < self.poisson_ratio < 1.0:
            raise ValueError("the Poisson ratio must lie in (-1, 1)")

    def elasticity(self, inverse_metric: np.ndarray | None = None) -> np.ndarray:
        """Elasticity matrix in Voigt order [00, 11, 2*01].

        Parameters
        ----------
        inverse_metric : (..., 2, 2) array, optional
            Contravariant metric of the parametrization [T 2.8]; identity for an orthonormal
            frame [T 2.17].

        Returns
        -------
        (..., 3, 3) array
        """
        a = np.eye(2) if inverse_metric is None else inverse_metric
        nu = self.poisson_ratio
        pairs = ((0, 0), (1, 1), (0, 1))
        C = np.empty((*a.shape[:-2], 3, 3))
        for r, (i, j) in enumerate(pairs):
            for s, (k, m) in enumerate(pairs):
                shear = a[..., i, k] * a[..., j, m] + a[..., i, m] * a[..., j, k]
                C[..., r, s] = nu * a[..., i, j] * a[..., k, m] + 0.5 * (1.0 - nu) * shear
        return self.stiffness * C


def check_share(share: float) -> None:
    """Refuse a share of compression outside [0, 1].

    Raises
    ------
    ValueError
        Naming it.
    """
    if not 0.0 <= share <= 1.0:
        raise ValueError(f"compression_share = {share:g} must lie in [0, 1], usual is 1e-3")
