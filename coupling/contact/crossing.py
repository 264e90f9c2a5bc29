"""Whether triangles of a sampled surface cross: all there is to test where contact carries load.

Forces keep sheets apart and no step of the structure crosses on its way; so neither chords nor
gaps are asked about, as `Collision` does, and the inlet is a surface like any other.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..exchange import Result
from .sampled_mesh import SampledMesh


@dataclass(frozen=True)
class Crossing:
    """Test of configurations beside a contact that carries load.

    Parameters
    ----------
    mesh : SampledMesh
    counts : dict
        Tests and how many of them found a crossing.
    """

    mesh: SampledMesh
    counts: dict[str, int] = field(default_factory=lambda: {"tests": 0, "blocked": 0}, repr=False)

    def inspect(self, before: np.ndarray, after: np.ndarray) -> Result | None:
        """Say why a configuration cannot be reached straight from another; None if it can.

        Parameters
        ----------
        before, after : (n_full, 3) array
            Where they are the same, no way is tested.

        Returns
        -------
        Result or None
        """
        self.counts["tests"] += 1
        crossed = self.mesh.intersects(after)
        if not crossed and before is not after:
            crossed = self.mesh.free_step(before, after) < 1.0
        self.counts["blocked"] += crossed
        return Result.SELF_INTERSECTION if crossed else None
