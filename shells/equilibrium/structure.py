"""`ShellStructure`: a shell with supports and an enclosed volume, in time and at rest.

Each method is one function of a file beside this one: `backward_euler`, `static`,
`energy_budget`; measures and matrices are those of `supported_shell`.
"""

from __future__ import annotations

from typing import final

import numpy as np
from scipy.sparse.linalg import LinearOperator

from ..conditions.loads import Follower
from . import backward_euler, energy_budget
from .state import MotionState, ShellStep
from .static import static_equilibrium
from .supported_shell import SupportedShell


@final
class ShellStructure(SupportedShell):
    """A Kirchhoff-Love shell, its supports and its enclosed volume.

    Plane curves work alike, with 2 components in place of 3 and their enclosed area as volume.

    Parameters
    ----------
    shell : KirchhoffLove, HyperelasticShell or PlanarMembrane
    extraction : (3 n_full, n_free) sparse matrix
        Supports and poles (`shells.supported`, `shells.extraction`); coefficients beyond the
        shell's own never move.
    volume : EnclosedVolume, OpenVolume or EnclosedArea, optional
        Without it there is no constraint and no pressure.
    tolerance : float
        Newton's largest update over the length of the structure.
    max_iterations : int
        Newton iterations of one solve.
    solver : callable
        Linear solver of Newton's iteration: `shells.equilibrium.newton.factorize`, or
        `shells.equilibrium.multigrid.multigrid` for very large systems without a volume.
    reuse : float
        Keep a factor of the tangent while its updates fall below this fraction of the last and
        meet the tolerance soon (0: never). It saves factors, never at the price of many
        iterations.
    contact : Contact, optional
        Acts in steps in time; static equilibria refuse it.

    Raises
    ------
    ValueError
        An extraction with too few rows; a moving open edge (see `EnclosedVolume.check`).
    """

    def step(
        self,
        state: MotionState,
        load: np.ndarray | None,
        dt: float,
        volume: float | None,
        damping: backward_euler.Damping | None = None,
        guess: np.ndarray | None = None,
    ) -> ShellStep:
        """One backward-Euler step [T 6.11].

        Parameters
        ----------
        state : ShellState
        load : (n_full, 3) array or None
            Force tested with each function.
        dt : float
        volume : float or None
            Enclosed volume at the new time.
        damping : (3 n_full, 3 n_full) array or LinearOperator, optional
            C with ``C v`` added to the residual; an operator with ``dense()`` enters the factor,
            any other is applied inside GMRES.
        guess : (n_full, 3) array, optional
            Start of Newton's iteration, where nothing crosses (with contact, schemes test that);
            default the predictor ``theta_n + dt v_n``, or ``theta_n`` if something crosses on the
            way to it.

        Returns
        -------
        ShellStep
        """
        return backward_euler.step(self, state, load, dt, volume, damping, guess)

    def linearised(self, state: MotionState, dt: float) -> LinearOperator:
        """Inverse of ``M/dt^2 + W'' - p Q''`` under ``Q'(x) = 0``.

        Parameters
        ----------
        state : ShellState
        dt : float

        Returns
        -------
        (3 n_full, 3 n_full) LinearOperator
        """
        return backward_euler.inverse_tangent(self, state, dt)

    def energies(self, state: MotionState) -> dict[str, float]:
        """Kinetic, membrane and bending energy of a state, and that of contact forces.

        Parameters
        ----------
        state : ShellState

        Returns
        -------
        dict
            Keys "kinetic", "membrane" and "bending"; "contact" only with contact.
        """
        return energy_budget.energies(self, state)

    def budget(
        self,
        start: MotionState,
        end: MotionState,
        load: np.ndarray | None,
        acceleration: np.ndarray | None = None,
    ) -> dict[str, float]:
        """Work of pressure and load over a step and the integrator's dissipation.

        Parameters
        ----------
        start, end : ShellState
            Before and after the step.
        load : (n_full, 3) array or None
        acceleration : (n_full, 3) array, optional
            The integrator's at the end, if it is not backward Euler; its kinetic dissipation is
            then ``<M a, d> - (|v_1|_M^2 - |v_0|_M^2) / 2``.

        Returns
        -------
        dict
            Keys "pressure_work", "load_work" and "dissipation"; the work of obstacles that move
            is load's.
        """
        return energy_budget.budget(self, start, end, load, acceleration)

    def static(
        self,
        coefficients: np.ndarray,
        volume: float | None = None,
        *,
        pressure: float = 0.0,
        load: np.ndarray | Follower | None = None,
    ) -> ShellStep:
        """Static equilibrium near ``coefficients``.

        Parameters
        ----------
        coefficients : (n_full, 3) array
            Start of Newton's iteration.
        volume : float, optional
            Enclosed volume to reach; its multiplier is the excess pressure.
        pressure : float
            Start of the multiplier.
        load : (n_full, 3) array or callable, optional
            Dead load, or ``load(c)`` returning the load on a configuration and its derivative
            ``(3 n_full, 3 n_full)``; see `shells.conditions.loads`.

        Returns
        -------
        ShellStep
            If Newton's iteration fails its state is the start, and residual and outcome tell why.

        Raises
        ------
        ValueError
            Supports that leave a rigid motion free (a mechanism), a load on supports only, or
            contact, whose forces take steps that nothing crosses in.
        """
        return static_equilibrium(self, coefficients, volume, pressure, load)
