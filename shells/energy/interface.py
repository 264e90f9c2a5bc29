"""What equilibrium asks of an energy and of an enclosed volume, for surfaces and curves alike.

Everywhere ``x (N,)`` is a dof vector of the basis; its coefficients ``(N / d, d)`` do as well.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from scipy.sparse import csr_matrix

from ..surfaces.curve import CurveBasis
from ..surfaces.element_basis import ElementBasis
from .material import Material


class ShellEnergy(ABC):
    """An energy W on one basis, with its first and second variation."""

    basis: ElementBasis | CurveBasis
    material: Material

    @abstractmethod
    def energy(self, x: np.ndarray) -> tuple[float, float]:
        """Membrane and bending energy, whose sum is W.

        Parameters
        ----------
        x : (N,) array

        Returns
        -------
        membrane, bending : float
        """

    @abstractmethod
    def gradient(self, x: np.ndarray) -> np.ndarray:
        """First variation W'.

        Parameters
        ----------
        x : (N,) array

        Returns
        -------
        (N,) array
        """

    @abstractmethod
    def gradient_and_tangent(self, x: np.ndarray) -> tuple[np.ndarray, csr_matrix]:
        """Both variations, W' and W'', from one pass.

        Parameters
        ----------
        x : (N,) array

        Returns
        -------
        (N,) array and (N, N) sparse matrix
        """

    @property
    def grounding(self) -> csr_matrix | None:
        """W'' at the reference of what holds the shell in space, None if nothing does."""
        return None


class Enclosure(ABC):
    """A volume Q (in the plane an area) on one basis, with its first and second variation."""

    @abstractmethod
    def value(self, x: np.ndarray) -> float:
        """The volume Q.

        Parameters
        ----------
        x : (N,) array

        Returns
        -------
        float
        """

    @abstractmethod
    def gradient(self, x: np.ndarray) -> np.ndarray:
        """First variation Q', the force of a unit pressure.

        Parameters
        ----------
        x : (N,) array

        Returns
        -------
        (N,) array
        """

    @abstractmethod
    def derivatives(self, x: np.ndarray) -> tuple[float, np.ndarray, csr_matrix]:
        """The volume with both variations, Q, Q' and Q''.

        Parameters
        ----------
        x : (N,) array

        Returns
        -------
        float, (N,) array and (N, N) sparse matrix
        """

    @abstractmethod
    def check(self, extraction: csr_matrix) -> None:
        """Refuse supports under which Q is no volume.

        Parameters
        ----------
        extraction : (N, n_free) sparse matrix

        Raises
        ------
        ValueError
            Naming what moves and must not.
        """
