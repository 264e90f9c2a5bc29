"""What a structure asks of contact: forces from a potential, and steps in which nothing crosses."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from scipy.sparse import csr_matrix


class Contact(Protocol):
    """Frictionless contact of a structure with itself and with obstacles."""

    def at(self, t: float) -> Contact:
        """Contact with its obstacles where they are at a time.

        Parameters
        ----------
        t : float

        Returns
        -------
        Contact
            Itself where nothing moves by prescription.
        """

    def energy(self, coefficients: np.ndarray) -> float:
        """Potential of the contact forces.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        float
        """

    def derivatives(
        self, coefficients: np.ndarray, projected: bool = True
    ) -> tuple[np.ndarray, csr_matrix]:
        """Gradient of the potential and a positive semi-definite tangent, or the exact one.

        Parameters
        ----------
        coefficients : (n_full, 3) array
        projected : bool
            False gives the second derivative as it is, with which Newton ends quadratically.

        Returns
        -------
        (3 n_full,) array and (3 n_full, 3 n_full) sparse matrix
        """

    def free_step(self, start: np.ndarray, end: np.ndarray) -> float:
        """Fraction of the straight way between two configurations on which nothing crosses.

        Parameters
        ----------
        start, end : (n_full, 3) array
            Nothing crosses at the start.

        Returns
        -------
        float
            1 where the whole way is free; a contact is never reached, but stays ahead.
        """

    def distance(self, coefficients: np.ndarray) -> float:
        """Smallest distance of what contact keeps apart.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        float
            Infinity where nothing is within the reach of the forces.
        """
