"""The balance of forces that steps and static equilibria share: residual and tangent.

``W'(theta) - p Q'(theta) + linear + operator q + damping(q) = load(theta), Q(theta) = V`` on free
coordinates ``theta = start + E q``; the multiplier of Newton's iteration is ``-p``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..conditions.loads import Follower
from . import newton
from .damped_tangent import DampedFactor
from .supported_shell import SupportedShell

REACH = 1e6  # lengths of the structure: the largest update of a tangent that is not singular


@dataclass(frozen=True)
class Balance:
    """The equations of one solve.

    Attributes
    ----------
    structure : SupportedShell
    start : (n_full, 3) array
        Configuration at q = 0.
    volume : float or None
        Enclosed volume V.
    linear : (n_free,) array
    operator : (n_free, n_free) sparse or dense matrix, optional
    follower : callable, optional
        Load that follows the configuration.
    damping : callable, optional
        Linear, known by its action only; applied inside GMRES.
    """

    structure: SupportedShell
    start: np.ndarray
    volume: float | None
    linear: np.ndarray
    operator: newton.Matrix | None = None
    follower: Follower | None = None
    damping: newton.Solve | None = None

    def solve(self, q: np.ndarray, pressure: float) -> newton.NewtonResult:
        """Newton's iteration from free coordinates q and an excess pressure."""
        s = self.structure
        return newton.solve(
            self.equations,
            q,
            -pressure,
            self._factor,
            tolerance=s.tolerance,
            max_iterations=s.max_iterations,
            reuse=s.reuse,
            reach=REACH * s.length,
        )

    def equations(self, q: np.ndarray, multiplier: float, with_tangent: bool) -> newton.Equations:
        """Residual, tangent and constraint at free coordinates q."""
        s = self.structure
        c = s.own(self.start) + s.E_shell @ q
        if not with_tangent and self.follower is None and self.damping is None:
            return self._without_tangent(c, q, multiplier)
        gradient, tangent = s.shell.gradient_and_tangent(c)
        row, defect = None, 0.0
        if self.volume is not None:
            Q, dQ, ddQ = s.enclosure.derivatives(c)
            gradient, tangent = gradient + multiplier * dQ, tangent + multiplier * ddQ
            row, defect = s.E_shell.T @ dQ, Q - self.volume
        if self.follower is not None:
            force, slope = self.follower((self.start.ravel() + s.E @ q).reshape(-1, s.dimension))
            gradient = gradient - s.own(force)
            tangent = tangent - slope[: s.n, : s.n]
        K = s.E_shell.T @ tangent @ s.E_shell
        if self.operator is not None:
            K = K + self.operator
            K = np.asarray(K) if isinstance(K, np.matrix) else K
        return newton.Equations(self._residual(gradient, q), K, row, defect)

    def _without_tangent(self, c: np.ndarray, q: np.ndarray, multiplier: float) -> newton.Equations:
        """The equations for a factor that is kept."""
        s = self.structure
        gradient, row, defect = s.shell.gradient(c), None, 0.0
        if self.volume is not None:
            dQ = s.enclosure.gradient(c)
            gradient = gradient + multiplier * dQ
            row, defect = s.E_shell.T @ dQ, s.enclosure.value(c) - self.volume
        return newton.Equations(self._residual(gradient, q), None, row, defect)

    def _residual(self, gradient: np.ndarray, q: np.ndarray) -> np.ndarray:
        r = self.structure.E_shell.T @ gradient + self.linear
        if self.operator is not None:
            r = r + self.operator @ q
        return r if self.damping is None else r + self.damping(q)

    def _factor(self, tangent: newton.Matrix) -> newton.TangentFactor:
        solve = self.structure.solver(tangent)
        if self.damping is None:
            return newton.BlockElimination(solve)
        return DampedFactor(solve, self.damping)
