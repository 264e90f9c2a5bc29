"""Self-intersection of a sampled surface on the straight way between two configurations.

Continuous collision detection (ipctk) follows the triangles from a free configuration to the next,
so that sheets which pass each other within the motion are seen too. A chord of length h that turns
by phi leaves its arc by h phi / 8: where facing triangles come closer than the sum of theirs, the
smooth sheets may cross already, and finer triangles decide.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from ..exchange import Result
from .sampled_mesh import SampledMesh
from .smallest_gap import facing_pairs, unit_normals
from .triangle_distance import triangle_distances

FOLDED = 0.5 * np.pi  # angle about an edge from which its triangles count as folded over


@dataclass(frozen=True)
class Collision:
    """Test of motions between two configurations.

    Parameters
    ----------
    mesh : SampledMesh
    inlet : (m,) bool array
        Triangles of the inlet, where touching is another `Result`.
    element : (m,) int array
        Element of each triangle.
    scale : float
        Expected gap of facing sheets.
    finer : callable, optional
        Makes the test on finer triangles of the same elements.
    initial : (n_full, 3) array, optional
        Configuration whose creases are seams: rims where flat sheets meet.
    counts : dict
        Tests and how many of them found a contact.
    """

    mesh: SampledMesh
    inlet: np.ndarray
    element: np.ndarray
    scale: float
    finer: Callable[[], Collision] | None = None
    initial: np.ndarray | None = None
    counts: dict[str, int] = field(default_factory=lambda: {"tests": 0, "blocked": 0}, repr=False)

    def inspect(self, before: np.ndarray, after: np.ndarray) -> Result | None:
        """Say why a configuration cannot be reached straight from one without contact.

        Parameters
        ----------
        before, after : (n_full, 3) array

        Returns
        -------
        Result or None
            None if it can be reached.
        """
        self.counts["tests"] += 1
        found = self._swept(before, after) or self._apart(after, np.unique(self.element))
        self.counts["blocked"] += found is not None
        return found

    def _swept(self, before: np.ndarray, after: np.ndarray) -> Result | None:
        """What triangles meet on the way."""
        if self.mesh.reaches(before, after):
            return None
        alone = self._membrane.reaches(before, after)
        return Result.INLET_CONTACT if alone else Result.SELF_INTERSECTION

    def _apart(self, coefficients: np.ndarray, elements: np.ndarray) -> Result | None:
        """What keeps the smooth sheets of some elements from being certainly apart."""
        points = self.mesh.sample @ coefficients
        chosen = np.isin(self.element, elements)
        corners = points[self.mesh.triangles]
        turn = self._turns(corners)
        folded = np.stack(self._edges, axis=1)[(turn >= FOLDED) & ~self._seams]
        folded = folded[chosen[folded].any(axis=1)]
        close = self._closer_than_chords(points, corners, turn, np.flatnonzero(chosen))
        doubtful = np.concatenate([folded, close])
        if not len(doubtful):
            return None
        if self.finer is not None:
            return self._finer._apart(coefficients, np.unique(self.element[doubtful]))
        if len(folded):
            return Result.GEOMETRY
        same = self.inlet[close[:, 0]] == self.inlet[close[:, 1]]
        return Result.SELF_INTERSECTION if same.any() else Result.INLET_CONTACT

    def _closer_than_chords(
        self, points: np.ndarray, corners: np.ndarray, turn: np.ndarray, chosen: np.ndarray
    ) -> np.ndarray:
        """Facing pairs ``(k, 2)`` of chosen triangles between which smooth sheets may cross."""
        size = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max(axis=1)
        left, right = self._edges
        angle = np.zeros(len(corners))
        np.maximum.at(angle, left, turn)
        np.maximum.at(angle, right, turn)
        margin = size * angle / 8.0
        pairs = chosen[facing_pairs(points, self.mesh.triangles[chosen], self.scale)]
        centre = corners.mean(axis=1)
        apart = np.linalg.norm(centre[pairs[:, 0]] - centre[pairs[:, 1]], axis=1)
        pairs = pairs[apart <= (size + margin)[pairs].sum(axis=1)]
        pairs = pairs[~self._related(pairs)]
        distance = triangle_distances(corners[pairs[:, 0]], corners[pairs[:, 1]])
        return pairs[distance <= margin[pairs].sum(axis=1)]

    @cached_property
    def _finer(self) -> Collision:
        assert self.finer is not None  # asked only where there is one
        return self.finer()

    @cached_property
    def _membrane(self) -> SampledMesh:
        """The mesh without the inlet: what is free there meets the inlet."""
        return self.mesh.part(~self.inlet)

    @cached_property
    def _edges(self) -> tuple[np.ndarray, np.ndarray]:
        """Triangles on both sides of each inner edge; the inlet's rim is a hinge, no sheet."""
        t = self.mesh.triangles
        ends = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1)
        owner = np.tile(np.arange(len(t)), 3)
        order = np.lexsort(ends.T)
        ends, owner = ends[order], owner[order]
        twin = np.flatnonzero((ends[1:] == ends[:-1]).all(axis=1))
        left, right = owner[twin], owner[twin + 1]
        sheet = self.inlet[left] == self.inlet[right]
        return left[sheet], right[sheet]

    def _turns(self, corners: np.ndarray) -> np.ndarray:
        """Angle between the normals on both sides of each inner edge."""
        left, right = self._edges
        normal = unit_normals(corners)
        cosine = np.einsum("ij,ij->i", normal[left], normal[right])
        return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))

    @cached_property
    def _seams(self) -> np.ndarray:
        """Inner edges about which the initial configuration is folded already."""
        if self.initial is None:
            return np.zeros(len(self._edges[0]), dtype=bool)
        corners = (self.mesh.sample @ self.initial)[self.mesh.triangles]
        return np.asarray(self._turns(corners) >= FOLDED)

    @cached_property
    def _neighbours(self) -> np.ndarray:
        """Pairs of triangles whose rings of samples overlap, as sorted keys ``i m + j``."""
        t = self.mesh.triangles
        m, rows = len(t), np.repeat(np.arange(len(t)), 3)
        touch = csr_matrix((np.ones(3 * m), (rows, t.ravel())))
        ring = (touch @ touch.T).tocsr()
        i, j = (ring @ ring).nonzero()
        return np.sort(i.astype(np.int64) * m + j)

    def _related(self, pairs: np.ndarray) -> np.ndarray:
        """Whether pairs lie in each other's second ring, where a seam brings sheets together."""
        key = pairs[:, 0].astype(np.int64) * len(self.mesh.triangles) + pairs[:, 1]
        place = np.searchsorted(self._neighbours, key)
        return np.asarray(self._neighbours[np.minimum(place, len(self._neighbours) - 1)] == key)
