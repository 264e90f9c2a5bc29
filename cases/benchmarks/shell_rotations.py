"""Large rotations: cantilever under end shear and end moment, slit annulus.

Tables of Sze, Liu and Lo (2004); the end moment against the exact Kirchhoff-Love
St. Venant-Kirchhoff solution instead of the inextensible circle, the annulus also against its
converged Kirchhoff-Love values.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from scipy.optimize import brentq

from shells.continuation import Path, load_path
from shells.dynamics import ShellStructure
from shells.kirchhoff_love import KirchhoffLove
from shells.loads import end_moment, line_load
from shells.material import Material
from shells.splines import SplineSpace
from shells.support import clamp, supported
from shells.surface import SplineSurface
from shells.surface_basis import SurfaceBasis

from .shell_roof import stack

Row = dict[str, Any]
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


def strip(
    length: float, n: int, degree: int, membrane: str = "gauss"
) -> tuple[np.ndarray, ShellStructure]:
    """Coefficients and structure of a cantilever of unit width, h = 0.1, E = 1.2e6."""
    s, t = SplineSpace(np.linspace(0.0, length, n + 1), degree), SplineSpace([0.0, 1.0], degree)
    surface = SplineSurface(s, t)
    c = stack(np.repeat(s.greville, t.n), np.tile(t.greville, s.n), 0.0)
    material = Material(0.1**2 / 12.0, stiffness=1.2e5)
    shell = KirchhoffLove(SurfaceBasis(surface, c), material, membrane=membrane)
    return c, ShellStructure(shell, supported(surface, clamp(surface, "s", 0, (2,))))


def _tips(path: Path, structure: ShellStructure, c: np.ndarray) -> np.ndarray:
    """Mean displacement of the free edge at each station, ``(n, 3)``."""
    rows = structure.shell.basis.surface.ring(-1)
    return np.array([(step.state.coefficients - c)[rows].mean(axis=0) for step in path.steps])


def shear(n: int, degree: int, membrane: str = "gauss") -> tuple[np.ndarray, int]:
    """Tip (-U, W) of the cantilever (L = 10) at the table's fractions of the end shear 4."""
    c, structure = strip(10.0, n, degree, membrane)
    force = line_load(structure.shell.basis.surface, "s", 1, np.array([0.0, 0.0, 4.0]), c)
    path = load_path(structure, c, lambda f: f * force, SHEAR_TABLE[:, 0])
    return _tips(path, structure, c)[:, [0, 2]] * [-1.0, 1.0], path.newton_iterations


def exact_moment(fraction: float) -> np.ndarray:
    """Tip (-U, W) of the Kirchhoff-Love strip under an end moment, in closed form.

    Stretch ``l^2 = 1 - 2 D k^2`` and ``D (1 - 2 D k^2) k = M / (E h)``, angle 12 k.
    """
    D, load = 0.1**2 / 12.0, 50.0 * np.pi / 3.0 * fraction / 1.2e5
    k = brentq(lambda k: D * (1.0 - 2.0 * D * k * k) * k - load, 0.0, 10.0, xtol=1e-15)
    stretch, angle = np.sqrt(1.0 - 2.0 * D * k * k), 12.0 * k
    return np.array([12.0 - stretch * np.sin(angle) / k, stretch * (1.0 - np.cos(angle)) / k])


def moment(n: int, degree: int, membrane: str = "gauss") -> tuple[float, int]:
    """Largest tip error along the path to the full circle (L = 12), absolute."""
    c, structure = strip(12.0, n, degree, membrane)
    fractions = np.arange(1, 21) / 20
    surface, full = structure.shell.basis.surface, 50.0 * np.pi / 3.0
    path = load_path(structure, c, lambda f: end_moment(surface, "s", 1, full * f, c), fractions)
    tips = np.abs(_tips(path, structure, c)[:, [0, 2]])
    exact = np.array([exact_moment(f) for f in fractions])
    return float(np.abs(tips - exact).max()), path.newton_iterations


