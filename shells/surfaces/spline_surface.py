"""Tensor-product spline surfaces: poles, restrictions, rings and edges.

Coefficient ``i * n_t + j`` belongs to ``N_i(s) N_j(t)``. Where an edge ``s = const`` collapses to
a pole, the two rings of coefficients next to it follow three free points (a tangent plane), which
makes the surface and every field on it C1 there. The density basis of a surface is its
pole-reduced scalar basis.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from .splines import SplineSpace
from .tensor_surface import TensorSurface


def pole_rings(t: SplineSpace) -> np.ndarray:
    """Rows 0 and 1 of a pole from three points: ``(2 n_t, 3)`` barycentric coordinates.

    Ring 0 is the centroid, ring 1 the circle of unit radius in the triangle of radius 2 about
    it, so both rings lie in one plane whatever the three points are.
    """
    period = t.breaks[-1] - t.breaks[0]
    angle = 2.0 * np.pi * (t.greville - t.breaks[0]) / period
    corners = 2.0 * np.pi * np.arange(3) / 3.0
    ring = (1.0 + np.cos(angle[:, None] - corners)) / 3.0
    return np.concatenate([np.full((t.n, 3), 1.0 / 3.0), ring])


@dataclass(frozen=True)
class SplineSurface(TensorSurface):
    """A tensor-product spline surface, or some of its elements.

    Parameters
    ----------
    s, t : SplineSpace
        Spaces of both directions, of one degree; outward normal is ``d_s x d_t``.
    pole_start, pole_end : bool
        The edge at the start (end) of ``s`` collapses to a pole; ``t`` must be periodic.
    elements : (n,) int array, optional
        Restriction to these elements (``e_s * t.n_elements + e_t``). Functions are then cut:
        coefficients of two restrictions of one surface are independent along their common rim,
        and so are both sides of a cut or a slit in one restriction.

    Raises
    ------
    ValueError
        Spaces of different degree; a pole without a periodic second direction; two poles with
        fewer than four rings of coefficients between them.
    """

    s: SplineSpace
    t: SplineSpace
    pole_start: bool = False
    pole_end: bool = False
    elements: np.ndarray | None = None

    def __post_init__(self) -> None:
        if self.s.degree != self.t.degree:
            raise ValueError("both directions of a surface must have one degree")
        if (self.pole_start or self.pole_end) and not self.t.periodic:
            raise ValueError("a pole needs a periodic second direction")
        if self.pole_start and self.pole_end and self.s.n < 4:
            raise ValueError("two poles need at least four rings of coefficients")

    @cached_property
    def _grid_dofs(self) -> np.ndarray:
        es, et = np.divmod(self.selected, self.t.n_elements)
        pairs = self.s.element_dofs[es][:, :, None] * self.t.n
        return (pairs + self.t.element_dofs[et][:, None, :]).reshape(self.n_elements, -1)

    @cached_property
    def reduction(self) -> csr_matrix:
        """Scalar extraction ``(n_coefficients, n_dofs)``: pole rings from three dofs each."""
        nt, n = self.t.n, self.s.n * self.t.n
        blocks, ringed = [], np.zeros(n, dtype=bool)
        for present, rings in (
            (self.pole_start, (0, 1)),
            (self.pole_end, (self.s.n - 1, self.s.n - 2)),
        ):
            if not present:
                continue
            ring_rows = np.concatenate([r * nt + np.arange(nt) for r in rings])
            ringed[ring_rows] = True
            blocks.append((ring_rows, pole_rings(self.t)))
        free = np.flatnonzero(~ringed)
        rows = [free, *(np.repeat(r, 3) for r, _ in blocks)]
        cols = [np.arange(free.size)]
        cols += [
            np.tile(free.size + 3 * b + np.arange(3), blocks[b][0].size) for b in range(len(blocks))
        ]
        data = [np.ones(free.size), *(values.ravel() for _, values in blocks)]
        entries = (np.concatenate(data), (np.concatenate(rows), np.concatenate(cols)))
        full = coo_matrix(entries, (n, free.size + 3 * len(blocks))).tocsr()
        return self._own_reduction(full)

    def restrict(self, elements: np.ndarray) -> SplineSurface:
        """This surface on some of its elements.

        Parameters
        ----------
        elements : (n,) int array
            Numbers ``e_s * t.n_elements + e_t`` within the grid.

        Returns
        -------
        SplineSurface
        """
        return SplineSurface(self.s, self.t, self.pole_start, self.pole_end, np.asarray(elements))

    def ring(self, i: int) -> np.ndarray:
        """Coefficients of one ring, along which ``s`` is constant.

        Parameters
        ----------
        i : int
            Negative numbers count from the end.

        Returns
        -------
        (n,) int array
        """
        return np.flatnonzero(self.kept // self.t.n == i % self.s.n)

    def column(self, j: int) -> np.ndarray:
        """Coefficients of one column, along which ``t`` is constant.

        Parameters
        ----------
        j : int
            Negative numbers count from the end.

        Returns
        -------
        (n,) int array
        """
        return np.flatnonzero(self.kept % self.t.n == j % self.t.n)

    def beside(self, direction: str, step: int) -> np.ndarray:
        """As for any grid; a pole closes the edge at its end."""
        neighbours = super().beside(direction, step)
        if direction == "s" and (self.pole_end if step > 0 else self.pole_start):
            own = np.arange(neighbours.size)
            return np.where(neighbours < 0, own, neighbours)
        return neighbours


def ring_scale(t: SplineSpace) -> float:
    """Mean radius of the spline circle whose control points lie on the unit circle."""
    x = np.linspace(t.breaks[0], t.breaks[-1], 16 * t.n_elements, endpoint=False)
    period = t.breaks[-1] - t.breaks[0]
    angle = 2.0 * np.pi * (t.greville - t.breaks[0]) / period
    circle = t.evaluate(x) @ np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return float(np.hypot(*circle.T).mean())
