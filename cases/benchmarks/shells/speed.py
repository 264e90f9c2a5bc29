"""Speed of the shell: fused kernel against the same energy as a plain scikit-fem form, solvers.

`plain_tangent` is [T 2.12b] as one would write it in scikit-fem; it is the oracle of the kernel
and its peer in the speed table.
"""

from __future__ import annotations

import time
from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from skfem import BilinearForm, LinearForm

from shells import _threads_kernels as kernels
from shells.conditions.rigid_motions import coefficients_of
from shells.conditions.supports import hinge, supported
from shells.energy.densities import StVenantKirchhoff
from shells.energy.hyperelastic import HyperelasticShell
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material
from shells.equilibrium.load_paths import load_path
from shells.equilibrium.multigrid import multigrid
from shells.equilibrium.newton import factorize
from shells.equilibrium.structure import ShellStructure
from shells.surfaces.spline_surface import SplineSurface
from shells.surfaces.splines import SplineSpace
from shells.surfaces.surface_basis import SurfaceBasis

from ..report import Row, best


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("c...,c...->...", a, b)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    # three times faster than np.cross on arrays of this shape: the peer gets a fair chance
    return np.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


@BilinearForm
def plain_tangent(u: Any, v: Any, w: Any) -> np.ndarray:
    """Second variation of the energy, classical form, arguments theta, C, D, A and B."""
    theta = w["theta"]
    t, h = np.moveaxis(theta.grad, 1, 0), theta.hess
    z = _cross(t[0], t[1])
    J = np.sqrt(_dot(z, z))
    nu = z / J
    pairs = ((0, 0), (1, 1), (0, 1))
    weight = (1.0, 1.0, 2.0)

    def normal(f: Any) -> tuple[np.ndarray, np.ndarray]:
        dz = _cross(f.grad[:, 0], t[1]) + _cross(t[0], f.grad[:, 1])
        along = _dot(nu, dz)
        return (dz - along * nu) / J, along

    du, au = normal(u)
    dv, av = normal(v)
    ddz = _cross(u.grad[:, 0], v.grad[:, 1]) + _cross(v.grad[:, 0], u.grad[:, 1])
    second = (ddz - _dot(nu, ddz) * nu - au * dv - av * du) / J - _dot(du, dv) * nu

    def first(f: Any, dn: np.ndarray) -> tuple[list, list]:
        e = [
            0.5 * s * (_dot(t[a], f.grad[:, b]) + _dot(t[b], f.grad[:, a]))
            for (a, b), s in zip(pairs, weight, strict=True)
        ]
        k = [
            s * (_dot(f.hess[:, a, b], nu) + _dot(h[:, a, b], dn))
            for (a, b), s in zip(pairs, weight, strict=True)
        ]
        return e, k

    (eu, ku), (ev, kv) = first(u, du), first(v, dv)
    C, D, A, B = (np.asarray(w[name]) for name in ("C", "D", "A", "B"))
    total = np.zeros_like(J)
    for i, ((a, b), s) in enumerate(zip(pairs, weight, strict=True)):
        n = m = 0.0
        for j, ((c, d), r) in enumerate(zip(pairs, weight, strict=True)):
            total = total + C[i, j] * (eu[i] * ev[j] + D * ku[i] * kv[j])
            n = n + C[i, j] * 0.5 * r * (_dot(t[c], t[d]) - A[j])
            m = m + D * C[i, j] * r * (_dot(h[:, c, d], nu) - B[j])
        ee = 0.5 * s * (_dot(u.grad[:, a], v.grad[:, b]) + _dot(u.grad[:, b], v.grad[:, a]))
        kk = s * (_dot(u.hess[:, a, b], dv) + _dot(v.hess[:, a, b], du) + _dot(h[:, a, b], second))
        total = total + n * ee + m * kk
    return total


def plain_arguments(shell: KirchhoffLove, theta: np.ndarray) -> dict[str, Any]:
    """Arguments of `plain_tangent` for a classical shell."""
    (A, B), _, _ = shell.forms(theta)
    return {
        "theta": theta.ravel(),
        "C": np.moveaxis(shell.elasticity, (2, 3), (0, 1)),
        "D": shell.material.flexural_rigidity,
        "A": np.moveaxis(A, 2, 0),
        "B": np.moveaxis(B, 2, 0),
    }


def panel(n: int, degree: int) -> tuple[KirchhoffLove, np.ndarray, SplineSurface]:
    """A curved panel of n x n elements and a configuration near it."""
    space = SplineSpace(np.linspace(0.0, 1.0, n + 1), degree)
    surface = SplineSurface(space, space)
    x, y = np.repeat(space.greville, space.n), np.tile(space.greville, space.n)
    c = np.stack([x, y, 0.2 * x * (1.0 - x)], axis=1)
    shell = KirchhoffLove(
        SurfaceBasis(surface, c), Material(1e-4, poisson_ratio=0.3), formulation="classical"
    )
    noise = np.random.default_rng(0).standard_normal(c.shape)
    return shell, c + 1e-3 * noise, surface


