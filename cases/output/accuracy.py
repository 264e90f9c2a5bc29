"""The fluid's accuracy over a run: the budget before it, and the errors measured along it.

Compression is measured in every accepted step; quadrature in the first one and whenever the
narrowest gap has shrunk by a fifth, the mesh's share in the first one and whenever it has halved.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from hbem.accuracy import Budget, at_gap
from hbem.traction_error import TractionError, Verdict

if TYPE_CHECKING:
    from coupling import AcceptedStep

SHRUNK, HALVED = 0.8, 0.5  # of the gap of the last measurement of quadrature, of the mesh's share
SHARES = ("mesh", "quadrature", "compression", "krylov")


@dataclass
class Accuracy:
    """Budget of a run and the extremes along it.

    Attributes
    ----------
    budget : Budget
    gap, extent : float
        Smallest gap so far and the extent of the narrowest region.
    measures_mesh : bool
        Whether the mesh's share is measured; it costs some ten assemblies.
    zeta : float
        Largest multiplier over the largest velocity.
    worst : dict
        Largest error so far of each share.
    missed : int
        Accepted steps whose measured error exceeds the tolerance.
    touched : callable, optional
        Elements in contact ``(n_elements,)`` of a configuration: their films are as thin as contact
        lets them be, which no mesh resolves, and their part of the mesh's share is told apart.
    in_contact : int
        Most of them in a step.
    """

    budget: Budget
    gap: float
    extent: float
    measures_mesh: bool = True
    zeta: float = 0.0
    worst: dict[str, float] = field(default_factory=dict)
    missed: int = 0
    advice: str = ""
    touched: Callable[[np.ndarray], np.ndarray] | None = None
    in_contact: int = 0
    apart: dict[str, float] = field(default_factory=dict)
    _last: dict[str, float] = field(default_factory=dict, init=False, repr=False)
    _measured: dict[str, float] = field(default_factory=dict, init=False, repr=False)

    def note(self, step: AcceptedStep) -> str:
        """Take an accepted step into account.

        Returns
        -------
        str
            What is to be said about its error: where a share was measured anew, or is missed for
            the first time; else empty.
        """
        row, traction = step.row, step.traction
        gap = row.get("min_gap", self.gap)
        self.gap = min(self.gap, gap)
        fastest = row.get("velocity_max", 0.0)
        if traction is None or not fastest > 0.0:
            return ""
        self.zeta = max(self.zeta, abs(traction.zeta) / fastest)
        krylov = at_gap(self.budget, gap, self.extent).krylov_error(traction.residual)
        measure = getattr(traction, "measure", None)
        if measure is None:
            return self._take(self._error({"krylov": krylov}), False)
        quadrature = self._due("quadrature", gap, SHRUNK)
        mesh = quadrature and self.measures_mesh and self._due("mesh", gap, HALVED)
        error = measure(krylov, quadrature, mesh)
        said = self._take(error, quadrature)
        told = self._apart(step, error)
        return f"{said}; {told}" if said and told else said

    def _apart(self, step: AcceptedStep, error: TractionError) -> str:
        """The mesh's share on elements in contact and on the others, where both are known."""
        if self.touched is None or not step.row.get("contacts", 0.0):
            return ""
        inside = self.touched(step.state.coefficients)
        self.in_contact = max(self.in_contact, int(inside.sum()))
        if error.elements is None:
            return ""
        for name, part in (("in_contact", inside), ("elsewhere", ~inside)):
            share = float(np.linalg.norm(error.elements[part]))
            self.apart[name] = max(share, self.apart.get(name, 0.0))
        return (
            f"of the mesh's share {np.linalg.norm(error.elements[inside]):.1e} on {inside.sum()} "
            f"elements in contact, {np.linalg.norm(error.elements[~inside]):.1e} elsewhere"
        )

    def _due(self, share: str, gap: float, fraction: float) -> bool:
        """Whether a share is to be measured at a gap; remembers that it was."""
        if gap > fraction * self._measured.get(share, np.inf):
            return False
        self._measured[share] = gap
        return True

    def _take(self, error: TractionError, fresh: bool) -> str:
        found = {name: float(getattr(error, name)) for name in SHARES}
        known = {name: e for name, e in found.items() if not np.isnan(e)}
        self._last.update(known)
        for name, e in known.items():
            self.worst[name] = max(e, self.worst.get(name, 0.0))
        self.advice = error.advice or self.advice
        # what is not measured in this step stands as it was measured last
        now = self._error(self._last, error.advice)
        first = now.verdict is Verdict.MISSED and not self.missed
        self.missed += now.verdict is Verdict.MISSED
        return f"traction error {now}" if fresh or first else ""

    def so_far(self) -> TractionError:
        """The largest shares along the run, with the verdict on their sum."""
        apart = ""
        if self.apart:
            apart = (
                f"of the mesh's share at most {self.apart['in_contact']:.1e} on elements in "
                f"contact ({self.in_contact} at most), {self.apart['elsewhere']:.1e} elsewhere"
            )
        return self._error(self.worst, "; ".join(filter(None, [self.advice, apart])))

    def _error(self, shares: Mapping[str, float], advice: str = "") -> TractionError:
        mesh, quadrature, compression, krylov = (shares.get(name, np.nan) for name in SHARES)
        asked = self.budget.traction
        return TractionError(asked, mesh, quadrature, compression, krylov, advice=advice)

    def before(self) -> Mapping[str, object]:
        """The budget as plain numbers, with its warnings."""
        return {**self.budget.describe(), "warnings": list(self.budget.warnings)}

    def after(self) -> Mapping[str, object]:
        """What the run achieved so far."""
        return {
            "thinness": at_gap(self.budget, self.gap, self.extent).thinness,
            "smallest_gap": self.gap,
            "largest_zeta": self.zeta,
            "steps_missed": self.missed,
            **self.so_far().describe(),
            "advice": self.advice,
            "compression": self.worst.get("compression"),
            "elements_in_contact": self.in_contact,
            **{f"mesh_{name}": share for name, share in self.apart.items()},
        }

    def taken_up(self, earlier: Mapping[str, Any]) -> None:
        """Go on from what an earlier session of the run recorded by `after`."""
        self.gap = float(np.fmin(self.gap, _number(earlier.get("smallest_gap"))))
        self.zeta = float(np.fmax(self.zeta, _number(earlier.get("largest_zeta"))))
        self.missed += int(np.nan_to_num(_number(earlier.get("steps_missed"))))
        self.advice = str(earlier.get("advice", ""))
        self.in_contact += int(np.nan_to_num(_number(earlier.get("elements_in_contact"))))
        shares = {
            name: _number(earlier.get(f"mesh_{name}")) for name in ("in_contact", "elsewhere")
        }
        self.apart = {name: e for name, e in shares.items() if not np.isnan(e)}
        compression = _number(earlier.get("compression"))
        operator = _number(earlier.get("quadrature_and_compression"))
        found = {
            "mesh": _number(earlier.get("mesh")),
            "quadrature": operator - compression,
            "compression": compression,
            "krylov": _number(earlier.get("krylov")),
        }
        self.worst = {name: e for name, e in found.items() if not np.isnan(e)}


def _number(value: Any) -> float:
    return float(value) if isinstance(value, int | float) else np.nan
