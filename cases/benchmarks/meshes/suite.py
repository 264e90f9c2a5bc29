"""Raw meshes: bending rates, roof, large rotations, inflation, zero modes and speed of the shell.

Plates here in `plates`, other shells in `shells`, the fluid on triangles in `flow`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from ..report import Row
from . import flow
from .bags import bag_rows
from .plates import plate, plate_rows
from .shells import locking_rows, mode_rows, roof_rows, shear_rows, speed_rows, sphere_rows

SHELLS: tuple[Callable[[bool], list[Row]], ...] = (
    plate_rows,
    roof_rows,
    locking_rows,
    shear_rows,
    sphere_rows,
    mode_rows,
    speed_rows,
)
PARTS: tuple[Callable[[bool], Iterable[Row]], ...] = (*SHELLS, bag_rows, flow.rows)


def run(quick: bool) -> Iterator[Row]:
    """Rows of the benchmark, as they come; ``quick`` takes coarse meshes."""
    plate(5, 3)  # compiles the kernels
    return (row for part in PARTS for row in part(quick))
