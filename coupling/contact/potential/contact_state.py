"""Contact at one configuration: who faces whom, and the forces between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from .barrier import barrier, contact_pressure
from .barrier_blocks import pair_forces, pair_tangents
from .facing_search import Facing
from .obstacle_forces import ObstacleForces


@dataclass(frozen=True)
class ContactState:
    """What acts at one configuration.

    Parameters
    ----------
    points : (n, 3) array
        Samples.
    sample : (n, n_full) sparse matrix
        Coefficients to samples, without stored zeros.
    areas : (n,) array
    reach, stiffness : float
    facing : Facing
        Samples within reach of a facing sheet.
    obstacles : list of ObstacleForces
    """

    points: np.ndarray
    sample: csr_matrix
    areas: np.ndarray
    reach: float
    stiffness: float
    facing: Facing
    obstacles: list[ObstacleForces]

    def energy(self) -> float:
        """Potential of the contact forces."""
        sheets = float(self._scale @ barrier(self.facing.distance / self.reach)[0])
        return sheets + sum(o.energy() for o in self.obstacles)

    def gradient(self) -> np.ndarray:
        """First derivative of the energy by the coefficients ``(3 n_full,)``."""
        sheets = pair_forces(self.facing, self._slopes()[0]).reshape(-1, 3)
        forces = np.concatenate([sheets, *(o.gradients() for o in self.obstacles)])
        owner = np.concatenate([self.facing.vertices.ravel(), *(o.samples for o in self.obstacles)])
        nodes = np.stack([self._sum(owner, f) for f in forces.T], axis=1)
        return np.asarray(self.sample.T @ nodes).ravel()

    def tangent(self, projected: bool = True) -> csr_matrix:
        """Second derivative ``(3 n_full, 3 n_full)``, with all blocks positive if projected.

        Not projected, only that of facing sheets is exact, where no closest triangle switches.
        """
        blocks = pair_tangents(self.facing, self.points, *self._slopes(), projected)
        tangent = self._matrix(blocks, self.facing.vertices)
        for obstacle in self.obstacles:
            tangent = tangent + self._matrix(obstacle.tangents(), obstacle.samples[:, None])
        return tangent

    def distance(self) -> float:
        """Smallest distance, infinity beyond the reach, negative inside of an obstacle."""
        near = [self.facing.distance] + [o.distance for o in self.obstacles]
        return float(np.concatenate(near).min(initial=np.inf))

    def samples(self) -> np.ndarray:
        """Samples within reach of a sheet or an obstacle."""
        near = [self.facing.vertices[:, 0]] + [o.samples for o in self.obstacles]
        return np.unique(np.concatenate(near))

    def pressure(self) -> np.ndarray:
        """Contact pressure ``(n,)`` at the samples, on both sides of a sheet together."""
        sheets = self.stiffness * contact_pressure(self.facing.distance / self.reach)
        total = self._sum(self.facing.vertices[:, 0], sheets)
        for obstacle in self.obstacles:
            total += self._sum(obstacle.samples, obstacle.pressure())
        return total

    def reactions(self) -> np.ndarray:
        """Force on each obstacle ``(n_obstacles, 3)``."""
        return np.array([o.gradients().sum(axis=0) for o in self.obstacles]).reshape(-1, 3)

    @property
    def _scale(self) -> np.ndarray:
        """``w kappa D / 2`` of each facing sample."""
        return 0.5 * self.stiffness * self.reach * self.areas[self.facing.vertices[:, 0]]

    def _slopes(self) -> tuple[np.ndarray, np.ndarray]:
        """First and second derivatives of the energies by the distances of facing samples."""
        _, slope, bend = barrier(self.facing.distance / self.reach)
        scale = self._scale / self.reach
        return scale * slope, scale / self.reach * bend

    def _sum(self, samples: np.ndarray, values: np.ndarray) -> np.ndarray:
        return np.bincount(samples, values, minlength=len(self.points)).astype(float)

    def _matrix(self, blocks: np.ndarray, vertices: np.ndarray) -> csr_matrix:
        """Tangent of the coefficients from blocks between samples."""
        from ._contact_matrix_kernels import coefficient_matrix

        s, n = self.sample, self.sample.shape[1]
        parts = coefficient_matrix(blocks, vertices, s.indptr, s.indices, s.data, n)
        matrix = csr_matrix(parts, shape=(3 * n, 3 * n))
        matrix.sort_indices()
        return matrix