def kernel_rows(n: int, degrees: tuple[int, ...] = (2, 3)) -> list[Row]:
    """Residual and tangent: fused kernel on 1 and 2 threads, pointwise path, plain form."""
    rows = []
    for degree in degrees:
        shell, theta, _ = panel(n, degree)
        # on the same mesh: on few elements the plain form's calls would cost more than its work
        arguments = plain_arguments(shell, theta)
        start = time.perf_counter()
        exact = plain_tangent.elemental(shell.basis, **arguments)
        plain = (time.perf_counter() - start) / n**2
        exact, fused = exact.tocsr(), shell.gradient_and_tangent(theta)[1]
        error = float(abs(fused - exact).max() / abs(exact).max())
        threads = kernels.get_num_threads()
        seconds = {}
        for count in sorted({1, threads}):
            kernels.set_num_threads(count)
            seconds[count] = best(partial(shell.elements, theta, True)) / n**2
        kernels.set_num_threads(threads)
        pointwise = HyperelasticShell(shell.basis, StVenantKirchhoff(shell.material))
        slow = best(partial(pointwise.gradient_and_tangent, theta), 2) / n**2
        fused_rows = [(f"fused, {count} thread(s)", seconds[count]) for count in seconds]
        for name, value in (
            *fused_rows,
            ("pointwise, any material", slow),
            ("plain scikit-fem form", plain),
        ):
            rows.append(
                {
                    "case": f"p={degree}, {name}",
                    "seconds": value * n**2,
                    "error": error,
                    "reference": "plain scikit-fem form",
                    "us/element": 1e6 * value,
                    "ratio": plain / value,
                    "peer": "plain scikit-fem form",
                }
            )
    return rows


def _held_panel(n: int, degree: int) -> tuple[KirchhoffLove, np.ndarray, csr_matrix]:
    """A panel hinged along two edges: shell, reference coefficients, extraction."""
    shell, _, surface = panel(n, degree)
    E = supported(surface, hinge(surface, "s", 0), hinge(surface, "s", 1))
    return shell, coefficients_of(shell.basis), E


def solver_rows(sizes: tuple[int, ...]) -> list[Row]:
    """Direct factorization against smoothed aggregation with the rigid modes, on a tangent."""
    rows = []
    for n in sizes:
        shell, c, E = _held_panel(n, 2)
        K = (E.T @ shell.gradient_and_tangent(c)[1] @ E).tocsr()
        b = np.random.default_rng(0).standard_normal(K.shape[0])
        found, seconds = {}, {}
        for name, solver in (("direct", factorize), ("amg", multigrid(c, E, tolerance=1e-8))):
            start = time.perf_counter()
            found[name] = solver(K)(b)
            seconds[name] = time.perf_counter() - start
        error, peer = (
            float(np.linalg.norm(K @ found[name] - b) / np.linalg.norm(b)) for name in found
        )
        rows.append(
            {
                "case": f"tangent of {n}^2 elements, p=2, direct",
                "seconds": seconds["direct"],
                "error": error,
                "reference": "residual",
                "unknowns": K.shape[0],
                "ratio": seconds["amg"] / seconds["direct"],
                "peer": "pyamg + CG to 1e-8",
                "peer seconds": seconds["amg"],
                "peer error": peer,
            }
        )
    return rows


def reuse_rows(sizes: tuple[int, ...]) -> list[Row]:
    """Newton with a factor kept while it contracts, against a new factor each iteration."""
    rows = []
    for n in sizes:
        shell, c, E = _held_panel(n, 3)
        force = LinearForm(lambda v, w: -2e-5 * v[2]).assemble(shell.basis).reshape(-1, 3)
        ends, seconds = {}, {}
        for reuse in (0.0, 0.5):
            structure = ShellStructure(shell, E, reuse=reuse)
            structure.mechanism  # noqa: B018  its check is not part of the timing
            start = time.perf_counter()
            path = load_path(structure, c, partial(np.multiply, force), [0.2, 0.4, 0.6, 0.8, 1.0])
            seconds[reuse] = time.perf_counter() - start
            ends[reuse] = path
            if not path.ok:
                raise ArithmeticError(path.failure)
        moved = np.abs(ends[0.0].state.coefficients - c).max()
        off = np.abs(ends[0.5].state.coefficients - ends[0.0].state.coefficients).max()
        counts = [sum(step.factorizations for step in path.steps) for path in ends.values()]
        rows.append(
            {
                "case": f"path of {n}^2 elements, p=3, factor kept",
                "seconds": seconds[0.5],
                "error": float(off / moved),
                "reference": "Newton",
                "factors": f"{counts[1]} against {counts[0]}",
                "ratio": seconds[0.0] / seconds[0.5],
                "peer": "Newton, new factors",
            }
        )
    return rows
