"""Shells on raw meshes: roof, large rotations, inflated sphere, zero modes, speed."""

from __future__ import annotations

import time
from functools import partial

import numpy as np
from scipy.sparse.linalg import spsolve
from skfem import LinearForm

from shells import _threads_kernels as kernels
from shells.conditions.supports import extraction, pin, supported
from shells.conditions.triangle_edges import edge_load, hold_edges, rim_edges
from shells.energy.kinks.edge_tables import HeldSlopes
from shells.energy.kinks.triangle_shell import TriangleShell
from shells.energy.material import Material
from shells.energy.volume import EnclosedVolume
from shells.equilibrium.load_paths import load_path
from shells.equilibrium.minimise import minimise
from shells.equilibrium.structure import ShellStructure
from shells.surfaces.triangles.triangle_basis import TriangleBasis

from ...kinds.load_path.published import SHEAR_TABLE
from ..report import Row, best
from ..shells.roof import CONVERGED
from ..shells.roof import roof as spline_roof
from ..shells.speed import panel
from .raw import interpolated, rectangle, sphere

ROOFS = (6, 12, 20)  # points of a side: 94, 334 and 878 triangles
BALLS = (50, 100, 200, 400)  # vertices: 96 to 796 triangles


def roof(n: int, degree: int, thickness: float = 0.25) -> tuple[int, float]:
    """Scordelis-Lo roof on a raw mesh: triangles, deflection of the free edge's middle.

    The load is that of `cases.benchmarks.shells.roof`, with the thickness squared.
    """
    R, L, phi = 25.0, 50.0, np.deg2rad(40.0)
    points, triangles = rectangle(n, size=(2.0 * phi * R, L))

    def bent(x: np.ndarray) -> np.ndarray:
        a = x[..., 0] / R - phi
        return np.stack([R * np.sin(a), x[..., 1], R * np.cos(a)], axis=-1)

    flat = np.column_stack([points, np.zeros(len(points))])
    surface, c = interpolated(flat, triangles, degree, bent)
    basis = TriangleBasis(surface, c)
    shell = TriangleShell(basis, Material(thickness**2 / 12.0))
    ends = rim_edges(surface, c, lambda x: np.minimum(x[..., 1], L - x[..., 1]) < 1e-9)
    E = supported(surface, hold_edges(surface, ends, (0, 2)), pin(surface, 0, (1,)))
    size = 5.0 / 6.0 * 1e-6 * (thickness / 0.25) ** 2
    load = LinearForm(lambda v, w: -size * v[2]).assemble(basis)
    K = shell.gradient_and_tangent(c)[1]
    u = (E @ spsolve((E.T @ K @ E).tocsc(), E.T @ load)).reshape(-1, 3)
    middle = np.argmin(np.abs(points - [2.0 * phi * R, 0.5 * L]).sum(axis=1))
    return surface.n_elements, float(u[middle, 2])


