"""Any hyperelastic shell from its energy density: derivatives by point, contracted in batches.

A density is a function of the fundamental forms ``y = (a_00, a_11, a_01, b_00, b_11, b_01)`` in an
orthonormal frame of the reference. The chain rule ``psi'' = y' psi_yy y' + psi_y y''`` is written
once; a material supplies psi, psi_y and psi_yy. About half as fast as the fused kernel for p = 2
and close to it for p = 3 (`airfold bench shells`), and free of assembly code.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import csr_matrix

from ..surfaces.element_basis import ElementBasis
from ._shell_kernels import PAIRS as COMPONENTS
from .densities import Density
from .interface import ShellEnergy
from .points.block_scatter import BlockScatter
from .points.jet_sums import JetSums, blocks
from .points.point_tables import check_bending, point_tables

LEVI = np.zeros((3, 3, 3))
LEVI[0, 1, 2] = LEVI[1, 2, 0] = LEVI[2, 0, 1] = 1.0
LEVI[0, 2, 1] = LEVI[2, 1, 0] = LEVI[1, 0, 2] = -1.0
PAIRS = ((0, 0), (1, 1), (0, 1))
BLOCK = 512  # elements a batch: bounds the memory of the points' Hessians


def _normal(jets: np.ndarray) -> tuple[np.ndarray, ...]:
    """J, nu, and by both tangents: nu' ``(n, 2, 3, 3)`` (d, j, component), ``nu . z'``."""
    n = jets.shape[0]
    t0, t1 = jets[:, 0], jets[:, 1]
    z = np.cross(t0, t1)
    J = np.linalg.norm(z, axis=1)
    nu = z / J[:, None]
    dz = np.empty((n, 2, 3, 3))
    dz[:, 0] = np.cross(np.eye(3)[None], t1[:, None])
    dz[:, 1] = np.cross(t0[:, None], np.eye(3)[None])
    along = np.einsum("ndjk,nk->ndj", dz, nu)
    dnu = (dz - along[..., None] * nu[:, None, None]) / J[:, None, None, None]
    return J, nu, dnu, along


def forms_and_gradient(jets: np.ndarray, normal: tuple | None = None) -> tuple:
    """Both forms y with derivatives by the jets.

    Parameters
    ----------
    jets : (n, 5, 3) array
        Derivatives 0, 1, 00, 11, 01 of the surface at n points.

    Returns
    -------
    y : (n, 6), dy : (n, 6, 5, 3) arrays
    """
    _, nu, dnu, _ = _normal(jets) if normal is None else normal
    n, h = jets.shape[0], jets[:, 2:]
    y, dy = np.empty((n, 6)), np.zeros((n, 6, 5, 3))
    for k, (a, b) in enumerate(PAIRS):
        y[:, k] = np.einsum("nc,nc->n", jets[:, a], jets[:, b])
        dy[:, k, a] += jets[:, b]
        dy[:, k, b] += jets[:, a]
        y[:, 3 + k] = np.einsum("nc,nc->n", h[:, k], nu)
        dy[:, 3 + k, 2 + k] = nu
        dy[:, 3 + k, :2] = np.einsum("nc,ndjc->ndj", h[:, k], dnu)
    return y, dy


def forms_hessian(jets: np.ndarray, slope: np.ndarray, normal: tuple) -> np.ndarray:
    """``sum_k slope_k y_k''`` by the jets, ``(n, 5, 3, 5, 3)``, for ``slope (n, 6)``."""
    J, nu, dnu, along = normal
    n, m = jets.shape[0], slope[:, 3:]
    H = np.zeros((n, 5, 3, 5, 3))
    for k, (a, b) in enumerate(PAIRS):
        size = slope[:, k, None, None] * np.eye(3)
        H[:, a, :, b] += size
        H[:, b, :, a] += size
        turned = m[:, k, None, None, None] * dnu
        H[:, 2 + k, :, :2] = np.moveaxis(turned, 3, 1)
        H[:, :2, :, 2 + k] = turned
    # nu'' against M = sum m_k h_k: z'' is constant, the rest products of nu' and nu . z'
    M = np.einsum("nk,nkc->nc", m, jets[:, 2:])
    on_normal = np.einsum("nc,nc->n", M, nu)
    skew = np.einsum("jik,nk->nji", LEVI, (M - on_normal[:, None] * nu) / J[:, None])
    H[:, 0, :, 1] += skew
    H[:, 1, :, 0] += np.swapaxes(skew, 1, 2)
    flat = dnu.reshape(n, 6, 3)
    turn = np.einsum("nxc,nc->nx", flat, M / J[:, None])
    cross = along.reshape(n, 6, 1) * turn[:, None, :]
    rest = (
        cross
        + np.swapaxes(cross, 1, 2)
        + on_normal[:, None, None] * (flat @ np.swapaxes(flat, 1, 2))
    )
    H[:, :2, :, :2] -= rest.reshape(n, 2, 3, 2, 3)
    return H


class HyperelasticShell(ShellEnergy):
    """A shell with any `Density`; the interface of `KirchhoffLove`.

    Parameters
    ----------
    basis : ElementBasis
    density : Density
        Energy per reference area, such as `NeoHookean`.
    exact_reference, seams : bool
        As in `KirchhoffLove`.

    Raises
    ------
    ValueError
        A scalar basis; with flexural rigidity, degree 1 or (unless seams are meant) a C0 knot
        line.
    """

    basis: ElementBasis

    def __init__(
        self,
        basis: ElementBasis,
        density: Density,
        *,
        exact_reference: bool = False,
        seams: bool = False,
    ):
        if basis.components != 3:
            raise ValueError("the shell needs a vector basis: components=3")
        check_bending(basis.surface, density.material, seams)
        self.basis, self.density, self.material = basis, density, density.material
        self._tables = point_tables(basis, density.material, exact_reference=exact_reference)
        self._sums = JetSums(self._tables.jets, basis.surface.element_dofs)
        self._blocks = BlockScatter([self._sums.dofs], basis.surface.n_coefficients)
        self._reference = np.concatenate([self._tables.metric, self._tables.curvature], axis=-1)

    def _batches(self, x: np.ndarray) -> Iterator[tuple[slice, np.ndarray, np.ndarray]]:
        c = np.asarray(x, dtype=float).reshape(-1, 3)
        for part in blocks(len(self._sums.dofs), BLOCK):
            jets = self._sums.jets(c, part)
            jets += self._tables.base[part].reshape(jets.shape)
            yield part, jets, self._reference[part].reshape(-1, 6)

    def energy(self, x: np.ndarray) -> tuple[float, float]:
        # all of it counts as membrane energy
        total = 0.0
        for part, jets, reference in self._batches(x):
            psi, _, _ = self.density(forms_and_gradient(jets)[0], reference)
            total += float(psi @ self.basis.dx[part].ravel())
        return total, 0.0

    def gradient(self, x: np.ndarray) -> np.ndarray:
        return self.gradient_and_tangent(x)[0]

    def gradient_and_tangent(self, x: np.ndarray) -> tuple[np.ndarray, csr_matrix]:
        R, data = np.empty((*self._sums.dofs.shape, 3)), self._blocks.zeros()
        i, j = COMPONENTS.T
        for part, jets, reference in self._batches(x):
            normal = _normal(jets)
            y, dy = forms_and_gradient(jets, normal)
            _, slope, curve = self.density(y, reference)
            w = self.basis.dx[part].reshape(-1, 1, 1)
            R[part] = self._sums.force(np.einsum("nk,nkdi->ndi", slope, dy) * w, part)
            flat = dy.reshape(-1, 6, 15)
            second = np.swapaxes(flat, 1, 2) @ curve @ flat
            second += forms_hessian(jets, slope, normal).reshape(-1, 15, 15)
            second = (second * w).reshape(-1, 5, 3, 5, 3).transpose(0, 1, 3, 2, 4)[..., i, j]
            H = np.ascontiguousarray(second.swapaxes(2, 3))
            self._blocks.add(data, 0, self._sums.tangent(H, part), part)
        return self._blocks.vector(0, R), self._blocks.matrix(data)
