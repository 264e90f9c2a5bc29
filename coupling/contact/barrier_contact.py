"""Contact of smooth sheets that carries load: a potential of the distances of facing sheets.

Sheets touch where their outward normals oppose each other, which tells contact from neighbourhood
without lists of neighbours or rest distances. Each sample ``i`` of area ``w_i`` looks for the
closest point of such triangles outside and inside of its sheet, at distances ``d_i``:

    ``B = 1/2 kappa D sum_i w_i beta(d_i / D)``, ``beta(s) = -(1 - s)^2 ln s``,

with the reach ``D`` and the stiffness ``kappa``; 1/2 because both sheets are sampled. Forces are
equal and opposite, along the shortest line: contact adds neither momentum nor spin.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from .barrier import barrier, contact_pressure
from .barrier_blocks import pair_forces, pair_tangents
from .facing_search import Facing, FacingSearch
from .sampled_mesh import SampledMesh

AHEAD = 0.9  # part of the way to a contact that a step takes


@dataclass(frozen=True)
class BarrierContact:
    """Frictionless contact of a sampled surface with itself.

    Parameters
    ----------
    mesh : SampledMesh
        With triangles turning the same way round the outward normal.
    areas : (n,) array
        Of each sample (`SampledMesh.areas`), in the configuration that pressures refer to.
    reach : float
        Distance at which forces begin.
    stiffness : float
        Pressure scale: contact carries it at 0.54 of the reach, 12 times as much at a tenth.
    """

    mesh: SampledMesh
    areas: np.ndarray
    reach: float
    stiffness: float
    _search: FacingSearch = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not (self.reach > 0.0 and self.stiffness > 0.0):
            raise ValueError(
                f"contact needs a positive reach and stiffness, got {self.reach:g} and "
                f"{self.stiffness:g}"
            )
        object.__setattr__(self, "_search", FacingSearch(self.mesh.triangles, self.reach))

    def at(self, t: float) -> BarrierContact:
        """Itself: nothing moves by prescription.

        Parameters
        ----------
        t : float
        """
        return self

    def facing(self, coefficients: np.ndarray) -> Facing:
        """Samples within reach of a facing sheet.

        Parameters
        ----------
        coefficients : (n_full, 3) array
        """
        return self._search.facing(self.mesh.sample @ coefficients)

    def energy(self, coefficients: np.ndarray) -> float:
        """Potential of the contact forces.

        Parameters
        ----------
        coefficients : (n_full, 3) array
        """
        facing = self.facing(coefficients)
        return float(self._scale(facing) @ barrier(facing.distance / self.reach)[0])

    def gradient(self, coefficients: np.ndarray) -> np.ndarray:
        """First derivative of the energy ``(3 n_full,)``; forces are its negative.

        Parameters
        ----------
        coefficients : (n_full, 3) array
        """
        facing = self.facing(coefficients)
        return self._to_coefficients(facing, self._slopes(facing)[0])

    def derivatives(
        self, coefficients: np.ndarray, projected: bool = True
    ) -> tuple[np.ndarray, csr_matrix]:
        """Gradient of the energy and a positive semi-definite tangent.

        Parameters
        ----------
        coefficients : (n_full, 3) array
        projected : bool
            False leaves the second derivative as it is, where no closest triangle switches.

        Returns
        -------
        (3 n_full,) array and (3 n_full, 3 n_full) sparse matrix
        """
        from ._contact_matrix_kernels import coefficient_matrix

        points = self.mesh.sample @ coefficients
        facing = self._search.facing(points)
        slope, bend = self._slopes(facing)
        blocks = pair_tangents(facing, points, slope, bend, projected)
        sample = self._sample
        n = sample.shape[1]
        matrix = coefficient_matrix(
            blocks, facing.vertices, sample.indptr, sample.indices, sample.data, n
        )
        gradient = self._to_coefficients(facing, slope)
        return gradient, csr_matrix(matrix, shape=(3 * n, 3 * n))

    def free_step(self, start: np.ndarray, end: np.ndarray) -> float:
        """Fraction of the straight way between two configurations on which nothing crosses.

        Parameters
        ----------
        start, end : (n_full, 3) array
            Nothing crosses at the start.

        Returns
        -------
        float
            1 where the whole way is free, else 0.9 of the way to the contact; 0 where triangles
            touch at the start.
        """
        free = self.mesh.free_step(start, end)
        return 1.0 if free >= 1.0 else AHEAD * free

    def distance(self, coefficients: np.ndarray) -> float:
        """Smallest distance of facing sheets; infinity beyond the reach.

        Parameters
        ----------
        coefficients : (n_full, 3) array
        """
        return float(self.facing(coefficients).distance.min(initial=np.inf))

    def within_reach(self, coefficients: np.ndarray) -> int:
        """Number of samples within reach of a facing sheet.

        Parameters
        ----------
        coefficients : (n_full, 3) array
        """
        return len(np.unique(self.facing(coefficients).vertices[:, 0]))

    def pressure(self, coefficients: np.ndarray) -> np.ndarray:
        """Contact pressure at the vertices of the mesh, both sides of a sheet together.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        (n,) array
            Force over area in the reference configuration, 0 beyond the reach.
        """
        facing = self.facing(coefficients)
        pressure = self.stiffness * contact_pressure(facing.distance / self.reach)
        return np.bincount(facing.vertices[:, 0], pressure, minlength=len(self.areas))

    def force(self, coefficients: np.ndarray) -> np.ndarray:
        """Sum of all contact forces ``(3,)`` on the surface.

        Parameters
        ----------
        coefficients : (n_full, 3) array
        """
        return -self.gradient(coefficients).reshape(-1, 3).sum(axis=0)

    @cached_property
    def _sample(self) -> csr_matrix:
        sample = self.mesh.sample.tocsr(copy=True)
        sample.eliminate_zeros()
        return sample

    def _scale(self, facing: Facing) -> np.ndarray:
        return 0.5 * self.stiffness * self.reach * self.areas[facing.vertices[:, 0]]

    def _slopes(self, facing: Facing) -> tuple[np.ndarray, np.ndarray]:
        """First and second derivatives of the energies by the distances."""
        _, slope, bend = barrier(facing.distance / self.reach)
        scale = self._scale(facing) / self.reach
        return scale * slope, scale / self.reach * bend

    def _to_coefficients(self, facing: Facing, slope: np.ndarray) -> np.ndarray:
        forces = pair_forces(facing, slope).reshape(-1, 3)
        owner, n = facing.vertices.ravel(), len(self.areas)
        nodes = np.stack([np.bincount(owner, f, minlength=n) for f in forces.T], axis=1)
        return np.asarray(self._sample.T @ nodes).ravel()
