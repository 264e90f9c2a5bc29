"""Scordelis-Lo roof: formulations [T tab. 6.1], locking at falling thickness, H2 rates.

The load is 5/6e-6: the thesis' 5/3e-6 counts a half twice.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from scipy.sparse.linalg import spsolve
from skfem import LinearForm

from shells.conditions.supports import hinge, pin, supported
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material
from shells.surfaces.spline_surface import SplineSurface
from shells.surfaces.splines import SplineSpace
from shells.surfaces.surface_basis import SurfaceBasis

from ..report import Row

CONVERGED = -0.300592457  # p = 4 on 32^2 and p = 5 on 48^2 agree to these digits
# degree, Gauss points per direction, points of the membrane energy
REMEDIES = (
    (2, 3, "gauss"),
    (2, 2, "gauss"),
    (2, 3, "reduced"),
    (3, 4, "gauss"),
    (3, 3, "gauss"),
    (3, 4, "reduced"),
    (4, 5, "gauss"),
)


def stack(*components: Any) -> np.ndarray:
    """Components to vectors along the last axis."""
    return np.stack(np.broadcast_arrays(*components), axis=-1)


def roof(n: int, degree: int, **options: Any) -> tuple[float, float]:
    """Deflection of the free edge's middle (see `roof_response`), and seconds."""
    start = time.perf_counter()
    s, t, u = roof_response(n, degree, **options)
    end, middle = np.array([1.0]), np.array([0.5 * t.breaks[-1]])
    at_A = np.outer(s.evaluate(end)[0], t.evaluate(middle)[0]).ravel()
    return float((at_A @ u)[2]), time.perf_counter() - start


def roof_response(
    n: int,
    degree: int,
    *,
    thickness: float = 0.25,
    points: int | None = None,
    formulation: str = "parametrization-free",
    sine: bool = False,
    membrane: str = "gauss",
) -> tuple[SplineSpace, SplineSpace, np.ndarray]:
    """Linear response of the Scordelis-Lo roof to ``5/6e-6 (h/h0)^2``: spaces, coefficients.

    ``sine`` takes axial coordinates in which ``|z|`` is half a sine, zero at both supports.
    """
    R, L, phi = 25.0, 50.0, np.deg2rad(40.0)
    s = SplineSpace(np.linspace(0.0, 1.0, n + 1), degree)
    t = SplineSpace(np.linspace(0.0, L, n + 1), degree)
    surface = SplineSurface(s, t)

    def reference(x: np.ndarray, y: np.ndarray) -> tuple:
        a, k, zero = phi * (2.0 * x - 1.0), 2.0 * phi, 0.0 * x
        sin, cos = R * np.sin(a), R * np.cos(a)
        return (
            stack(sin, y, cos),
            (k * stack(cos, zero, -sin), stack(zero, 1.0, zero)),
            (k**2 * stack(-sin, zero, -cos), stack(zero, zero, zero), stack(zero, zero, zero)),
        )

    def sine_chart(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        # y = L (1 - cos(pi v)) / 2: dy/dv is half a sine, zero at both supports
        angle = np.arccos(1.0 - 2.0 * y / L)
        slope, bend = 0.5 * np.pi * L * np.sin(angle), 0.5 * np.pi**2 * L * np.cos(angle)
        return stack(1.0, slope), stack(0.0, bend)

    basis = SurfaceBasis(surface, reference, points)
    material = Material(thickness**2 / 12.0)
    shell = KirchhoffLove(
        basis,
        material,
        exact_reference=True,
        formulation=formulation,
        chart=sine_chart if sine else None,
        membrane=membrane,
    )
    ends = [hinge(surface, "t", end, (0, 2)) for end in (0, 1)]
    E = supported(surface, *ends, pin(surface, 0, (1,)))
    size = 5.0 / 6.0 * 1e-6 * (thickness / 0.25) ** 2
    load = LinearForm(lambda v, w: -size * v[2]).assemble(basis)
    _, K = shell.gradient_and_tangent(np.zeros(basis.N))
    u = (E @ spsolve((E.T @ K @ E).tocsc(), E.T @ load)).reshape(-1, 3)
    return s, t, u


def formulation_rows(n: int) -> list[Row]:
    rows: list[Row] = []
    first = None
    cases: tuple[tuple[str, dict[str, Any]], ...] = (
        ("classical, linear", {"formulation": "classical"}),
        ("classical, sine", {"formulation": "classical", "sine": True}),
        ("parametrization-free", {}),
    )
    for name, options in cases:
        value, seconds = roof(n, 2, **options)
        first = value if first is None else first
        rows.append(
            {
                "case": f"roof {n}^2 p=2, {name}",
                "seconds": seconds,
                "error": abs(value / CONVERGED - 1.0),
                "reference": "converged -0.300592457",
                "deflection": f"{value:.7f}",
                "difference to first": abs(value / first - 1.0),
            }
        )
    return rows


def locking_rows(sizes: tuple[int, ...], reference: int) -> list[Row]:
    """Degree, quadrature and the reduced membrane rule at falling thickness."""
    rows = []
    for thickness in (0.25, 0.025, 0.0025):
        exact, _ = roof(reference, 5, thickness=thickness)
        for degree, points, membrane in REMEDIES:
            for n in sizes:
                value, seconds = roof(
                    n, degree, thickness=thickness, points=points, membrane=membrane
                )
                rule = "reduced membrane rule" if membrane == "reduced" else f"{points} points"
                rows.append(
                    {
                        "case": f"roof h={thickness:g}, p={degree}, {rule}, {n}^2",
                        "seconds": seconds,
                        "error": abs(value / exact - 1.0),
                        "reference": f"p=5 on {reference}^2",
                        "degree": degree,
                        "rule": rule,
                        "elements": f"{n}^2",
                        "deflection/reference": value / exact,
                        "thickness/radius": thickness / 25.0,
                    }
                )
    return rows


def rate_rows(sizes: tuple[int, ...], fine: int) -> list[Row]:
    """H2 error of the roof's linear response against p = 4; rate p - 1."""
    grid = (np.arange(160) + 0.5) / 160
    exact = _derivatives(roof_response(fine, 4), grid)
    norm = np.linalg.norm(exact)
    rows = []
    for degree in (2, 3):
        last = None
        for n in sizes:
            start = time.perf_counter()
            error = np.linalg.norm(_derivatives(roof_response(n, degree), grid) - exact) / norm
            rows.append(
                {
                    "case": f"roof H2, p={degree}, {n}^2",
                    "seconds": time.perf_counter() - start,
                    "error": float(error),
                    "reference": f"p=4 on {fine}^2",
                    "rate": "" if last is None else f"{np.log2(last / error):.2f}",
                }
            )
            last = error
    return rows


def _derivatives(response: tuple, grid: np.ndarray) -> np.ndarray:
    """Value and derivatives up to order two over the unit square of parameters."""
    s, t, u = response
    length = t.breaks[-1]
    u = u.reshape(s.n, t.n, 3)
    parts = []
    for i, j in ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (1, 1), (0, 2)):
        rows, columns = s.evaluate(grid, i), t.evaluate(length * grid, j) * length**j
        parts.append(np.einsum("xa,yb,abc->xyc", rows, columns, u, optimize=True))
    return np.stack(parts)
