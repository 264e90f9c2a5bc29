"""Microseconds an element of the shell's residual and tangent, as kernels and assembled.

Nothing here is used that an older tree lacks.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import cast

import numpy as np

from cases.benchmarks.meshes.shells import ball
from cases.benchmarks.shells.speed import panel
from cases.kinds.inflation.config import InflationScene
from cases.kinds.inflation.initial_bag import initial_bag
from cases.kinds.inflation.membrane import energy
from cases.loader import read
from shells.energy.kinks.triangle_shell import TriangleShell
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material

REPEATS = 7


def shells(quick: bool) -> dict[str, tuple[KirchhoffLove, np.ndarray]]:
    """Shells with a configuration near their reference, by name."""
    made = {f"panel, degree {p}": panel(16, p)[:2] for p in (2, 3)}
    for name in ("pancake", "accordion-2"):
        scene = cast(InflationScene, read(name))
        bag = initial_bag(scene)
        made[name] = energy(scene, bag), bag.coefficients[: bag.n_membrane]
    basis, c = ball(100 if quick else 200, 3)
    made["triangles, degree 3"] = TriangleShell(basis, Material(1e-4, poisson_ratio=0.3)), c
    return made


def figures(quick: bool = False) -> dict[str, dict[str, float]]:
    """CPU microseconds an element, those of one thread: kernels alone and assembled, by shell."""
    found = {}
    for name, (shell, c) in shells(quick).items():
        x = c + 1e-3 * np.random.default_rng(0).standard_normal(c.shape)
        works: dict[str, Callable] = {
            "energy": partial(shell.energy, x),
            "residual": partial(shell.elements, x, False),
            "tangent": partial(shell.elements, x, True),
            "residual, assembled": partial(shell.gradient, x),
            "tangent, assembled": partial(shell.gradient_and_tangent, x),
        }
        n = shell.basis.surface.n_elements
        found[name] = {work: 1e6 * _least(run) / n for work, run in works.items()}
    return found


def _least(run: Callable, repeats: int = REPEATS) -> float:
    """Least CPU seconds of a thread."""
    run()
    best = np.inf
    for _ in range(repeats):
        start = time.thread_time()
        run()
        best = min(best, time.thread_time() - start)
    return best