def annulus_structure(
    around: int, across: int, degree: int, membrane: str = "gauss"
) -> tuple[np.ndarray, ShellStructure]:
    """Flat coefficients and structure of the slit annulus; unknowns are displacements."""
    inner, outer, h = 6.0, 10.0, 0.03
    s = SplineSpace(np.linspace(0.0, 2.0 * np.pi, around + 1), degree)
    t = SplineSpace(np.linspace(inner, outer, across + 1), degree)
    surface = SplineSurface(s, t)

    def ring(a: np.ndarray, r: np.ndarray) -> tuple:
        c, d, zero = np.cos(a), -np.sin(a), 0.0 * a
        return (
            stack(r * c, r * d, zero),
            (r[..., None] * stack(d, -c, zero), stack(c, d, zero)),
            (r[..., None] * stack(-c, -d, zero), stack(zero, zero, zero), stack(d, -c, zero)),
        )

    material = Material(h**2 / 12.0, stiffness=21e6 * h)
    shell = KirchhoffLove(
        SurfaceBasis(surface, ring), material, exact_reference=True, membrane=membrane
    )
    a, r = np.repeat(s.greville, t.n), np.tile(t.greville, s.n)
    flat = stack(r * np.cos(a), -r * np.sin(a), 0.0)
    return flat, ShellStructure(shell, supported(surface, clamp(surface, "s", 0, (2,))))


def annulus(
    around: int, across: int, degree: int, membrane: str = "gauss"
) -> tuple[np.ndarray, int]:
    """Lift of both corners of the slit annulus at the table's fractions of the line load 0.8."""
    flat, structure = annulus_structure(around, across, degree, membrane)
    surface = structure.shell.basis.surface
    force = line_load(surface, "s", 1, np.array([0.0, 0.0, 0.8]), flat)
    start = np.zeros_like(flat)
    path = load_path(structure, start, lambda f: f * force, ANNULUS_TABLE[:, 0])
    corners = surface.ring(-1)[[0, -1]]
    lift = np.array([np.abs(step.state.coefficients[corners, 2]) for step in path.steps])
    return lift, path.newton_iterations


def _row(case: str, seconds: float, newton: int, **columns: Any) -> Row:
    return {"case": case, "seconds": seconds, **columns, "newton": newton}


def _against(table: np.ndarray, values: np.ndarray) -> float:
    """Largest deviation from a table along the path, over the largest final value."""
    return float(np.abs(values - table[:, 1:]).max() / table[-1, 1:].max())


def rotation_rows(quick: bool) -> list[Row]:
    """Deviations from tables, exact and converged values along whole paths."""
    rows = []
    for n, p in ((16, 2), (32, 2), (16, 3)):
        start = time.perf_counter()
        tips, newton = shear(n, p)
        rows.append(
            _row(
                f"end shear {n}x1 p={p}",
                time.perf_counter() - start,
                newton,
                error=_against(SHEAR_TABLE, tips),
                reference="Sze et al. (2004), whole path",
                value=" ".join(f"{x:.4f}" for x in tips[-1]),
            )
        )
    for n, p in ((16, 2), (16, 3), (32, 3)):
        start = time.perf_counter()
        error, newton = moment(n, p)
        rows.append(
            _row(
                f"end moment {n}x1 p={p}",
                time.perf_counter() - start,
                newton,
                error=error / 12.0,
                reference="exact Kirchhoff-Love, whole path",
                value=f"absolute {error:.1e}",
            )
        )
    coarse, fine = (
        ((24, 3, 3, "gauss"), (24, 3, 3, "patch")),
        ((40, 6, 3, "gauss"), (60, 8, 4, "gauss")),
    )
    for m, k, p, rule in coarse if quick else coarse + fine:
        start = time.perf_counter()
        lift, newton = annulus(m, k, p, rule)
        rows.append(
            _row(
                f"slit annulus {m}x{k} p={p}, {rule} membrane points",
                time.perf_counter() - start,
                newton,
                error=float(np.abs(lift[-1] / ANNULUS_CONVERGED - 1.0).max()),
                reference=f"converged; {_against(ANNULUS_TABLE, lift):.1e} from Sze et al.",
                value=" ".join(f"{x:.3f}" for x in lift[-1]),
            )
        )
    return rows
