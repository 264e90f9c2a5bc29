"""A shell, its supports and what it encloses: the data that every balance needs, and measures.

A configuration is an array ``(n_full, 3)``; it moves by ``E q`` with free coordinates q. The
first rows belong to the shell, further ones never move.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu

from ..conditions.contact import Contact
from ..conditions.rigid_motions import Mechanism, mechanism
from ..energy.interface import Enclosure, ShellEnergy
from . import newton


class SupportedShell:
    """What a structure is; see `ShellStructure` for parameters and errors.

    Attributes
    ----------
    shell : ShellEnergy
    E : (3 n_full, n_free) sparse matrix
        Extraction; ``E_shell`` are its rows that belong to the shell.
    M : (n, n) sparse matrix
        Mass of the shell; ``M_free`` on free coordinates.
    enclosed : Enclosure or None
    contact : Contact or None
    n, dimension : int
        Vector dofs of the shell, and components of each coefficient.
    length : float
        Largest extent of the reference.
    """

    def __init__(
        self,
        shell: ShellEnergy,
        extraction: csr_matrix,
        volume: Enclosure | None = None,
        *,
        tolerance: float = 1e-9,
        max_iterations: int = 25,
        solver: newton.LinearSolver = newton.factorize,
        reuse: float = 0.0,
        contact: Contact | None = None,
    ):
        self.shell, self.E, self.enclosed = shell, extraction.tocsr(), volume
        self.n, self.dimension = shell.basis.N, shell.basis.dimension
        d = self.dimension
        if extraction.shape[0] < self.n or extraction.shape[0] % d:
            raise ValueError(f"the extraction needs at least {self.n} rows, {d} a coefficient")
        self.E_shell = self.E[: self.n]
        if volume is not None:
            volume.check(self.E_shell)
        self.M = shell.basis.mass(shell.material.density)
        self.M_free = (self.E_shell.T @ self.M @ self.E_shell).tocsr()
        self.length = float(np.ptp(shell.basis.reference.value.reshape(-1, d), axis=0).max())
        self.tolerance, self.max_iterations = tolerance * self.length, max_iterations
        self.solver, self.reuse, self.contact = solver, reuse, contact

    @cached_property
    def mechanism(self) -> Mechanism:
        """Rigid motions that neither the supports nor the energy's own clamps hold."""
        return mechanism(self.E, self.shell.basis).under(self.shell.grounding)

    def refuse_contact(self, what: str) -> None:
        """Refuse a structure with contact where it would be left out of account.

        Raises
        ------
        ValueError
        """
        if self.contact is not None:
            raise ValueError(f"{what} know no contact: take steps in time until it rests")

    @cached_property
    def _normal_solver(self) -> Any:
        return splu((self.E.T @ self.E).tocsc())

    def reduce(self, increment: np.ndarray) -> np.ndarray:
        """Free coordinates of an increment.

        Parameters
        ----------
        increment : (n_full, 3) array
            In the range of E.

        Returns
        -------
        (n_free,) array
        """
        return self._normal_solver.solve(self.E.T @ increment.ravel())

    def expand(self, q: np.ndarray) -> np.ndarray:
        """Increment of free coordinates.

        Parameters
        ----------
        q : (n_free,) array

        Returns
        -------
        (n_full, 3) array
        """
        return (self.E @ q).reshape(-1, self.dimension)

    def own(self, array: np.ndarray) -> np.ndarray:
        """The shell's own part of an array.

        Parameters
        ----------
        array : (n_full, 3) array

        Returns
        -------
        (n,) array
            Vector dofs.
        """
        return array.ravel()[: self.n]

    @property
    def enclosure(self) -> Enclosure:
        """What the shell encloses; a ValueError where that is nothing."""
        if self.enclosed is None:
            raise ValueError("this structure encloses no volume")
        return self.enclosed

    def volume(self, coefficients: np.ndarray) -> float:
        """Enclosed volume.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        float

        Raises
        ------
        ValueError
            A structure that encloses none.
        """
        return self.enclosure.value(self.own(coefficients))

    def area(self, coefficients: np.ndarray) -> float:
        """Current area of the shell.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        float
        """
        basis = self.shell.basis
        jets = basis.jets(coefficients.reshape(-1, self.dimension)[: self.n // self.dimension])
        ratio = np.linalg.norm(jets.normal, axis=-1)
        ratio /= np.linalg.norm(basis.reference.normal, axis=-1)
        return float((ratio * basis.dx).sum())

    def measure(self, increment: np.ndarray) -> float:
        """Mass-weighted root mean square of an increment.

        Parameters
        ----------
        increment : (n_full, 3) array

        Returns
        -------
        float
        """
        d = self.own(increment)
        density = self.shell.material.density
        return float(np.sqrt(max(d @ (self.M @ d), 0.0) / (density * self.shell.basis.dx.sum())))
