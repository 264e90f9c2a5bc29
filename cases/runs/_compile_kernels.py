"""Kernels compiled side by side, in processes of their own, before a run needs them.

Numba compiles under one lock: threads do not help. Each process goes once through its share of
the work on a body of a few elements; what it compiled, all others load from numba's files. Where
that fails, or for kernels of rarer use, the run compiles what it needs, and tells so.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numba.core import event

from ..machine import THREADS, usable_cores
from ..sections import AnyScene

if TYPE_CHECKING:
    from rich.console import Console

    from hbem.surfaces.quadrature import QuadratureOrders
    from hbem.surfaces.surface_points import SampledSurface

NEWS = 2.0  # seconds between lines
KERNELS = 171  # that the shares compile, each process counting for itself
# shares of the kernels, and the last that each compiles
NEAR, DENSE, SHELLS = "near field", "dense layers", "shells"
LAST = {
    NEAR: ("hbem.layers._point_sum_kernels", "single_layer_block_sums"),
    DENSE: ("hbem.layers._plain_block_kernels", "add_block"),
    SHELLS: ("shells.energy._shell_kernels", "volume"),
}


@contextmanager
def kernels_ready(scene: AnyScene, console: Console) -> Iterator[None]:
    """Compile what a scene needs and no file holds, then tell of kernels that a run compiles."""
    with event.install_listener("numba:compile", _News(console)):
        if scene.kind in ("inflation", "capsule") and _has_flow(scene):
            cold = [share for share in LAST if _is_cold(*LAST[share])]
            if {NEAR, DENSE} <= set(cold) and usable_cores() > 1:
                degree = getattr(getattr(scene, "mesh", None), "degree", 2)
                _side_by_side([[s for s in cold if s != DENSE], [DENSE]], degree, console)
        yield


def _has_flow(scene: AnyScene) -> bool:
    return getattr(getattr(scene, "fluid", None), "model", "stokes") == "stokes"


def _is_cold(module: str, name: str) -> bool:
    """Whether no file holds the kernel as it is now, though one could."""
    kernel = getattr(import_module(module), name)
    folder = getattr(getattr(kernel, "stats", None), "cache_path", None)
    if folder is None or not os.access(Path(folder).parent, os.W_OK):
        return False
    source = Path(kernel.py_func.__code__.co_filename)
    version = "py{}{}".format(*sys.version_info)
    found = Path(folder).glob(f"{source.stem}.{name}-*.{version}*.nbi")
    return all(index.stat().st_mtime < source.stat().st_mtime for index in found)


def _side_by_side(parts: Sequence[Sequence[str]], degree: int, console: Console) -> None:
    """One process for each part; whatever becomes of them, the run can go on."""
    root = str(Path(__file__).parents[2])
    paths = os.pathsep.join([root, *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = os.environ | {"PYTHONPATH": paths} | dict.fromkeys(THREADS, "1")
    running: list[subprocess.Popen[bytes]] = []
    _tell(console, f"in {len(parts)} processes, once for an installation")
    with suppress(OSError), tempfile.TemporaryFile() as compiled:  # a byte for each kernel
        try:
            for part in parts:
                command = [sys.executable, "-m", __name__, str(degree), *part]
                running.append(
                    subprocess.Popen(
                        command, env=environment, stdout=compiled, stderr=subprocess.DEVNULL
                    )
                )
            begin = told = time.perf_counter()
            while any(process.poll() is None for process in running):
                time.sleep(0.05)
                now = time.perf_counter()
                if now - told >= NEWS:
                    told = now
                    count = os.fstat(compiled.fileno()).st_size
                    _tell(console, f"{count} of some {KERNELS} in {now - begin:.0f} s")
        finally:
            for process in running:
                process.kill()
                process.wait()
    if len(running) < len(parts) or any(process.returncode for process in running):
        _tell(console, "a process failed; the run compiles the rest")


def _tell(console: Console, text: str) -> None:
    console.print(f"compiling kernels: {text}", markup=False, highlight=False)


class _News(event.Listener):
    """Tells of kernels that this process compiles."""

    def __init__(self, console: Console):
        self.console, self.count, self.told = console, 0, -NEWS

    def on_start(self, event: event.Event) -> None:
        self.count += 1
        now = time.perf_counter()
        if now - self.told >= NEWS:
            self.told = now
            _tell(self.console, f"number {self.count}, {event.data['dispatcher'].__name__}")

    def on_end(self, event: event.Event) -> None:
        pass


class _Byte(event.Listener):
    """Tells the process that waits."""

    def on_start(self, event: event.Event) -> None:
        os.write(sys.stdout.fileno(), b".")

    def on_end(self, event: event.Event) -> None:
        pass


def _surface(degree: int) -> tuple[SampledSurface, QuadratureOrders]:
    from hbem.surfaces.quadrature import QuadratureOrders
    from hbem.surfaces.surface_points import sample

    from ..geometry.bodies import fitted, sphere

    body, orders = fitted(sphere(3, 4, degree=degree)), QuadratureOrders()
    x = body.coefficients
    assert x is not None  # of a body
    return sample(body, x, orders), orders


def near_field(degree: int) -> None:
    """Moments of near pairs: of a point on its element, and on the next; point sums."""
    from hbem.layers.point_sums import single_layer_sums
    from hbem.near.closest_point import ClosestPoints, NearPairs
    from hbem.near.near_rules import near_moments

    surface, orders = _surface(degree)
    x = surface.outer.offsets
    rows = np.array([[0.5, 0.5, -1.0, -1.0, 1.0], [0.5, 0.5, 0.5, 0.5, 1.0]])
    pairs = NearPairs(
        x[:1],
        np.array([0, 2]),
        np.arange(2),
        np.tile([0.0, 1.0, 0.0, 1.0], (2, 1)),
        ClosestPoints(rows),
        np.ones(2, dtype=bool),
    )
    near_moments(surface, pairs, orders, minus_plain=True)
    single_layer_sums(x, x, x)
    single_layer_sums(x, x, x[:, :, None])


def dense_layers(degree: int) -> None:
    """Near pairs, a near field without moments, the dense layer and its blocks."""
    from hbem.layers.dense_blocks import ExactBlocks
    from hbem.layers.dense_layer import StoredSingleLayer
    from hbem.near.closest_point import outer_pairs
    from hbem.near.near_field import assemble

    surface, orders = _surface(degree)
    x = surface.outer.offsets
    functions = (surface.patches.density_degree + 1) ** 2
    pairs = outer_pairs(surface, orders, slice(0, len(x)))
    near = assemble(surface, pairs, lambda part: np.zeros((part.n_pairs, functions, 6)))
    near.apply(np.zeros((surface.patches.n_dofs, 3, 1)))
    StoredSingleLayer(surface, near)
    ExactBlocks(surface, near).map_blocks([np.arange(2)], lambda k, block: block)


def shells(degree: int) -> None:
    """Energy, force and tangent of a shell of some elements, and its volume."""
    from shells.energy.kirchhoff_love import KirchhoffLove
    from shells.energy.material import Material
    from shells.energy.volume import EnclosedVolume
    from shells.surfaces.spline_surface import SplineSurface
    from shells.surfaces.splines import SplineSpace
    from shells.surfaces.surface_basis import SurfaceBasis

    space = SplineSpace(np.linspace(0.0, 1.0, 4), degree)
    surface = SplineSurface(space, space)
    s = space.greville
    x = np.stack([np.repeat(s, s.size), np.tile(s, s.size), np.zeros(s.size**2)], axis=1)
    basis = SurfaceBasis(surface, x)
    shell = KirchhoffLove(basis, Material(1e-2, poisson_ratio=0.3))
    shell.energy(x)
    shell.gradient_and_tangent(x)
    EnclosedVolume(basis).value(x)


REHEARSALS: dict[str, Callable[[int], None]] = {
    NEAR: near_field,
    DENSE: dense_layers,
    SHELLS: shells,
}

if __name__ == "__main__":
    event.register("numba:compile", _Byte())
    for share in sys.argv[2:]:
        REHEARSALS[share](int(sys.argv[1]))
