"""The balance of forces that steps and static equilibria share: residual and tangent.

``W'(theta) - p Q'(theta) + B'(theta) + linear + operator q + damping(q) = load(theta)`` under
``Q(theta) = V`` on free coordinates ``theta = start + E q``, with the potential B of contact
forces; the multiplier of Newton's iteration is ``-p``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..conditions.contact import Contact
from ..conditions.loads import Follower
from . import newton
from .damped_tangent import DampedFactor, FrozenDamping
from .supported_shell import SupportedShell

FAR = 0.2  # of the length: the longest way that is tested for crossings
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
    damping : FrozenDamping, optional
        Known by its action only; applied inside GMRES.
    contact : Contact, optional
    """

    structure: SupportedShell
    start: np.ndarray
    volume: float | None
    linear: np.ndarray
    operator: newton.Matrix | None = None
    follower: Follower | None = None
    damping: FrozenDamping | None = None
    contact: Contact | None = None

    def solve(self, q: np.ndarray, pressure: float) -> newton.NewtonResult:
        """Newton's iteration from free coordinates q and an excess pressure."""
        s = self.structure
        return newton.solve(
            self.equations,
            q,
            -pressure,
            self.factor,
            tolerance=s.tolerance,
            max_iterations=s.max_iterations,
            reuse=s.reuse,
            reach=REACH * s.length,
        )

    def configuration(self, q: np.ndarray) -> np.ndarray:
        """Coefficients (n_full, 3) at free coordinates q."""
        return (self.start.ravel() + self.structure.E @ q).reshape(-1, self.structure.dimension)

    def equations(
        self,
        q: np.ndarray,
        multiplier: float,
        with_tangent: bool,
        forces: np.ndarray | None = None,
        projected: bool = True,
    ) -> newton.Equations:
        """Residual, tangent and constraint at free coordinates q.

        ``forces`` are those of `forces`, if they are known; the tangent of contact is positive
        or exact.
        """
        s = self.structure
        forces = self.forces(q) if forces is None else forces
        c = s.own(self.start) + s.E_shell @ q
        if not with_tangent and self.follower is None and self.contact is None:
            return self._without_tangent(c, multiplier, forces)
        gradient, tangent = s.shell.gradient_and_tangent(c)
        row, defect, touching = None, 0.0, False
        if self.volume is not None:
            Q, dQ, ddQ = s.enclosure.derivatives(c)
            gradient, tangent = gradient + multiplier * dQ, tangent + multiplier * ddQ
            row, defect = s.E_shell.T @ dQ, Q - self.volume
        if self.follower is not None:
            force, slope = self.follower(self.configuration(q))
            gradient = gradient - s.own(force)
            tangent = tangent - slope[: s.n, : s.n]
        K, residual = s.E_shell.T @ tangent @ s.E_shell, s.E_shell.T @ gradient + forces
        if self.contact is not None:
            push, stiffness = self.contact.derivatives(self.configuration(q), projected)
            touching = bool(push.any())
            if touching:
                K, residual = K + s.E.T @ stiffness @ s.E, residual + s.E.T @ push
        if self.operator is not None:
            K = K + self.operator
            K = np.asarray(K) if isinstance(K, np.matrix) else K
        return newton.Equations(residual, K, row, defect, touching)

    def _without_tangent(
        self, c: np.ndarray, multiplier: float, forces: np.ndarray
    ) -> newton.Equations:
        """The equations for a factor that is kept."""
        s = self.structure
        gradient, row, defect = s.shell.gradient(c), None, 0.0
        if self.volume is not None:
            dQ = s.enclosure.gradient(c)
            gradient = gradient + multiplier * dQ
            row, defect = s.E_shell.T @ dQ, s.enclosure.value(c) - self.volume
        return newton.Equations(s.E_shell.T @ gradient + forces, None, row, defect)

    def forces(self, q: np.ndarray) -> np.ndarray:
        """The part of the residual that is linear in q, on free coordinates."""
        r = self.linear if self.operator is None else self.linear + self.operator @ q
        return r if self.damping is None else r + self.damping(q)

    def drag(self, d: np.ndarray) -> np.ndarray | float:
        """Forces of the damping that is known by its action only."""
        return 0.0 if self.damping is None else self.damping(d)

    def free_step(self, q: np.ndarray, d: np.ndarray) -> float:
        """Fraction of the way from q to q + d on which nothing crosses.

        With contact no way is longer than `FAR`: where a bag snaps directions are enormous, and
        a test of what lies on them would take for ever.
        """
        if self.contact is None:
            return 1.0
        longest = FAR * self.structure.length / max(float(np.abs(d).max()), 1e-300)
        share = min(1.0, longest)
        end = self.configuration(q + share * d)
        return share * self.contact.free_step(self.configuration(q), end)

    def potential(self, q: np.ndarray) -> tuple[float, float]:
        """Energy that shell and contact store, and the defect of the volume."""
        s = self.structure
        c = s.own(self.start) + s.E_shell @ q
        stored = float(sum(s.shell.energy(c)))
        if self.contact is not None:
            stored += self.contact.energy(self.configuration(q))
        return stored, 0.0 if self.volume is None else s.enclosure.value(c) - self.volume

    def factor(self, tangent: newton.Matrix) -> newton.TangentFactor:
        """A factor of a tangent, with the damping that is no part of it."""
        solver = self.structure.solver
        if self.damping is None:
            return newton.BlockElimination(solver(tangent))
        return DampedFactor(tangent, self.damping, solver)
