"""Wrinkled and slack zones of a bag's configurations as cell data, for files and pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .bag_sampler import BagSampler
from .inspection import metric, principal_strains, zones


@dataclass(frozen=True)
class ClothSampler(BagSampler):
    """Grids that also say where cloth is taut, wrinkled or slack.

    Attributes
    ----------
    natural : (n_membrane, 3) array
        Unstrained membrane.
    poisson_ratio : float
    """

    natural: np.ndarray
    poisson_ratio: float

    def surface_grid(
        self,
        coefficients: np.ndarray,
        traction: np.ndarray | None = None,
        velocity: np.ndarray | None = None,
        tessellate: int = 3,
    ) -> dict[str, object]:
        """Adds cell data of the base class' grid.

        ``wrinkling`` is 0 taut, 1 wrinkled, 2 slack; ``strain_1 >= strain_2`` are principal Green
        strains, all at the middle of each cell and zero on the inlet.
        """
        grid = super().surface_grid(coefficients, traction, velocity, tessellate)
        middle = (np.arange(tessellate) + 0.5) / tessellate
        xi, eta = (g.ravel() for g in np.meshgrid(middle, middle, indexing="ij"))
        membrane = self.body.membrane
        along = [membrane.sample(xi, eta, k) for k in (0, 1)]
        shapes = (self.natural, coefficients[: self.body.n_membrane])
        e1, e2 = principal_strains(*(metric(*(a @ c for a in along)) for c in shapes))
        part = np.asarray(grid["cell_data"]["part"])  # type: ignore[index]
        for name, values in (
            ("wrinkling", zones(e1, e2, self.poisson_ratio)),
            ("strain_1", e1),
            ("strain_2", e2),
        ):
            whole = np.zeros(part.size, dtype=values.dtype)
            whole[part == 0] = values
            grid["cell_data"][name] = whole  # type: ignore[index]
        return grid
