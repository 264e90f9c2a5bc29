"""Large rotations: cantilever under end shear and end moment, slit annulus.

Tables of Sze, Liu and Lo (2004); the end moment against the exact Kirchhoff-Love
St. Venant-Kirchhoff solution instead of the inextensible circle, the annulus also against its
converged Kirchhoff-Love values.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np

from ... import loader
from ...kinds.load_path.build import LoadPathProblem, problem
from ...kinds.load_path.config import EndMoment, LoadPathScene, StripGeometry
from ...kinds.load_path.published import ANNULUS_CONVERGED, ANNULUS_TABLE, SHEAR_TABLE, exact_moment
from ..report import Row


def _posed(
    name: str, along: int, degree: int, membrane: str, across: int = 1
) -> tuple[LoadPathScene, LoadPathProblem]:
    """A shipped scene on another mesh."""
    scene = loader.read(name)
    assert isinstance(scene, LoadPathScene)
    mesh = replace(scene.mesh, along=along, across=across, degree=degree)
    scene = replace(scene, mesh=mesh, structure=replace(scene.structure, membrane=membrane))
    return scene, problem(scene)


def _path(posed: LoadPathProblem, fractions: np.ndarray) -> tuple[dict[str, np.ndarray], int]:
    """Displacements ``(n_fractions, 3)`` by point, and Newton's iterations."""
    path = posed.follow(list(fractions))
    moved = [posed.displacement(step.state.coefficients) for step in path.steps]
    return {name: np.array([m[name] for m in moved]) for name in posed.tracked}, (
        path.newton_iterations
    )


def shear(n: int, degree: int, membrane: str = "gauss") -> tuple[np.ndarray, int]:
    """Tip (-U, W) of the cantilever at the table's fractions of the end shear."""
    _, posed = _posed("cantilever-shear", n, degree, membrane)
    moved, newton = _path(posed, SHEAR_TABLE[:, 0])
    return moved["tip"][:, [0, 2]] * [-1.0, 1.0], newton


def moment(n: int, degree: int, membrane: str = "gauss") -> tuple[float, int]:
    """Largest tip error along the path to the full circle, absolute."""
    scene, posed = _posed("cantilever-moment", n, degree, membrane)
    g, c, load = scene.geometry, scene.structure, scene.load
    assert isinstance(g, StripGeometry)
    assert isinstance(load, EndMoment)
    fractions = np.arange(1, 21) / 20
    moved, newton = _path(posed, fractions)
    exact = np.array([exact_moment(g, c, load, f) for f in fractions])
    return float(np.abs(moved["tip"][:, [0, 2]] * [-1.0, 1.0] - exact).max()), newton


def annulus(
    around: int, across: int, degree: int, membrane: str = "gauss"
) -> tuple[np.ndarray, int]:
    """Lift of both corners of the slit annulus at the table's fractions of the line load."""
    _, posed = _posed("slit-annulus", around, degree, membrane, across)
    moved, newton = _path(posed, ANNULUS_TABLE[:, 0])
    return np.stack([moved["inner"][:, 2], moved["outer"][:, 2]], axis=1), newton


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
        ((24, 3, 3, "gauss"), (24, 3, 3, "reduced")),
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
