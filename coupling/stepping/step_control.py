"""Step size: the scene's dt is the ceiling, a dt below the floor ends the run.

Four limits on the next step, each named in the log when it acts: growth after an accepted step;
many subiterations; the local time error; the closing speed of the smallest gap, whose dynamics
(relaxation ~ H^3) a step must not jump across.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..exchange import Result

CONTACTS = (Result.SELF_INTERSECTION, Result.INLET_CONTACT)
STUCK = [Result.INLET_CONTACT] * 3  # rejections in a row at the inlet: no smaller step cures them


@dataclass(frozen=True)
class StepControl:
    """Parameters of the step size.

    Parameters
    ----------
    dt, end : float
        Largest step and end time.
    growth : float
        Largest ratio of an accepted step to the next.
    floor : float
        Smallest step; 0 is ``dt / 2**20``.
    error : float
        Tolerated local error of a step, root mean square of the displacement; 0 switches off.
        A step with more than four times this error is rejected.
    closing : float
        Fraction of the smallest gap that a step may close at the present speed; 0 switches off.
    busy : float
        Fraction of the allowed subiterations above which the next step is shortened by 0.7.
    """

    dt: float
    end: float
    growth: float = 1.5
    floor: float = 0.0
    error: float = 0.0
    closing: float = 0.5
    busy: float = 0.8

    @property
    def smallest(self) -> float:
        """Step below which a run ends."""
        return self.floor or self.dt / 2**20

    def too_inaccurate(self, error: float) -> bool:
        """Say whether a step must be repeated because of its local error.

        Parameters
        ----------
        error : float
            Estimated local error, root mean square.

        Returns
        -------
        bool
        """
        return 0.0 < 4.0 * self.error < error

    def ending(self, dt: float, causes: Sequence[Result]) -> Result | None:
        """Say how a run ends whose next step is too small or hopeless; None if it goes on.

        Parameters
        ----------
        dt : float
        causes : sequence of Result
            Of the rejections since the last accepted step.
        """
        if dt >= self.smallest and causes[-len(STUCK) :] != STUCK:
            return None
        return causes[-1] if causes and causes[-1] in CONTACTS else Result.STEP_FLOOR

    def next(
        self,
        proposed: float,
        dt: float,
        *,
        effort: float,
        error: float,
        order: int,
        gap: float,
        speed: float,
    ) -> tuple[float, str]:
        """Choose the next step after an accepted one.

        Parameters
        ----------
        proposed, dt : float
            Step that the loop would take, and the one just accepted.
        effort : float
            Subiterations over those allowed.
        error : float
            Local error estimate.
        order : int
            Of the integrator.
        gap, speed : float
            Smallest gap and the speed it closes with (negative: opens).

        Returns
        -------
        float
            Next step.
        str
            What limits it below growth and ceiling; "" if nothing.
        """
        best, why = min(self.dt, max(proposed, dt * self.growth)), ""
        limits = []
        if effort > self.busy:
            limits.append((0.7 * dt, f"{effort:.0%} of the allowed subiterations"))
        if self.error > 0.0 and error > 0.0:
            factor = 0.9 * (self.error / error) ** (1.0 / (order + 1))
            limits.append((dt * min(max(factor, 0.2), self.growth), f"time error {error:.2g}"))
        if self.closing > 0.0 and speed > 0.0:
            limits.append((self.closing * gap / speed, f"gap {gap:.3g} closing at {speed:.2g}"))
        for limit, reason in limits:
            # never below the floor: only a rejected step ends a run, with its cause as result
            if max(limit, self.smallest) < best:
                best, why = max(limit, self.smallest), reason
        return best, why
