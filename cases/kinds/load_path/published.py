"""What the shell benchmarks are measured against: Sze, Liu and Lo (2004), and an exact solution.

The end moment is compared with the Kirchhoff-Love St. Venant-Kirchhoff solution instead of the
published inextensible circle, whose tip ends 5e-3 away.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .config import AnnulusGeometry, EndForce, EndMoment, LoadPathScene, ShellSection, StripGeometry

# load fraction, then -U and W of the tip
SHEAR_TABLE = np.fromstring(
    """.05 .026 .663 .1 .103 1.309 .2 .381 2.493 .3 .763 3.488 .4 1.184 4.292 .5 1.604 4.933
    .6 2.002 5.444 .7 2.370 5.855 .8 2.705 6.190 .9 3.010 6.467 1 3.286 6.698""",
    sep=" ",
).reshape(-1, 3)
# load fraction, then lift of the inner and outer corner
ANNULUS_TABLE = np.fromstring(
    """.025 1.305 1.789 .1 4.277 5.876 .2 6.725 9.160 .3 8.340 11.213 .4 9.529 12.661
    .5 10.468 13.768 .6 11.257 14.674 .7 11.970 15.469 .8 12.642 16.202 .9 13.282 16.886
    1 13.891 17.528""",
    sep=" ",
).reshape(-1, 3)
ANNULUS_CONVERGED = (13.842, 17.480)  # p = 4 on 60 x 8

TABLES = (
    (
        (StripGeometry(), ShellSection(), EndForce()),
        SHEAR_TABLE,
        (("tip_x", -1.0), ("tip_z", 1.0)),
    ),
    (
        (
            AnnulusGeometry(),
            ShellSection(thickness=0.03, young_modulus=21e6),
            EndForce(force=(0.0, 0.0, 0.8)),
        ),
        ANNULUS_TABLE,
        (("inner_z", 1.0), ("outer_z", 1.0)),
    ),
)


@dataclass(frozen=True)
class Reference:
    """Values along a load path.

    Attributes
    ----------
    source : str
    columns : tuple of (str, float)
        Columns of history.csv that are compared, and their signs.
    fractions : (n,) array
        Load fractions at which values exist, for pictures.
    at : callable
        Load fraction to values ``(n_columns,)``, None where there are none.
    scale : float
        What deviations are divided by.
    """

    source: str
    columns: tuple[tuple[str, float], ...]
    fractions: np.ndarray
    at: Callable[[float], np.ndarray | None]
    scale: float

    def deviation(self, row: dict[str, float]) -> float:
        """Largest deviation of a row of history.csv over the scale; NaN without a value."""
        values = self.at(row["load"])
        if values is None:
            return float("nan")
        found = np.array([sign * row[name] for name, sign in self.columns])
        return float(np.abs(found - values).max() / self.scale)


def reference(scene: LoadPathScene) -> Reference | None:
    """What a scene's path is compared with; None if there is nothing."""
    g, c, load = scene.geometry, scene.structure, scene.load
    posed = (g, replace(c, membrane="gauss"), replace(load, steps=EndForce().steps))
    for problem, table, columns in TABLES:
        if posed == problem:
            return _tabulated(table, columns)
    # a Poisson ratio bends the strip across, too
    if isinstance(g, StripGeometry) and isinstance(load, EndMoment) and c.poisson_ratio == 0.0:
        sign = float(np.sign(load.moment))
        return Reference(
            "exact Kirchhoff-Love solution",
            (("tip_x", -1.0), ("tip_z", sign)),
            np.linspace(0.0, 1.0, 21),
            lambda fraction: exact_moment(g, c, load, fraction),
            g.length,
        )
    return None


def _tabulated(table: np.ndarray, columns: tuple[tuple[str, float], ...]) -> Reference:
    def at(fraction: float) -> np.ndarray | None:
        hit = np.flatnonzero(np.abs(table[:, 0] - fraction) < 1e-9)
        return table[hit[0], 1:] if hit.size else None

    scale = float(table[-1, 1:].max())
    return Reference("Sze, Liu, Lo (2004)", columns, table[:, 0], at, scale)


def exact_moment(
    strip: StripGeometry, section: ShellSection, end: EndMoment, fraction: float
) -> np.ndarray | None:
    """Tip (-U, |W|) of the Kirchhoff-Love strip under an end moment, in closed form.

    Stretch ``l^2 = 1 - 2 D k^2`` and ``D (1 - 2 D k^2) k = M / (E h)``, angle k times the length;
    None beyond the largest moment, at ``k = 1 / sqrt(6 D)``.
    """
    from scipy.optimize import brentq

    length, D = strip.length, section.thickness**2 / 12.0
    load = abs(end.moment) * fraction / (section.young_modulus * section.thickness)
    top = 1.0 / np.sqrt(6.0 * D)
    if load == 0.0:
        return np.zeros(2)
    if load > D * top * 2.0 / 3.0:
        return None
    k = brentq(lambda k: D * (1.0 - 2.0 * D * k * k) * k - load, 0.0, top, xtol=1e-15)
    stretch, angle = np.sqrt(1.0 - 2.0 * D * k * k), length * k
    return np.array([length - stretch * np.sin(angle) / k, stretch * (1.0 - np.cos(angle)) / k])
