"""Two spheres near each other: what a mesh that does not resolve their film must not call met."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from hbem.flows.mesh_share import RESOLVING, film_ratio
from hbem.flows.stokes_flow import StokesFlow
from hbem.flows.surface_traction import SurfaceTraction
from hbem.surfaces.patches import BezierPatches, union
from hbem.traction_error import Verdict

from ....geometry.bodies import sphere
from .exact import approaching, following
from .fields import Trial, resolves

# the fewest rows with which a graded sphere is exact to 1e-9
ROWS = {1.0: 6, 0.3: 7, 0.1: 8, 1e-2: 10, 1e-3: 13, 1e-4: 16, 1e-5: 19}
TOLERANCE = 1e-2
ROW = 0.5  # first row of the graded meshes, in film lengths
FINE, FINE_ROW = (28, 16), 0.25
Z = np.array([0.0, 0.0, 1.0])
MOTIONS = {"approaching": approaching, "following": following}
# elements around by the name of a mesh; as many from pole to pole if it is not graded
MESHES = {"4 x 4": 4, "6 x 6": 6, "9 x 9": 9, "graded, 6 around": 6, "graded, 8 around": 8}


def trials(quick: bool) -> Iterator[Trial]:
    """Each gap on each mesh: force against the series, traction against a far finer mesh."""
    for gap in (1e-3,) if quick else ROWS:
        pairs = [_Pair.on(gap, mesh) for mesh in list(MESHES)[: 1 if quick else None]]
        finest = None if quick else _finest(gap)
        for motion, force in MOTIONS.items():
            truth = None if finest is None else _profile(finest, motion, gap)
            for pair in pairs:
                yield from pair.tried(motion, force(gap), truth)


def bodies(n_s: int, n_t: int, gap: float, row: float | None, degree: int = 2) -> BezierPatches:
    """Two unit spheres, the second above the first, both graded towards the gap."""
    if row is not None:
        row = min(row * np.sqrt(0.5 * gap), np.pi / n_s)
    one = sphere(n_s, n_t, degree=degree, pole_row=row)
    both = union(one, one)
    assert one.coefficients is not None
    turned = one.coefficients * [1.0, -1.0, -1.0] + (2.0 + gap) * Z
    return replace(both, coefficients=np.concatenate([one.coefficients, turned]))


@dataclass(frozen=True)
class _Pair:
    """Two spheres on one mesh."""

    mesh: str
    gap: float
    flow: StokesFlow

    @classmethod
    def on(cls, gap: float, mesh: str) -> _Pair:
        around = MESHES[mesh]
        size = (ROWS[gap], around, gap, ROW) if "graded" in mesh else (around, around, gap, None)
        return cls(mesh, gap, StokesFlow(bodies(*size), tolerance=TOLERANCE))

    def tried(
        self, motion: str, force: float, truth: Callable[[np.ndarray], np.ndarray] | None
    ) -> Iterator[Trial]:
        found = self.flow.traction(moving(motion, self.gap))
        forces = found.force()[:, 2] / (6.0 * np.pi * force)
        film = "resolved" if film_ratio(self.flow.facing) < RESOLVING else "not resolved"
        trial = {
            "case": f"{motion} at {self.gap:g}, {self.mesh}",
            "tolerance": TOLERANCE,
            "refused": found.error.verdict is not Verdict.MET,
            "share": "mesh",
            "before": np.nan,
            "resolved": resolves(self.flow, found.error),
        }
        off = np.abs(np.abs(forces) - 1.0).max()
        yield trial | {"promise": f"force, film {film}", "error": float(off), "estimate": np.nan}
        if truth is not None:
            error = _distance(self.flow, found, truth)
            told = {"error": error, "estimate": found.error.total}
            yield trial | {"promise": f"traction, film {film}"} | told


def moving(motion: str, gap: float) -> Callable[[np.ndarray], np.ndarray]:
    above = -1.0 if motion == "approaching" else 1.0
    return lambda x: np.where(x[:, 2:] < 1.0 + 0.5 * gap, Z, above * Z)


def _first(flow: StokesFlow) -> tuple[int, np.ndarray, np.ndarray, np.ndarray]:
    """Points on the first sphere: their number, polar angle and radial direction, weights."""
    n = flow.points.shape[0] // 2
    x = flow.points[:n]
    rho = np.hypot(x[:, 0], x[:, 1])
    return n, np.arctan2(rho, x[:, 2]), x[:, :2] / rho[:, None], flow.weights[:n]


def _finest(gap: float) -> StokesFlow:
    body = bodies(*FINE, gap, FINE_ROW, degree=3)
    return StokesFlow(body, tolerance=1e-4, compression="dense", measure="none")


def _profile(flow: StokesFlow, motion: str, gap: float) -> Callable[[np.ndarray], np.ndarray]:
    """Radial and axial traction of the first sphere as functions of the polar angle."""
    found = flow.traction(moving(motion, gap))
    n, angle, radial, _ = _first(flow)
    values = found.values[:n]
    values = np.stack([np.sum(values[:, :2] * radial, axis=1), values[:, 2]], axis=1)
    rows, of = np.unique(np.round(angle, 12), return_inverse=True)
    mean = np.stack([np.bincount(of, v) for v in values.T], axis=1) / np.bincount(of)[:, None]
    film = np.sqrt(0.5 * gap)
    spline = CubicSpline(np.arcsinh(rows / film), mean)
    return lambda theta: spline(np.arcsinh(theta / film))


def _distance(
    flow: StokesFlow, found: SurfaceTraction, truth: Callable[[np.ndarray], np.ndarray]
) -> float:
    """Relative L2 distance of the traction on the first sphere."""
    n, angle, radial, weights = _first(flow)
    exact = truth(angle)
    exact = np.column_stack([exact[:, :1] * radial, exact[:, 1]])
    off = np.sum((found.values[:n] - exact) ** 2, axis=1)
    return float(np.sqrt(weights @ off / (weights @ np.sum(exact**2, axis=1))))
