"""The error of a traction in its three shares, and the verdict on it."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field

import numpy as np

# True over estimated error: up to 1.13 for the share of a mesh that resolves.
MARGIN = 1.15


class Verdict(enum.Enum):
    """Whether a tolerance was met, in these words everywhere."""

    MET = "met"
    MISSED = "missed"
    CANNOT_TELL = "cannot tell"


@dataclass(frozen=True)
class TractionError:
    """Estimated relative errors of a traction, in the L2 norm over the surface.

    Parameters
    ----------
    tolerance : float
        What was asked of their sum.
    mesh : float
        Of the discretisation; NaN where it was not estimated.
    quadrature, compression : float
        Of the operator; NaN where it was not measured, 0 where there is none.
    krylov : float
        Of the linear iteration.
    resolved : bool
        Whether elements are small enough against the film between walls for any estimate.
    advice : str
        Where the mesh's share is too large, and what refinement would do.
    elements : (n_elements,) array, optional
        The mesh's share of each element; their squares add up to that of ``mesh``.
    """

    tolerance: float
    mesh: float
    quadrature: float
    compression: float
    krylov: float
    resolved: bool = True
    advice: str = ""
    elements: np.ndarray | None = field(default=None, repr=False, compare=False)

    @property
    def operator(self) -> float:
        """Quadrature and compression together."""
        return self.quadrature + self.compression

    @property
    def total(self) -> float:
        """Sum of the three shares; NaN where one of them is not known."""
        return self.mesh + self.operator + self.krylov

    @property
    def verdict(self) -> Verdict:
        """Met or missed by the sum; "cannot tell" where a share is not known, the mesh too coarse
        for its own estimate, or the sum so near the tolerance that estimates are not sharp enough,
        and the rest is within the tolerance.
        """
        known = sum(e for e in (self.mesh, self.operator, self.krylov) if not math.isnan(e))
        if known > self.tolerance:
            return Verdict.MISSED
        told = self.resolved and MARGIN * self.total <= self.tolerance  # NaN is not below
        return Verdict.MET if told else Verdict.CANNOT_TELL

    def describe(self) -> dict[str, float | str | None]:
        """Plain numbers and words for records; None for what is not known.

        Returns
        -------
        dict of str to float, str or None
        """
        return {
            "tolerance": self.tolerance,
            "mesh": _known(self.mesh),
            "quadrature_and_compression": _known(self.operator),
            "krylov": _known(self.krylov),
            "total": _known(self.total),
            "verdict": self.verdict.value,
            "advice": self.advice,
        }

    def __str__(self) -> str:
        shares = (
            f"mesh {_figure(self.mesh)}, quadrature and compression {_figure(self.operator)}, "
            f"Krylov {_figure(self.krylov)}: {_figure(self.total)} of {self.tolerance:g} asked"
        )
        return f"{self.verdict.value}: {shares}" + (f"; {self.advice}" if self.advice else "")


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value


def _figure(value: float) -> str:
    return "not estimated" if math.isnan(value) else f"{value:.1e}"
