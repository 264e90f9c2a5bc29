"""Sums over the functions of elements: jets of a configuration, forces and tangents from points.

Each point has r scalar jets of the functions, linear in the coefficients; energies are functions
of the jets (r, 3) of the configuration. First derivatives S (r, 3) and second ones H (r, 6, r) of
all points of an element become its force and tangent by dense products.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

BLOCK = 24  # elements at a time: what their points pass on stays in the cache


def blocks(n: int, size: int = BLOCK) -> Iterator[slice]:
    """Slices of n elements."""
    return (slice(start, min(start + size, n)) for start in range(0, n, size))


@dataclass(frozen=True)
class JetSums:
    """Functions at the points of elements.

    Attributes
    ----------
    tables : (n_elements, n_points, r, n_functions) array
        Their jets, contiguous.
    dofs : (n_elements, n_functions) int array
        Coefficients of the functions.
    """

    tables: np.ndarray
    dofs: np.ndarray

    def _rows(self, part: slice) -> np.ndarray:
        table = self.tables[part]
        return table.reshape(table.shape[0], -1, table.shape[-1])

    def jets(self, x: np.ndarray, part: slice) -> np.ndarray:
        """Jets of coefficients ``x (n, 3)``: (points of the elements, r, 3)."""
        return (self._rows(part) @ x[self.dofs[part]]).reshape(-1, self.tables.shape[2], 3)

    def zeros(self, part: slice, tangent: bool) -> tuple[np.ndarray, np.ndarray]:
        """S (points, r, 3) and H (points, r, 6, r) to add to; without tangent H of no points."""
        m, r = len(self.tables[part]) * self.tables.shape[1], self.tables.shape[2]
        return np.zeros((m, r, 3)), np.zeros((m if tangent else 0, r, 6, r))

    def force(self, S: np.ndarray, part: slice) -> np.ndarray:
        """First derivatives by the coefficients, (elements, n_functions, 3)."""
        rows = self._rows(part)
        return rows.swapaxes(1, 2) @ S.reshape(*rows.shape[:2], 3)

    def tangent(self, H: np.ndarray, part: slice) -> np.ndarray:
        """Second derivatives, (elements, n_functions, 6, n_functions), components in pairs."""
        table, rows = self.tables[part], self._rows(part)
        if not H.size:
            return np.empty((0, *table.shape[3:], 6, *table.shape[3:]))
        r, m = table.shape[2:]
        half = H.reshape(*table.shape[:2], 6 * r, r) @ table
        found = rows.swapaxes(1, 2) @ half.reshape(*rows.shape[:2], 6 * m)
        return found.reshape(-1, m, 6, m)
