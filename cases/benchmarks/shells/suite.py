"""Shells against published and exact figures, and their speed.

Roof in three formulations [T tab. 6.1], locking, H2 rates (`shell_roof`); large rotations
(`shell_rotations`); inflated spheres here; cloth that wrinkles (`cloth`); kernels and solvers
(`shell_speed`).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from shells.conditions.supports import extraction
from shells.energy.densities import NeoHookean
from shells.energy.hyperelastic import HyperelasticShell
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material
from shells.energy.volume import EnclosedVolume
from shells.equilibrium.minimise import minimise
from shells.equilibrium.structure import ShellStructure
from shells.surfaces.surface_basis import SurfaceBasis

from ...geometry.revolution import sphere
from ..report import Row
from .cloth import cloth_rows
from .roof import formulation_rows, locking_rows, rate_rows, roof
from .rotations import rotation_rows
from .speed import kernel_rows, reuse_rows, solver_rows


def sphere_rows() -> list[Row]:
    """Inflated spheres against closed forms."""
    rows = []
    for count in (6, 12):
        surface, c = sphere(3, count, 2 * count)
        basis = SurfaceBasis(surface, c)
        hooke = KirchhoffLove(basis, Material(1e-8, poisson_ratio=0.3))
        rubber = HyperelasticShell(basis, NeoHookean(Material(1e-8, poisson_ratio=0.5)))
        for name, shell, stretch, pressure in (
            ("St. Venant-Kirchhoff", hooke, 1.2, (1.2 - 1.0 / 1.2) * 1.3),
            ("neo-Hookean", rubber, 1.15, 0.5 * (1.0 / 1.15 - 1.0 / 1.15**7)),
        ):
            start = time.perf_counter()
            structure = ShellStructure(shell, extraction(surface.reduction), EnclosedVolume(basis))
            end = minimise(structure, c, pressure)
            ratio = structure.volume(end.state.coefficients) / structure.volume(c)
            rows.append(
                {
                    "case": f"inflated sphere, {name}, {count} rows",
                    "seconds": time.perf_counter() - start,
                    "error": abs(ratio ** (1.0 / 3.0) / stretch - 1.0),
                    "reference": "closed form",
                    "stretch": stretch,
                    "pressure": pressure,
                    "iterations": end.iterations,
                }
            )
    return rows


def run(quick: bool) -> Iterator[Row]:
    """Rows of the benchmark, as they come; ``quick`` takes coarse meshes."""
    parts: list[Callable[[], list[Row]]] = [
        lambda: formulation_rows(32 if quick else 64),
        lambda: locking_rows((16,) if quick else (16, 32), 24 if quick else 48),
        lambda: rate_rows((12, 24) if quick else (12, 24, 48), 32 if quick else 64),
        lambda: rotation_rows(quick),
        sphere_rows,
        lambda: cloth_rows(quick),
        lambda: kernel_rows(16 if quick else 32),
        lambda: solver_rows((32,) if quick else (32, 64, 128, 256)),
        lambda: reuse_rows((16,) if quick else (16, 32, 64)),
    ]
    roof(8, 2)  # compiles the kernels
    return (row for part in parts for row in part())
