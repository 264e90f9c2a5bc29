"""The pillow: one biquadratic tensor surface that closes on itself like a zipped pillowcase.

s is periodic; both ends of t are zipped, ``(s, t) ~ (-s, -t)`` and ``(s, 1 + t) ~ (-s, 1 - t)``:
ghost rows of coefficients are index wraps, and the surface is C1 there without any condition.
Only the four corners ``s in {0, 1/2}, t in {0, 1}`` need one linear constraint each. No poles,
``n_s x n_t`` elements and as many coefficients; elements of one kind: one extraction table.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix, identity, lil_matrix
from scipy.sparse.csgraph import connected_components

from .splines import SplineSpace
from .tensor_surface import TensorSurface


@dataclass(frozen=True)
class Pillow(TensorSurface):
    """A closed biquadratic surface, or some of its elements.

    Coefficient ``i * n_t + j`` sits at the middle of element ``(i, j)``. Densities live on the
    wrapped splines themselves, continuous at the corners; smooth fields on their `reduction`.

    Parameters
    ----------
    n_s, n_t : int
        Elements around (even) and between the zipped ends.
    elements : (n,) int array, optional
        Restriction to these elements ``e_s * n_t + e_t``; functions are then cut.

    Raises
    ------
    ValueError
        An odd number around, or fewer than 6 x 3 elements.
    """

    n_s: int
    n_t: int
    elements: np.ndarray | None = None
    s: SplineSpace = field(init=False, repr=False, compare=False)
    # Bezier extraction of one uniform knot span; the wraps live in `element_dofs`
    t: SplineSpace = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if self.n_s % 2 or self.n_s < 6 or self.n_t < 3:
            raise ValueError(
                f"a pillow needs n_s even and >= 6 and n_t >= 3, got {self.n_s} x {self.n_t}"
            )
        for name, n in (("s", self.n_s), ("t", self.n_t)):
            space = SplineSpace(np.linspace(0.0, 1.0, n + 1), 2, periodic=True)
            object.__setattr__(self, name, space)

    def wrap(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Coefficient at grid position ``i, j``, ghosts ``j = -1`` and ``n_t`` included."""
        ghost = (j < 0) | (j >= self.n_t)
        i = np.where(ghost, self.n_s - 1 - i, i) % self.n_s
        j = np.where(j < 0, -1 - j, np.where(j >= self.n_t, 2 * self.n_t - 1 - j, j))
        return i * self.n_t + j

    @cached_property
    def _grid_dofs(self) -> np.ndarray:
        es, et = np.divmod(self.selected, self.n_t)
        around, across = np.meshgrid([-1, 0, 1], [-1, 0, 1], indexing="ij")
        return self.wrap(es[:, None] + around.ravel(), et[:, None] + across.ravel())

    def beside(self, direction: str, step: int) -> np.ndarray:
        """Neighbour of each grid element; the zipped ends close the grid."""
        i, j = (g.ravel() for g in np.indices((self.n_s, self.n_t)))
        return self.wrap(i + step, j) if direction == "s" else self.wrap(i, j + step)

    @cached_property
    def _corner_rows(self) -> lil_matrix:
        """Square map of grid coefficients that makes every field smooth at the corners."""
        full = lil_matrix(identity(self.n_s * self.n_t))
        for i0 in (0, self.n_s // 2):
            for j0, j1 in ((0, 1), (self.n_t - 1, self.n_t - 2)):
                at, before = self.wrap(np.array([i0, i0 - 1]), np.array([j0, j0]))
                around = self.wrap(
                    np.array([i0 + 1, i0 - 2, i0, i0 - 1]), np.array([j0, j0, j1, j1])
                )
                # dof `at` is the half difference, the column of `before` is left unused
                full[at, before] = full[before, before] = 0.0
                full[before, at] = -1.0
                full[at, around] = full[before, around] = 0.25
        return full

    def _used(self, full: lil_matrix) -> csr_matrix:
        rows = full.tocsr()
        rows.eliminate_zeros()
        return self._own_reduction(rows)

    @cached_property
    def reduction(self) -> csr_matrix:
        """Scalar extraction ``(n_coefficients, n_dofs)`` of fields that are smooth at corners.

        At a corner ``(i0, j0)`` the mean of the two coefficients next to it follows from four
        neighbours; their half difference stays free. Local coordinate ``(s + i t)^2``: C1 iff
        ``c[i0+1,j0] + c[i0-2,j0] + c[i0,j1] + c[i0-1,j1] = 2 (c[i0,j0] + c[i0-1,j0])``.
        """
        return self._used(self._corner_rows)

    @property
    def seam(self) -> np.ndarray:
        """Which elements lie along the seam of a flat pillow, ``(n_elements,)`` bool.

        Its sheets ``0 < s < 1/2`` and ``1/2 < s < 1`` meet along s = 0, s = 1/2 and both zipped
        ends.
        """
        i, j = np.divmod(self.selected, self.n_t)
        half = self.n_s // 2
        return (i % half == 0) | (i % half == half - 1) | (j == 0) | (j == self.n_t - 1)

    @cached_property
    def rim_pairs(self) -> np.ndarray:
        """Grid coefficients on either side of each element edge at the rim of a hole, ``(n, 2)``.

        On such an edge a field is the mean of both and its slope across is their difference.

        Raises
        ------
        ValueError
            A hole that reaches a zipped end.
        """
        inside = np.zeros((self.n_s, self.n_t), dtype=bool)
        inside.ravel()[self.selected] = True
        if not (inside[:, 0].all() and inside[:, -1].all()):
            raise ValueError("a hole in a pillow must not reach its zipped ends")
        along = np.array([-1, 0, 1])
        i, j = np.nonzero(inside != np.roll(inside, -1, axis=0))
        pairs = [np.stack([self.wrap(i[:, None] + d, j[:, None] + along) for d in (0, 1)], axis=-1)]
        i, j = np.nonzero(inside[:, :-1] != inside[:, 1:])
        pairs.append(
            np.stack([self.wrap(i[:, None] + along, j[:, None] + d) for d in (0, 1)], axis=-1)
        )
        return np.unique(np.concatenate([p.reshape(-1, 2) for p in pairs]), axis=0)

    def held(self, kind: str) -> csr_matrix:
        """`reduction` of fields that vanish at the rim, with their slope if it is clamped.

        Parameters
        ----------
        kind : {"hinged", "clamped"}

        Raises
        ------
        ValueError
            Another kind, or a hole too close to a corner.
        """
        if kind not in ("hinged", "clamped"):
            raise ValueError(f"a rim is 'hinged' or 'clamped', not {kind!r}")
        full, pairs = self._corner_rows.tocsr(), self.rim_pairs
        rim = np.unique(pairs)
        n = full.shape[0]
        if full[rim].nnz != rim.size or full[:, rim].nnz != rim.size:
            raise ValueError("a hole in a pillow must keep three elements away from its corners")
        full = full.tolil()
        full[rim, rim] = 0.0
        if kind == "hinged":
            # both signs of each coefficient as nodes: c_a = -c_b joins a+ to b- and a- to b+
            a, b = pairs.T
            edges = (np.ones(2 * a.size), (np.r_[a, a + n], np.r_[b + n, b]))
            _, label = connected_components(csr_matrix(edges, shape=(2 * n, 2 * n)), False)
            plus, minus = label[rim], label[rim + n]
            free = plus != minus  # else c = -c
            _, column = np.unique(np.minimum(plus, minus)[free], return_index=True)
            first = dict(zip(np.minimum(plus, minus)[free][column], rim[free][column], strict=True))
            for row, p, m in zip(rim[free], plus[free], minus[free], strict=True):
                full[row, first[min(p, m)]] = 1.0 if p < m else -1.0
        return self._used(full)

    @property
    def density_reduction(self) -> csr_matrix:
        """Densities live on the wrapped splines themselves."""
        return identity(self.n_coefficients, format="csr")

    def restrict(self, elements: np.ndarray) -> Pillow:
        """This surface on some of its elements (numbers within the grid)."""
        return Pillow(self.n_s, self.n_t, np.asarray(elements))
