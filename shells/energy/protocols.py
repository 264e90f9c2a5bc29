"""What equilibrium asks of an energy and of an enclosed volume, for surfaces and curves alike."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from scipy.sparse import csr_matrix

from ..surfaces.curve import CurveBasis
from ..surfaces.surface_basis import SurfaceBasis
from .material import Material


class ShellEnergy(Protocol):
    """An energy W of dof vectors ``x (N,)`` with its first and second variation."""

    @property
    def basis(self) -> SurfaceBasis | CurveBasis:
        """Basis whose vector dofs x holds."""

    @property
    def material(self) -> Material:
        """Material; its density gives the mass."""

    def energy(self, x: np.ndarray) -> tuple[float, float]:
        """Membrane and bending energy."""

    def gradient(self, x: np.ndarray) -> np.ndarray:
        """W' as a dof vector."""

    def gradient_and_tangent(self, x: np.ndarray) -> tuple[np.ndarray, csr_matrix]:
        """W' and W''."""


class Enclosure(Protocol):
    """A volume Q (in the plane an area) of dof vectors ``x (N,)``."""

    def value(self, x: np.ndarray) -> float:
        """Q."""

    def gradient(self, x: np.ndarray) -> np.ndarray:
        """Q' as a dof vector."""

    def derivatives(self, x: np.ndarray) -> tuple[float, np.ndarray, csr_matrix]:
        """Q, Q' and Q''."""

    def check(self, extraction: csr_matrix) -> None:
        """Refuse supports under which Q is no volume, with a ValueError."""