def strip(cells: int = 9, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Strip 10 x 1 of ``2 cells`` triangles, stations jittered by a fifth of their distance."""
    rng = np.random.default_rng(seed)
    x = np.linspace(0.0, 10.0, cells + 1)[:, None] * np.ones(2)
    x[1:-1] += rng.uniform(-0.2, 0.2, (cells - 1, 2)) * 10.0 / cells
    points = np.stack([x, np.broadcast_to([0.0, 1.0], x.shape)], axis=-1).reshape(-1, 2)
    i = 2 * np.arange(cells)
    one = np.stack([i, i + 2, i + 3], axis=1), np.stack([i, i + 3, i + 1], axis=1)
    two = np.stack([i, i + 2, i + 1], axis=1), np.stack([i + 2, i + 3, i + 1], axis=1)
    turned = rng.uniform(size=cells)[:, None] < 0.5
    return points, np.concatenate([np.where(turned, b, a) for a, b in zip(one, two, strict=True)])


def shear(degree: int, cells: int = 9, seed: int = 0) -> tuple[np.ndarray, int]:
    """Tip (-U, W) of a cantilever at the table's fractions of the end shear, and iterations."""
    points, triangles = strip(cells, seed)
    flat = np.column_stack([points, np.zeros(len(points))])
    surface, c = interpolated(flat, triangles, degree, lambda x: x)
    root = rim_edges(surface, c, lambda x: x[..., 0] < 1e-9)
    tip = rim_edges(surface, c, lambda x: x[..., 0] > 10.0 - 1e-9)
    basis = TriangleBasis(surface, c)
    shell = TriangleShell(basis, Material(0.1**2 / 12.0), clamp=HeldSlopes(root))
    force = edge_load(surface, tip, [0.0, 0.0, 4.0 / 1.2e5], c)
    structure = ShellStructure(shell, supported(surface, hold_edges(surface, root)))
    path = load_path(structure, c, lambda f: f * force, list(SHEAR_TABLE[:, 0]))
    if not path.ok:
        raise ArithmeticError(path.failure)
    ends = np.flatnonzero(c[:, 0] > 10.0 - 1e-9)
    moved = [(step.state.coefficients - c)[ends].mean(axis=0) for step in path.steps]
    return np.array(moved)[:, [0, 2]] * [-1.0, 1.0], path.newton_iterations


def ball(n: int, degree: int) -> tuple[TriangleBasis, np.ndarray]:
    """Unit sphere of raw triangles."""
    surface, c = interpolated(
        *sphere(n), degree, lambda x: x / np.linalg.norm(x, axis=-1, keepdims=True)
    )
    return TriangleBasis(surface, c), c


def inflated(n: int, degree: int) -> tuple[int, float, int]:
    """St. Venant-Kirchhoff sphere blown to stretch 1.2: triangles, its error, iterations."""
    basis, c = ball(n, degree)
    shell = TriangleShell(basis, Material(1e-8, poisson_ratio=0.3))
    structure = ShellStructure(shell, extraction(basis.surface.reduction), EnclosedVolume(basis))
    end = minimise(structure, c, (1.2 - 1.0 / 1.2) * 1.3)
    if not end.ok:
        raise ArithmeticError(end.failure)
    ratio = structure.volume(end.state.coefficients) / structure.volume(c)
    return basis.surface.n_elements, ratio ** (1.0 / 3.0) / 1.2 - 1.0, end.iterations


def zero_modes(n: int, degree: int) -> tuple[int, float, float, float]:
    """Triangles; largest of the six and the seventh over the last; cost of a rigid motion."""
    basis, c = ball(n, degree)
    shell = TriangleShell(basis, Material(1e-3, poisson_ratio=0.3))
    values = np.linalg.eigvalsh(shell.gradient_and_tangent(c)[1].toarray())
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    cost = sum(shell.energy(c @ turn.T + 1.0))
    sixth = np.abs(values[:6]).max() / values[-1]
    return basis.surface.n_elements, float(sixth), float(values[6] / values[-1]), cost


def speed(n: int) -> tuple[dict[str, float], float]:
    """Microseconds an element of residual and tangent, one thread; tangent's asymmetry."""
    quad, theta, _ = panel(24, 3)
    threads = kernels.get_num_threads()
    kernels.set_num_threads(1)
    found = {"cubic quad": best(partial(quad.elements, theta, True)) / 24**2}
    found["cubic quad, assembled"] = best(partial(quad.gradient_and_tangent, theta)) / 24**2
    for degree in (2, 3):
        basis, c = ball(n, degree)
        x = c + 1e-3 * np.random.default_rng(0).standard_normal(c.shape)
        material, count = Material(1e-4, poisson_ratio=0.3), basis.surface.n_elements
        shell, name = TriangleShell(basis, material), f"triangle of degree {degree}"
        found[f"{name}, without edges"] = best(partial(shell.elements, x, True)) / count
        found[f"{name}, with edges, assembled"] = (
            best(partial(shell.gradient_and_tangent, x)) / count
        )
    kernels.set_num_threads(threads)
    K = shell.gradient_and_tangent(x)[1]
    return found, float(abs(K - K.T).max() / abs(K).max())


def roof_rows(quick: bool) -> list[Row]:
    rows: list[Row] = []
    for degree in (3, 2):
        for n in ROOFS[:2] if quick else ROOFS:
            start = time.perf_counter()
            triangles, value = roof(n, degree)
            rows.append(
                {
                    "case": f"roof, degree {degree}, {triangles} triangles",
                    "seconds": time.perf_counter() - start,
                    "error": abs(value / CONVERGED - 1.0),
                    "reference": "converged -0.300592457",
                    "degree": degree,
                    "triangles": triangles,
                    "deflection": f"{value:.7f}",
                }
            )
    return rows


def locking_rows(quick: bool) -> list[Row]:
    """The roof at falling thickness, cubic."""
    rows: list[Row] = []
    splines = 24 if quick else 48
    for thickness in (0.025,) if quick else (0.025, 0.0025):
        exact, _ = spline_roof(splines, 5, thickness=thickness)
        for n in ROOFS[:2] if quick else ROOFS:
            start = time.perf_counter()
            triangles, value = roof(n, 3, thickness)
            rows.append(
                {
                    "case": f"thin roof, h={thickness:g}, {triangles} triangles",
                    "seconds": time.perf_counter() - start,
                    "error": abs(value / exact - 1.0),
                    "reference": f"p=5 on {splines}^2",
                    "triangles": triangles,
                    "thickness/radius": thickness / 25.0,
                    "deflection/reference": value / exact,
                }
            )
    return rows


def shear_rows(quick: bool) -> list[Row]:
    rows: list[Row] = []
    for cells in (9,) if quick else (9, 18):
        start = time.perf_counter()
        tips, newton = shear(3, cells)
        error = np.abs(tips - SHEAR_TABLE[:, 1:]).max() / SHEAR_TABLE[-1, 1:].max()
        rows.append(
            {
                "case": f"end shear, degree 3, {2 * cells} triangles",
                "seconds": time.perf_counter() - start,
                "error": float(error),
                "reference": "Sze et al. (2004), whole path",
                "triangles": 2 * cells,
                "value": " ".join(f"{x:.4f}" for x in tips[-1]),
                "newton": newton,
            }
        )
    return rows


def sphere_rows(quick: bool) -> list[Row]:
    rows: list[Row] = []
    for degree in (3, 2):
        for n in BALLS[:2] if quick else BALLS:
            start = time.perf_counter()
            triangles, error, iterations = inflated(n, degree)
            rows.append(
                {
                    "case": f"inflated sphere, degree {degree}, {triangles} triangles",
                    "seconds": time.perf_counter() - start,
                    "error": abs(error),
                    "reference": "closed form, stretch 1.2",
                    "degree": degree,
                    "triangles": triangles,
                    "iterations": iterations,
                }
            )
    return rows


def mode_rows(quick: bool) -> list[Row]:
    rows: list[Row] = []
    for degree in (3, 2):
        start = time.perf_counter()
        triangles, sixth, seventh, cost = zero_modes(25 if quick else 50, degree)
        rows.append(
            {
                "case": f"six zero modes, degree {degree}, {triangles} triangles",
                "seconds": time.perf_counter() - start,
                "error": sixth,
                "error_kind": "largest of six eigenvalues over the largest of all",
                "reference": "zero",
                "degree": degree,
                "seventh": seventh,
                "rigid motion": cost,
            }
        )
    return rows


def speed_rows(quick: bool) -> list[Row]:
    found, error = speed(200 if quick else 400)
    peer = found["cubic quad"]
    return [
        {
            "case": f"speed, {name}",
            "seconds": seconds,
            "error": error,
            "error_kind": "asymmetry of the tangent",
            "reference": "a cubic spline quad, one thread, same run",
            "us/element": 1e6 * seconds,
            "times a quad": seconds / peer,
        }
        for name, seconds in found.items()
    ]
