"""A Newton iteration that always descends, for steps in time, with contact or without.

A backward-Euler step is the minimum of

``E(q) = W + B + q.M q / (2 dt^2) + linear.q + (work done against damping)`` under ``Q(q) = V``.

Each iteration solves the bordered system for a direction d and a multiplier l+, of the tangent A;
where d.A d <= 0 it adds s M, from ``s = 10 |d.A d| / d.M d`` on, four times as much until
``d.(A + s M) d > 0``. The way a d is first whole, or as long as nothing crosses on it, and is
halved until ``E + mu |Q - V|`` falls by ``1e-4 a (mu |Q - V| - E'.d)``, with mu twice the largest
|l+| so far (and once more where it then falls twice as much); then ``l += a (l+ - l)``. That
``E'.d = l+ (Q - V) - d.(A + s M) d`` makes d a descent.

Damping by a fluid, C v, is not quite symmetric, so that it has no potential. What counts in its
place is the work done against it along the way: from q over a d

``a d.(C q) / dt + a^2 d.(C d) / (2 dt)``,

the integral of the forces along the straight line. It is the difference of ``q.C q / (2 dt)`` where
C is symmetric; a skew part does no work along the way. C d is what updates the forces of the next
iterate, too: no further solve of the fluid.

Where Newton's iteration converges by itself its steps are taken whole and nothing is changed.
Tangents of contact are cut down to positive ones, which converge linearly at last (by 0.3 to 0.5);
from updates of 1e-3 of the length on the exact ones are tried first. Steps in contact end at
updates of 1e-6 of the length. Contact forces jump where a sample changes the triangle that it
faces, and a minimum may lie in such a kink: there directions stay longer, up to 1e-4, and what
counts is the update as halved.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, field, replace

import numpy as np

from . import newton
from .balance import REACH, Balance
from .newton import Equations, NewtonOutcome, NewtonResult, TangentFactor

logger = logging.getLogger(__name__)
DECREASE = 1e-4  # share of the predicted decrease that is asked for
SHIFTS = 12  # tried in one iteration, each four times the last
HALVINGS = 8  # of a way, before a shift turns it
ROUNDING = 1e-12  # of the stored energy: a rise below it is none
NEAR = 1e-3  # of the length: updates from which on contact's exact tangent is tried
TOUCHING = 1e-6  # of the length: where iterations in contact stop
KINK, TIGHT = 1e-4, 1e-9  # of the length and of the volume: what is left where forces jump
BLOCKED, PATIENCE = 0.01, 3  # free part of a way that leads nowhere; how many of them in a row
FURTHER = 8.0  # times a way that a shift has shortened


@dataclass(frozen=True)
class Iterate:
    """Free coordinates, the multiplier, and what is known there."""

    x: np.ndarray
    multiplier: float
    forces: np.ndarray  # the linear ones
    energy: float
    defect: float


@dataclass(frozen=True)
class Way:
    """A direction d from an iterate, the multiplier at its end, the shift that turned it."""

    d: np.ndarray
    multiplier: float
    shift: float = 0.0

    @property
    def size(self) -> float:
        return float(np.abs(self.d).max())


@dataclass
class Descent:
    """The iteration of one step.

    Attributes
    ----------
    balance : Balance
        Without a follower load.
    history : list of float
        Largest update of each iteration, before it is cut.
    penalty : float
        mu.
    factorizations : int
    """

    balance: Balance
    history: list[float] = field(default_factory=list)
    penalty: float = 0.0
    factorizations: int = 0
    _kept: TangentFactor | None = None
    _blocked: int = 0

    def solve(self, q: np.ndarray, pressure: float) -> NewtonResult:
        """Descend from free coordinates q, where nothing crosses, and an excess pressure."""
        b = self.balance
        now = Iterate(q.copy(), -pressure, b.forces(q), *b.potential(q))
        norms: list[float] = []
        outcome = None if np.isfinite(now.energy) else NewtonOutcome.DIVERGED
        while outcome is None:
            if len(self.history) == b.structure.max_iterations:
                outcome = NewtonOutcome.LIMIT
                break
            near = bool(self.history) and self.history[-1] < NEAR * b.structure.length
            at = b.equations(now.x, now.multiplier, self._kept is None, now.forces, not near)
            norms.append(float(np.linalg.norm(at.residual)))
            if not np.isfinite(norms[-1]):
                outcome = NewtonOutcome.DIVERGED
                break
            try:
                now, outcome = self._next(at, now, near and at.touching)
            except (RuntimeError, np.linalg.LinAlgError, ValueError):
                outcome = NewtonOutcome.SINGULAR
        left = norms[-1] / norms[0] if norms and norms[0] > 0.0 else 0.0
        history = tuple(self.history)
        return NewtonResult(now.x, now.multiplier, outcome, history, left, self.factorizations)

    def _next(
        self, at: Equations, now: Iterate, exact: bool
    ) -> tuple[Iterate, NewtonOutcome | None]:
        """The next iterate, and the outcome where the iteration ends with it."""
        s, b = self.balance.structure, self.balance
        tolerance = max(s.tolerance, TOUCHING * s.length if at.touching else 0.0)
        if self._kept is not None:
            way = self._way(self._kept, at, now)
            if newton.worth_keeping(way.size, self.history[-1], s.reuse, tolerance):
                new, last = self._go(at, now, way, tolerance, halvings=1)
                if new is not None:
                    return new, last
            self._kept = None
            if at.tangent is None:
                at = b.equations(now.x, now.multiplier, True, now.forces)
        shift = 0.0
        for _ in range(SHIFTS):
            tangent = at.tangent if shift == 0.0 else at.tangent + shift * s.M_free
            factored = b.factor(np.asarray(tangent) if isinstance(tangent, np.matrix) else tangent)
            self.factorizations += 1
            way = self._way(factored, at, now, shift)
            if way.size > REACH * s.length:
                return now, newton.beyond(at, way.d, way.multiplier - now.multiplier)
            new, last = self._go(at, now, way, tolerance)
            if new is not None:
                self._kept = factored if s.reuse > 0.0 and shift == 0.0 else None
                return new, last
            if exact:
                at, exact = b.equations(now.x, now.multiplier, True, now.forces), False
                continue
            stiffness = abs(float(way.d @ (at.tangent @ way.d)))
            shift = max(4.0 * shift, 10.0 * stiffness / float(way.d @ (s.M_free @ way.d)))
        return now, NewtonOutcome.LIMIT

    def _way(self, factored: TangentFactor, at: Equations, now: Iterate, shift: float = 0.0) -> Way:
        d, step = factored.bordered(at.residual, at.row, at.defect)
        return Way(d, now.multiplier + step, shift)

    def _go(
        self, at: Equations, now: Iterate, way: Way, tolerance: float, halvings: int = HALVINGS
    ) -> tuple[Iterate | None, NewtonOutcome | None]:
        """Where a way leads to; None where it does not descend."""
        s, b, d = self.balance.structure, self.balance, way.d
        short = way.size <= tolerance and way.shift == 0.0
        if short and b.free_step(now.x, d) == 1.0:
            self.history.append(way.size)
            return replace(now, x=now.x + d, multiplier=way.multiplier), NewtonOutcome.CONVERGED
        drag = b.drag(d)
        if at.tangent is not None:
            shifted = at.tangent @ d + drag + way.shift * (s.M_free @ d)
            if float(d @ shifted) <= 0.0:
                return None, None
        push = drag if b.operator is None else b.operator @ d + drag
        mu = max(self.penalty, 2.0 * abs(way.multiplier))
        force = at.residual if at.row is None else at.residual - now.multiplier * at.row
        slope = float(force @ d) - mu * abs(now.defect)

        def trial(a: float) -> tuple[Iterate, float]:
            x, share = now.x + a * d, min(a, 1.0)
            multiplier = now.multiplier + share * (way.multiplier - now.multiplier)
            new = Iterate(x, multiplier, now.forces + a * push, *b.potential(x))
            work = a * float(d @ (now.forces + 0.5 * a * push))
            return new, new.energy - now.energy + work + mu * (abs(new.defect) - abs(now.defect))

        kink = at.touching and way.shift == 0.0 and way.size <= KINK * s.length
        tie, free = ROUNDING * abs(now.energy), b.free_step(now.x, d)
        a = free
        new, rise = trial(a)
        while not rise <= DECREASE * a * slope + tie:
            a, halvings = 0.5 * a, halvings - 1
            if halvings <= 0 and kink and a * way.size <= tolerance and self._tight(now):
                return now, NewtonOutcome.CONVERGED
            if halvings <= 0:
                return None, None
            new, rise = trial(a)
        if a < free:  # just short enough, it may have climbed again: half of it, if twice as low
            nearer, lower = trial(0.5 * a)
            if lower < 2.0 * rise:
                new, rise, a = nearer, lower, 0.5 * a
        # a shift shortens the way down from a saddle: go on as long as that falls
        while way.shift > 0.0 and 1.0 <= a < FURTHER and b.free_step(now.x, 2.0 * a * d) == 1.0:
            further, lower = trial(2.0 * a)
            if not lower < rise:
                break
            new, rise, a = further, lower, 2.0 * a
        logger.debug("|d| %.2e by %.3g, shift %.1e, rise %.2e", way.size, a, way.shift, rise)
        self.penalty = mu
        self.history.append(way.size)
        self._blocked = self._blocked + 1 if free < BLOCKED else 0
        if kink and a < free and a * way.size <= tolerance and self._tight(new):
            return new, NewtonOutcome.CONVERGED
        return new, NewtonOutcome.BLOCKED if self._blocked == PATIENCE else None

    def _tight(self, at: Iterate) -> bool:
        return abs(at.defect) <= TIGHT * abs(self.balance.volume or 0.0)
