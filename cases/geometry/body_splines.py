"""B-spline densities of exact bodies: periodic around, closed at both poles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_matrix

from hbem.surfaces.bernstein import bernstein


@dataclass(frozen=True)
class LineSplines:
    """Uniform B-splines on [0, 1]: open, or periodic."""

    n_elements: int
    degree: int
    periodic: bool

    @property
    def n(self) -> int:
        return self.n_elements + (0 if self.periodic else self.degree)

    @cached_property
    def knots(self) -> np.ndarray:
        n, p = self.n_elements, self.degree
        if self.periodic:
            return np.arange(-p, n + p + 1) / n
        return np.concatenate([np.zeros(p), np.arange(n + 1) / n, np.ones(p)])

    @cached_property
    def dofs(self) -> np.ndarray:
        """Functions of each element, ``(n_elements, degree + 1)``."""
        raw = np.arange(self.n_elements)[:, None] + np.arange(self.degree + 1)
        return raw % self.n

    @cached_property
    def extraction(self) -> np.ndarray:
        """Functions in Bernstein form, ``(n_elements, degree + 1, degree + 1)``."""
        p = self.degree
        x = chebyshev(p)
        points = (np.arange(self.n_elements)[:, None] + x) / self.n_elements
        raw = BSpline(self.knots, np.eye(self.knots.size - p - 1), p)(points)
        local = np.arange(self.n_elements)[:, None] + np.arange(p + 1)
        values = np.take_along_axis(raw, local[:, None, :], axis=2)
        tables = np.swapaxes(np.linalg.solve(bernstein(p, x), values), 1, 2)
        return np.where(np.abs(tables) < 1e-14, 0.0, tables)

    def greville_angle(self) -> np.ndarray:
        """Angles of the control points of a periodic circle."""
        return 2.0 * np.pi * (np.arange(self.n) - 0.5 * (self.degree - 1)) / self.n


def chebyshev(degree: int) -> np.ndarray:
    """Chebyshev points of the first kind on [0, 1], ``(degree + 1,)``."""
    return 0.5 - 0.5 * np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))


def pole_reduction(s: LineSplines, t: LineSplines, pole: str) -> csr_matrix:
    """Tensor functions from dofs with both ends of s collapsed, ``(n_s n_t, n_dofs)``.

    Raises
    ------
    ValueError
        An unknown kind of pole.
    """
    if pole == "merged":
        end, rings = np.ones((t.n, 1)), 1
    elif pole == "c1":
        corners = 2.0 * np.pi * np.arange(3) / 3.0
        ring = (1.0 + np.cos(t.greville_angle()[:, None] - corners)) / 3.0
        end, rings = np.concatenate([np.full((t.n, 3), 1.0 / 3.0), ring]), 2
    else:
        raise ValueError(f"pole must be 'merged' or 'c1', got {pole!r}")
    k = end.shape[1]
    inner = (s.n - 2 * rings) * t.n
    full = np.zeros((s.n * t.n, inner + 2 * k))
    full[rings * t.n : rings * t.n + inner, k : k + inner] = np.eye(inner)
    for r in range(rings):
        block = end[r * t.n : (r + 1) * t.n]
        full[r * t.n : (r + 1) * t.n, :k] = block
        full[(s.n - 1 - r) * t.n : (s.n - r) * t.n, k + inner :] = block
    return csr_matrix(full)


def density(
    s: LineSplines, t: LineSplines, reduction: csr_matrix
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Density tables ``indptr, dofs, extraction`` of the reduced tensor functions."""
    indptr, dofs, rows = [0], [], []
    nb = (s.degree + 1) ** 2
    for i in range(s.n_elements):
        for j in range(t.n_elements):
            tensor = np.einsum("ak,bl->abkl", s.extraction[i], t.extraction[j]).reshape(nb, nb)
            local = reduction[(s.dofs[i][:, None] * t.n + t.dofs[j]).ravel()]
            used = np.unique(local.indices)
            dofs.append(used)
            rows.append(local[:, used].T @ tensor)
            indptr.append(indptr[-1] + used.size)
    return np.array(indptr), np.concatenate(dofs), np.concatenate(rows)
