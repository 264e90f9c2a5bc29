"""What a scene needs, estimated from its numbers alone: refused before anything is built."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from ..machine import memory_bytes
from ..output.forecast import GIGABYTE
from ..sections import Coupling, SceneError

NEAR_BYTES = 2000.0  # of the near field, an unknown: 1.5 to 2.0 kB measured
SHARE = 0.8  # of the machine's memory that a run may take
# Bytes of a shell's factors over unknowns and log2 of their number: measured on pillows and spheres
# of 1e4 unknowns; degree 4 by the nonzeros of its rows.
FACTORS = {2: 550.0, 3: 850.0, 4: 1300.0}
MEASURED = 10000  # elements whose geometry `airfold check` measures within seconds


@dataclass(frozen=True)
class Sizes:
    """Counts and memory of a scene.

    Attributes
    ----------
    elements, unknowns : int
        Unknowns of the largest system.
    memory : mapping of str to float
        Bytes by what takes them; only the largest entries at a time count together.
    remedy : str
        Keys to change, where it is too much.
    """

    elements: int
    unknowns: int
    memory: Mapping[str, float] = field(default_factory=dict)
    remedy: str = "coarsen the mesh"

    @property
    def total(self) -> float:
        """Bytes of everything together."""
        return sum(self.memory.values())

    @property
    def quickly_measured(self) -> bool:
        """Whether `airfold check` builds the geometry, too."""
        return self.elements <= MEASURED

    def check(self) -> None:
        """Compare with this machine.

        Raises
        ------
        SceneError
            What does not fit into its memory, with the largest part and the remedy.
        """
        there = memory_bytes()
        if not there or self.total <= SHARE * there:
            return
        largest = max(self.memory, key=lambda name: self.memory[name])
        raise SceneError(
            [
                f"{self.elements} elements and {self.unknowns} unknowns need about "
                f"{self.total / GIGABYTE:.3g} GB, most of it for the {largest}; this machine has "
                f"{there / GIGABYTE:.3g} GB, of which {SHARE:.0%} may be used: {self.remedy}"
            ]
        )


def shell_bytes(elements: int, degree: int, unknowns: int) -> float:
    """Memory of a shell: element matrices twice (values and indices), then its factors.

    Parameters
    ----------
    elements, degree : int
    unknowns : int
        Displacement components.
    """
    local = 3 * (degree + 1) ** 2
    return 16.0 * elements * local**2 + FACTORS[degree] * unknowns * math.log2(unknowns + 2)


def response_bytes(coupling: Coupling, components: int) -> float:
    """Memory of the dense fluid response that implicit schemes use up to their limit."""
    used = coupling.scheme in ("implicit", "semi-implicit", "auto")
    return dense_bytes(components) if used and components <= coupling.dense_limit else 0.0


def dense_bytes(unknowns: int) -> float:
    """Memory of a dense matrix, its copy and its factors."""
    return 24.0 * unknowns**2
