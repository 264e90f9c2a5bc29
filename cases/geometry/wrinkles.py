"""Wrinkled and slack zones of a bag's configurations as cell data, for files and pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shells.surfaces.local_elements import lattice, middle

from .bag_sampler import BagSampler, tangents
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
        membrane = self.body.membrane
        if membrane.shape == "triangle":
            points = middle(membrane.shape)[:2]
        else:
            xi, eta, cells = lattice(membrane.shape, tessellate)
            points = xi[cells].mean(axis=1), eta[cells].mean(axis=1)
        shapes = (self.natural, coefficients[: self.body.n_membrane])
        e1, e2 = principal_strains(*(metric(*tangents(membrane, c, points)) for c in shapes))
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
