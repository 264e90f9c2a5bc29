"""A surface with its first and second derivatives at quadrature points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class Jets:
    """A surface and its derivatives at quadrature points.

    Attributes
    ----------
    value : (n_elements, n_points, 3) array
    grad : (2, n_elements, n_points, 3) array
        Derivatives along s and t.
    hess : (3, n_elements, n_points, 3) array
        Second derivatives ss, tt, st.
    """

    value: np.ndarray
    grad: np.ndarray
    hess: np.ndarray

    @cached_property
    def normal(self) -> np.ndarray:
        """Unnormalised normal ``X_s x X_t``, ``(n_elements, n_points, 3)``."""
        return np.cross(self.grad[0], self.grad[1])
