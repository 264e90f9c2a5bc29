"""Enclosed volume ``Q = 1/3 int (theta - a) . (theta_s x theta_t) ds dt`` [T 2.27, 2.30].

Both variations are exact for the discrete Q whatever the quadrature. This full form closes an open
edge by the cone from it to the apex a: right where the edge does not move, or moves in a plane
through a, which then holds the cone (symmetry planes of a part of a bag). Elsewhere the gradient
contains a spurious edge load, and `OpenVolume` takes the short form
``Q'(rho) = int rho . (theta_s x theta_t)`` instead.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix, identity, kron

from ..surfaces.element_basis import ElementBasis
from ..surfaces.form import Scatter
from ..surfaces.spline_surface import SplineSurface
from ..surfaces.splines import unit_gauss
from . import _shell_kernels as kernels
from .interface import Enclosure
from .points.block_scatter import BlockScatter
from .points.jet_sums import JetSums, blocks


class EnclosedVolume(Enclosure):
    """Volume under a surface, with gradient and Hessian.

    Parameters
    ----------
    basis : ElementBasis
        Vector basis of the part of the surface that moves.
    offset : float
        Volume of the part that does not (the inlet).
    apex : (3,) array, optional
        Point in the symmetry planes in which open edges move; default the origin.
    """

    def __init__(self, basis: ElementBasis, offset: float = 0.0, apex: ArrayLike | None = None):
        self.basis, self.offset = basis, offset
        self.apex = np.zeros(3) if apex is None else np.asarray(apex, dtype=float)
        stacked = np.stack([basis.values, basis.grads[0], basis.grads[1]])
        self._sums = JetSums(
            np.ascontiguousarray(stacked.transpose(2, 3, 0, 1)), basis.surface.element_dofs
        )
        self._weights = basis.parameter_weights
        self._blocks = BlockScatter([self._sums.dofs], basis.surface.n_coefficients)

    def _sum(self, x: np.ndarray, order: int) -> tuple[float, np.ndarray, np.ndarray]:
        """Q, vector of Q' and data of Q'' as far as the order goes."""
        c = np.asarray(x, dtype=float).reshape(-1, 3) - self.apex
        sums, thirds = self._sums, self._weights / 3.0
        Q, R = np.empty(thirds.shape), np.zeros((*sums.dofs.shape, 3))
        data = self._blocks.zeros() if order > 1 else np.empty(0)
        for part in blocks(len(thirds)):
            S, H = sums.zeros(part, order > 1)
            g, weights = sums.jets(c, part), thirds[part].ravel()
            kernels.volume(g, weights, order, Q[part].ravel(), S, H, np.empty(kernels.WORK))
            if order > 0:
                R[part] = sums.force(S, part)
            if order > 1:
                self._blocks.add(data, 0, sums.tangent(H, part), part)
        return float(Q.sum()) + self.offset, self._blocks.vector(0, R), data

    def value(self, x: np.ndarray) -> float:
        return self._sum(x, 0)[0]

    def gradient(self, x: np.ndarray) -> np.ndarray:
        return self._sum(x, 1)[1]

    def derivatives(self, x: np.ndarray) -> tuple[float, np.ndarray, csr_matrix]:
        # [T 2.30]
        Q, R, data = self._sum(x, 2)
        return Q, R, self._blocks.matrix(data)

    @cached_property
    def _scatter(self) -> Scatter:
        return Scatter(np.ascontiguousarray(self.basis.element_dofs.T), self.basis.N)

    def pressure_force(self, x: np.ndarray) -> tuple[np.ndarray, csr_matrix]:
        """Force of a unit pressure, ``int rho . (theta_s x theta_t)``, and its derivative.

        It is Q' where nothing open moves; elsewhere the derivative is not symmetric.

        Parameters
        ----------
        x : (n_coefficients, 3) array

        Returns
        -------
        (3 n_coefficients,) array and (3 n_coefficients, 3 n_coefficients) sparse matrix
        """
        dofs = self._sums.dofs
        c = np.asarray(x, dtype=float).reshape(-1, 3)[dofs]
        N, N0, N1 = np.moveaxis(self._sums.tables, 2, 0)
        t0, t1 = (np.einsum("eqa,eac->eqc", n, c) for n in (N0, N1))
        w = self._weights[..., None]
        R = np.einsum("eqa,eqc->eac", N, np.cross(t0, t1) * w)
        arm = N0[..., None] * t1[:, :, None] - N1[..., None] * t0[:, :, None]
        turned = np.cross(np.eye(3), arm[..., None, :])  # z' of component j: (e, q, b, j, c)
        K = np.einsum("eqa,eqbji->eaibj", N * w, turned, optimize=True)
        ne, nd = dofs.shape[0], 3 * dofs.shape[1]
        return self._blocks.vector(0, R), self._scatter.matrix(K.reshape(ne, nd, nd))

    def check(self, extraction: csr_matrix) -> None:
        """Refuse supports that let an open boundary move out of planes through the apex.

        Parameters
        ----------
        extraction : (3 n_coefficients, n_free) sparse matrix

        Raises
        ------
        ValueError
            Naming the edge, and the apex that its planes have in common where there is one.
        """
        planes = [
            (name, levels)
            for name, trace in self.basis.surface.open_edges.items()
            if (levels := self._planes(name, trace, extraction)) is not None
        ]
        if all(any(abs(self.apex[k] - x) <= self._near for k, x in own) for _, own in planes):
            return
        right: dict[int, float] = {}
        for name, own in planes:
            axis, level = next(((k, x) for k, x in own if k in right), own[0])
            if abs(right.setdefault(axis, level) - level) > self._near:
                raise ValueError(
                    f"edge {name} moves in the plane {'xyz'[axis]} = {level:g}, another in the "
                    f"parallel one at {right[axis]:g}: no cone lies in both; fix one of "
                    "them, or close a tube by shells.OpenVolume"
                )
        apex = [right.get(k, float(self.apex[k])) for k in range(3)]
        raise ValueError(
            f"open edges move in planes that do not pass through {self.apex.tolist()}: give "
            f"EnclosedVolume(..., apex={apex})"
        )

    @property
    def _near(self) -> float:
        return 1e-9 * float(np.ptp(self.basis.reference.value.reshape(-1, 3), axis=0).max())

    def _planes(
        self, name: str, trace: csr_matrix, extraction: csr_matrix
    ) -> list[tuple[int, float]] | None:
        """Planes ``x_k = level`` that an edge stays in; None for an edge that does not move."""
        motion = abs(kron(trace, identity(3), format="csr") @ extraction).max(axis=1)
        moves = (motion.toarray().reshape(-1, 3) > 1e-12).any(axis=0)
        if not moves.any():
            return None
        own = []
        if isinstance(self.basis.source, np.ndarray):
            x = trace @ self.basis.source
            flat = ~moves & (np.ptp(x, axis=0) <= self._near)
            own = [(int(k), float(x[:, k].mean())) for k in np.flatnonzero(flat)]
        if not own:
            raise ValueError(
                f"edge {name} is open and moves: the enclosed volume in its full form would "
                "load it; fix the edge, hold it in a symmetry plane, or use shells.OpenVolume"
            )
        return own


