"""What structure, fluid, files and pictures ask of a surface made of Bezier elements.

Quadrilaterals or triangles, smooth or continuous only: a surface names the coefficients of each
element and their Bezier extraction, and the functions of its density basis.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix, identity, kron

from .local_elements import functions


class Surface(ABC):
    """A surface of Bezier elements; it fulfils ``hbem.surfaces.patches.SurfacePatches``.

    Attributes
    ----------
    shape : {"quadrilateral", "triangle"}
        Local coordinates and Bernstein functions are those of `shells.surfaces.local_elements`;
        the outward normal is ``d_xi x d_eta``.
    """

    shape: str

    @property
    @abstractmethod
    def degree(self) -> int:
        """Polynomial degree p, of quadrilaterals in each direction."""

    @property
    @abstractmethod
    def n_elements(self) -> int:
        """Number of elements."""

    @property
    @abstractmethod
    def n_coefficients(self) -> int:
        """Rows of a coefficient array ``(n_coefficients, 3)``."""

    @property
    @abstractmethod
    def element_dofs(self) -> np.ndarray:
        """Coefficients of each element, ``(n_elements, n_functions)``."""

    @property
    @abstractmethod
    def bezier(self) -> csr_matrix:
        """Coefficients to Bezier points, ``(n_elements n_functions, n_coefficients)``."""

    @property
    @abstractmethod
    def reduction(self) -> csr_matrix:
        """Scalar extraction ``(n_coefficients, k)``: coefficients of an admissible field."""

    @property
    @abstractmethod
    def open_edges(self) -> dict[str, csr_matrix]:
        """Coefficients to Bezier points ``(n_points, n_coefficients)`` of each edge that nothing
        closes, by its name; none for a closed surface."""

    @property
    @abstractmethod
    def pieces(self) -> np.ndarray:
        """Which connected piece each element belongs to, ``(n_elements,)``: 0, 1, ..."""

    @property
    @abstractmethod
    def coefficient_pieces(self) -> np.ndarray:
        """The piece of each coefficient, ``(n_coefficients,)``."""

    @property
    def element_numbers(self) -> np.ndarray:
        """How messages call the elements, ``(n_elements,)``."""
        return np.arange(self.n_elements)

    @property
    @abstractmethod
    def n_dofs(self) -> int:
        """Number of scalar density functions."""

    @property
    @abstractmethod
    def _density(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """`indptr`, `dofs` and `extraction`."""

    @property
    def geometry_degree(self) -> int:
        """Degree of the Bezier patches."""
        return self.degree

    @property
    def density_degree(self) -> int:
        """Degree of the density basis."""
        return self.degree

    @property
    def indptr(self) -> np.ndarray:
        """Density functions of element e are rows ``indptr[e]`` to ``indptr[e + 1]`` of `dofs`."""
        return self._density[0]

    @property
    def dofs(self) -> np.ndarray:
        """Density dof of each row."""
        return self._density[1]

    @property
    def extraction(self) -> np.ndarray:
        """Bernstein coefficients of each row, ``(n_rows, n_functions)`` of the density degree."""
        return self._density[2]

    def sample(self, xi: np.ndarray, eta: np.ndarray, along: int | None = None) -> csr_matrix:
        """Coefficients to points at local ``xi``, ``eta`` of every element.

        Parameters
        ----------
        xi, eta : (n,) array
            Local coordinates.
        along : {0, 1}, optional
            Derivative along xi or eta instead of the value.

        Returns
        -------
        (n_elements * n, n_coefficients) sparse matrix
        """
        order = (int(along == 0), int(along == 1))
        local = csr_matrix(functions(self.shape, self.degree, xi, eta, order))
        return kron(identity(self.n_elements), local, format="csr") @ self.bezier

    def sample_density(self, xi: np.ndarray, eta: np.ndarray) -> csr_matrix:
        """Density coefficients to values at local ``xi``, ``eta`` of every element.

        Parameters
        ----------
        xi, eta : (n,) array
            Local coordinates.

        Returns
        -------
        (n_elements * n, n_dofs) sparse matrix
        """
        local = csr_matrix(functions(self.shape, self.density_degree, xi, eta))
        return kron(identity(self.n_elements), local, format="csr") @ self._density_bezier

    @cached_property
    def _density_bezier(self) -> csr_matrix:
        """Density coefficients to Bernstein coefficients of every element."""
        indptr, dofs, extraction = self._density
        element = np.repeat(np.arange(self.n_elements), np.diff(indptr))
        size = extraction.shape[1]
        rows = element[:, None] * size + np.arange(size)
        columns = np.broadcast_to(dofs[:, None], rows.shape)
        shape = (self.n_elements * size, self.n_dofs)
        return csr_matrix((extraction.ravel(), (rows.ravel(), columns.ravel())), shape)
