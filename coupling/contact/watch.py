"""When a surface that starts far from any contact has to be tested for self-intersection.

A test is due where contact has come near (smallest gap), where it is being asked for (a falling
volume), and for a motion so long against the gap that sheets could pass through each other.
"""

from __future__ import annotations

from dataclasses import dataclass

NEAR = 0.5  # of the initial gap
LONG = 0.25  # of the present gap: both sheets together close half of it
UNTIL = "until the gap halves, the volume falls or a step is long against the gap"


@dataclass(frozen=True)
class Watch:
    """The initial smallest gap and enclosed volume, which a run is compared with."""

    gap: float
    volume: float

    def reason(self, gap: float, volume: float, motion: float) -> str:
        """Say why a test is due.

        Parameters
        ----------
        gap : float
            Present smallest gap.
        volume : float
            Smallest enclosed volume at the start and the end of a motion.
        motion : float
            Longest way of a point.

        Returns
        -------
        str
            Empty if none is due.
        """
        if gap < NEAR * self.gap:
            return f"the smallest gap {gap:.3g} is below half of its initial {self.gap:.3g}"
        if volume < (1.0 - 1e-9) * self.volume:
            return f"the volume {volume:.4g} falls below its initial {self.volume:.4g}"
        if motion > LONG * gap:
            return f"a motion of {motion:.3g} is long against the smallest gap {gap:.3g}"
        return ""