class OpenVolume(EnclosedVolume):
    """Volume under a tube whose open ends move, closed by flat lids.

    The pressure acts on the surface only (short form); the Hessian is symmetric where the lids
    stay in their planes.

    Parameters
    ----------
    basis : ElementBasis
        Vector basis of a surface that is periodic in t and has no poles at its open ends.
    offset : float
        Volume of the part that does not move.

    Raises
    ------
    ValueError
        For a surface that is not periodic in t: no lids close it.
    """

    def __init__(self, basis: ElementBasis, offset: float = 0.0):
        super().__init__(basis, offset)
        surface = basis.surface
        if not (isinstance(surface, SplineSurface) and surface.t.periodic):
            raise ValueError("an open sheet encloses no volume: only tubes (t periodic) do")
        x, w = unit_gauss(surface.degree + 1)
        self._lids = []
        for end, present in ((0, surface.pole_start), (1, surface.pole_end)):
            if present:
                continue
            place = np.repeat(
                surface.selected // surface.t.n_elements == end * (surface.s.n_elements - 1),
                x.size,
            )
            fixed = np.full_like(x, float(end))
            point, along = (surface.sample(fixed, x, k)[place] for k in (None, 1))
            weights = np.tile(w, point.shape[0] // x.size)
            self._lids.append((-1.0 if end else 1.0, point, along, weights))

    def _lid_volume(self, c: np.ndarray) -> float:
        """Cones from each loop's centre: a third of height times flat area, about the origin."""
        total = 0.0
        for sign, point, along, w in self._lids:
            x, dx = point @ c, along @ c
            centre = np.average(x, axis=0, weights=w * np.linalg.norm(dx, axis=1))
            area = 0.5 * (w @ np.cross(x - centre, dx))
            total += sign * float(centre @ area) / 3.0
        return total

    def value(self, x: np.ndarray) -> float:
        return super().value(x) + self._lid_volume(np.asarray(x, dtype=float).reshape(-1, 3))

    def gradient(self, x: np.ndarray) -> np.ndarray:
        return self.pressure_force(x)[0]

    def derivatives(self, x: np.ndarray) -> tuple[float, np.ndarray, csr_matrix]:
        return self.value(x), *self.pressure_force(x)

    def check(self, extraction: csr_matrix) -> None:
        return  # nothing to refuse: open boundaries may move
