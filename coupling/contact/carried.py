"""What a history tells of contact forces that the structure's steps carry."""

from __future__ import annotations

from typing import Protocol

import numpy as np


class CarriedContact(Protocol):
    """Contact as a structure's steps know it, for a history."""

    def at(self, t: float) -> CarriedContact:
        """Give it with its obstacles where they are at a time.

        Parameters
        ----------
        t : float

        Returns
        -------
        CarriedContact
        """

    def force(self, coefficients: np.ndarray) -> np.ndarray:
        """Sum the contact forces on the structure.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        (3,) array
        """

    def distance(self, coefficients: np.ndarray) -> float:
        """Find the smallest distance of what contact keeps apart, infinite out of its reach.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        float
        """

    def within_reach(self, coefficients: np.ndarray) -> int:
        """Count the samples that contact forces act on.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        int
        """
