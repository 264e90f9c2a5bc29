"""Contact of smooth sheets that carries load: a potential of the distances of facing sheets.

Sheets touch where their outward normals oppose each other, which tells contact from neighbourhood
without lists of neighbours or rest distances. Each sample ``i`` of area ``w_i`` looks for the
closest point of such triangles outside and inside of its sheet, at distances ``d_i``:

    ``B = 1/2 kappa D sum_i w_i beta(d_i / D)``, ``beta(s) = -(1 - s)^2 ln s``,

with the reach ``D`` and the stiffness ``kappa``; 1/2 because both sheets are sampled. Forces are
equal and opposite, along the shortest line: contact adds neither momentum nor spin. Rigid
obstacles push samples in the same way (`obstacle_forces`).

Surfaces are closed, or turn the same way as if they were: two sheets with their outward normals
the same way pass for one. There is no friction and no adhesion.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from .potential.contact_state import ContactState
from .potential.facing_search import Facing, FacingSearch
from .potential.obstacle_forces import ObstacleForces
from .potential.obstacles import Obstacle
from .sampled_mesh import SampledMesh

AHEAD = 0.9  # part of the way to a contact that a step takes
PIECE = 8.0  # of the reach: longest motion that is tested for contact in one go


@dataclass(frozen=True)
class BarrierContact:
    """Frictionless contact of sampled surfaces with themselves, each other and obstacles.

    Parameters
    ----------
    mesh : SampledMesh
        With triangles turning the same way round the outward normal.
    areas : (n,) array
        Of each sample (`SampledMesh.areas`), in the configuration that pressures refer to.
    reach : float
        Distance at which forces begin.
    stiffness : float
        Pressure scale: contact carries it at 0.53 of the reach, 12 times as much at a tenth.
    obstacles : tuple of Obstacle
    time : float
        At which the obstacles are where they are.

    Raises
    ------
    ValueError
        A reach or stiffness that is not positive; areas that are not those of the samples.
    """

    mesh: SampledMesh
    areas: np.ndarray
    reach: float
    stiffness: float
    obstacles: tuple[Obstacle, ...] = ()
    time: float = 0.0

    def __post_init__(self) -> None:
        if not (self.reach > 0.0 and self.stiffness > 0.0):
            raise ValueError(
                f"contact needs a positive reach and stiffness, got {self.reach:g} and "
                f"{self.stiffness:g}"
            )
        if len(self.areas) != self.mesh.sample.shape[0]:
            raise ValueError(
                f"contact needs an area for each of {self.mesh.sample.shape[0]} samples, got "
                f"{len(self.areas)} (SampledMesh.areas gives them)"
            )

    def at(self, t: float) -> BarrierContact:
        """Contact with the obstacles where they are at a time.

        Parameters
        ----------
        t : float
        """
        if not self.obstacles:
            return self
        moved = replace(self, time=t)
        moved.__dict__["_search"] = self._search  # sheets face each other as before
        return moved

    def state(self, coefficients: np.ndarray) -> ContactState:
        """Contact at a configuration, with all that can be asked about it.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Raises
        ------
        ValueError
            Coefficients that are not finite.
        """
        if not np.isfinite(coefficients).all():
            raise ValueError("contact was asked about a configuration that is not finite")
        points, sample, facing = self._search.at(coefficients)
        numbers = self.areas, self.reach, self.stiffness
        obstacles = [ObstacleForces.of(o, points, self.time, *numbers) for o in self.obstacles]
        return ContactState(points, sample, *numbers, facing, obstacles)

    def energy(self, coefficients: np.ndarray) -> float:
        """Potential of the contact forces.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        float
            Infinity for coefficients that are not finite, which a descent may try.
        """
        if not np.isfinite(coefficients).all():
            return float("inf")
        return self.state(coefficients).energy()

    def derivatives(
        self, coefficients: np.ndarray, projected: bool = True
    ) -> tuple[np.ndarray, csr_matrix]:
        """Gradient of the energy and a positive semi-definite tangent.

        Parameters
        ----------
        coefficients : (n_full, 3) array
        projected : bool
            False gives the exact second derivative between sheets, which may be indefinite: Newton
            then converges quadratically, where the projected one gains a factor of 0.7 at the end.

        Returns
        -------
        (3 n_full,) array and (3 n_full, 3 n_full) sparse matrix
        """
        state = self.state(coefficients)
        return state.gradient(), state.tangent(projected)

    def free_step(self, start: np.ndarray, end: np.ndarray) -> float:
        """Fraction of the straight way between two configurations on which no sheets cross.

        Obstacles do not count: they may be entered, and push out.

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
        free = self.mesh.free_step(start, end, piece=PIECE * self.reach)
        return 1.0 if free >= 1.0 else AHEAD * free

    def distance(self, coefficients: np.ndarray) -> float:
        """Smallest distance of facing sheets and to obstacles.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        float
            Infinity beyond the reach; negative where an obstacle is entered, by its depth.
        """
        return self.state(coefficients).distance()

    def pressure(self, coefficients: np.ndarray) -> np.ndarray:
        """Contact pressure at the vertices of the mesh, on both sides of a sheet together.

        Parameters
        ----------
        coefficients : (n_full, 3) array

        Returns
        -------
        (n,) array
            Force over area in the configuration of `areas`, 0 beyond the reach.
        """
        return self.state(coefficients).pressure()

    def force(self, coefficients: np.ndarray) -> np.ndarray:
        """Sum of all contact forces ``(3,)`` on the surfaces: that of the obstacles.

        Parameters
        ----------
        coefficients : (n_full, 3) array
        """
        return -self.state(coefficients).gradient().reshape(-1, 3).sum(axis=0)

    def reactions(self, coefficients: np.ndarray) -> np.ndarray:
        """Force on each obstacle ``(n_obstacles, 3)``.

        Parameters
        ----------
        coefficients : (n_full, 3) array
        """
        return self.state(coefficients).reactions()

    def within_reach(self, coefficients: np.ndarray) -> int:
        """Number of samples within reach of a facing sheet or an obstacle.

        Parameters
        ----------
        coefficients : (n_full, 3) array
        """
        return len(self.state(coefficients).samples())

    @cached_property
    def _search(self) -> _LastSearch:
        return _LastSearch(self.mesh, self.reach)


class _LastSearch:
    """Samples of the last configuration and what they face: energy and forces ask in turn."""

    def __init__(self, mesh: SampledMesh, reach: float) -> None:
        self.sample = mesh.sample.tocsr(copy=True)
        self.sample.eliminate_zeros()
        self.sample.indices = self.sample.indices.astype(np.int32, copy=False)
        self.sample.indptr = self.sample.indptr.astype(np.int32, copy=False)
        self.search = FacingSearch(mesh.triangles, reach)
        self._last: tuple[np.ndarray, np.ndarray, Facing] | None = None

    def at(self, coefficients: np.ndarray) -> tuple[np.ndarray, csr_matrix, Facing]:
        """Samples ``(n, 3)``, the matrix that gives them, and what they face."""
        if self._last is None or not np.array_equal(self._last[0], coefficients):
            points = np.ascontiguousarray(self.sample @ coefficients)
            self._last = np.array(coefficients), points, self.search.facing(points)
        return self._last[1], self.sample, self._last[2]
