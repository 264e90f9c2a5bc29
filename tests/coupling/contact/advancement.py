"""Oracle: how far a motion of triangles is certified, by conservative advancement.

A configuration is advanced by ``min (d - margin) / w`` over the near pairs, d their distance and w
their largest relative speed: no pair can touch meanwhile. It shares nothing with ipctk.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree

from coupling.contact.triangle_distance import triangle_distances

ADVANCES = 40
LEAST = 0.02  # a smaller advance counts as contact


@dataclass(frozen=True)
class Advancement:
    """Fractions of straight motions of triangles ``(m, 3)`` that are certainly free of contact."""

    triangles: np.ndarray
    vertices: int

    def fraction(self, start: np.ndarray, end: np.ndarray) -> float:
        """Certified fraction of the way of vertices ``(n, 3)``."""
        velocity, done = end - start, 0.0
        for _ in range(ADVANCES):
            step, blocked = self._advance(start + done * velocity, velocity, 1.0 - done)
            done += step
            if done >= 1.0 - 1e-12:
                return 1.0
            if step < LEAST * (1.0 - done) and blocked:
                break
        return min(done, 1.0 - 1e-12)

    def _advance(self, x: np.ndarray, velocity: np.ndarray, rest: float) -> tuple[float, bool]:
        """Certified fraction from ``x``, at most ``rest``, and whether a pair limits it."""
        margin = self._margins(x)
        widest = float(np.linalg.norm(velocity, axis=1).max())
        size = self._longest_edges(x)
        reach = min(2.0 * widest * rest, 4.0 * float(np.median(size))) + 2.0 * float(margin.max())
        pairs = self._candidates(x, reach, velocity, rest)
        free = rest if widest == 0.0 else min(rest, (reach - 2.0 * margin.max()) / (2.0 * widest))
        if not len(pairs):
            return free, False
        corners = x[self.triangles]
        distance = triangle_distances(corners[pairs[:, 0]], corners[pairs[:, 1]])
        moving = velocity[self.triangles]
        a, b = moving[pairs[:, 0]], moving[pairs[:, 1]]
        speed = np.linalg.norm(a[:, :, None] - b[:, None, :], axis=-1).max(axis=(1, 2))
        needed = np.where(self._related(pairs), 0.0, margin[pairs].sum(axis=1))
        allowed = np.maximum(distance - needed, 0.0) / np.maximum(speed, 1e-300)
        worst = float(allowed.min())
        return (free, False) if worst >= free else (0.9 * worst, True)

    def _candidates(
        self, x: np.ndarray, reach: float, velocity: np.ndarray, rest: float
    ) -> np.ndarray:
        """Pairs ``(k, 2)`` that bounding spheres do not clear, without those sharing a sample."""
        corners = x[self.triangles]
        centre = corners.mean(axis=1)
        radius = np.linalg.norm(corners - centre[:, None], axis=-1).max(axis=1)
        pairs = cKDTree(centre).query_pairs(reach + 2.0 * radius.max(), output_type="ndarray")
        if not len(pairs):
            return pairs
        i, j = pairs.T
        space = np.linalg.norm(centre[i] - centre[j], axis=1) - radius[i] - radius[j]
        keep = space < reach
        moving = velocity[self.triangles]
        mean = moving.mean(axis=1)
        spread = np.linalg.norm(moving - mean[:, None], axis=-1).max(axis=1)
        speed = np.linalg.norm(mean[i] - mean[j], axis=1) + spread[i] + spread[j]
        margin = self._margins(x)
        keep &= space - margin[i] - margin[j] <= speed * rest
        pairs = pairs[keep]
        normal = self._normals(x)
        alike = np.einsum("ij,ij->i", normal[pairs[:, 0]], normal[pairs[:, 1]]) > 0.0
        # a ring whose normals stay in one half space is a graph and cannot meet itself
        pairs = pairs[~(alike & self._related(pairs))]
        a, b = self.triangles[pairs[:, 0]], self.triangles[pairs[:, 1]]
        return pairs[~(a[:, :, None] == b[:, None, :]).any(axis=(1, 2))]

    @cached_property
    def _edges(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Edges that two triangles share: their samples (k, 2) and the two triangles."""
        t = self.triangles
        ends = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1)
        owner = np.tile(np.arange(len(t)), 3)
        order = np.lexsort(ends.T)
        ends, owner = ends[order], owner[order]
        twin = np.flatnonzero((ends[1:] == ends[:-1]).all(axis=1))
        return ends[twin], owner[twin], owner[twin + 1]

    @cached_property
    def _neighbours(self) -> np.ndarray:
        """Pairs of triangles whose rings of samples overlap, as sorted keys ``i m + j``, i < j."""
        m, n = len(self.triangles), self.vertices
        rows = np.repeat(np.arange(m), 3)
        touch = csr_matrix((np.ones(3 * m), (rows, self.triangles.ravel())), shape=(m, n))
        ring = (touch @ touch.T).tocsr()
        i, j = (ring @ ring).nonzero()
        return np.sort(i[i < j].astype(np.int64) * m + j[i < j])

    def _related(self, pairs: np.ndarray) -> np.ndarray:
        """Whether pairs lie in each other's second ring, where the sheet is a graph."""
        if not len(pairs):
            return np.zeros(0, dtype=bool)
        m = len(self.triangles)
        key = np.minimum(*pairs.T) * m + np.maximum(*pairs.T)
        place = np.searchsorted(self._neighbours, key)
        return self._neighbours[np.minimum(place, len(self._neighbours) - 1)] == key

    def _normals(self, x: np.ndarray) -> np.ndarray:
        a, b, c = np.moveaxis(x[self.triangles], 1, 0)
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        return normal / np.where(length > 0.0, length, 1.0)

    def _longest_edges(self, x: np.ndarray) -> np.ndarray:
        corners = x[self.triangles]
        return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max(axis=1)

    def _margins(self, x: np.ndarray) -> np.ndarray:
        """Largest distance of the smooth sheet from each triangle, ``h phi / 8``."""
        _, left, right = self._edges
        normal, size = self._normals(x), self._longest_edges(x)
        cosine = np.clip(np.einsum("ij,ij->i", normal[left], normal[right]), -1.0, 1.0)
        angle = np.zeros(len(self.triangles))
        np.maximum.at(angle, left, np.arccos(cosine))
        np.maximum.at(angle, right, np.arccos(cosine))
        return size * angle / 8.0
