"""Nonlinear Kirchhoff-Love shell: energy and its first and second variations.

``W(theta) = 1/2 int Xi : (eps eps + D kappa kappa) dmu`` with membrane strain
``eps = (a - A) / 2`` and bending strain ``kappa = b - B`` [T 2.17, 2.18]; a, b are the first and
second fundamental forms of theta, A, B those of the reference.

Departs from [T 2.17] in the sign of eps only (it enters squared). The parametrization-free form
is evaluated in an orthonormal tangent frame of the reference: kappa has no normal components, so
all Christoffel terms of the double Gamma-gradient cancel and A is the identity.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from .._threads_kernels import over
from ..surfaces.element_basis import ElementBasis
from ..surfaces.form import ElementForm, Scatter
from . import _shell_kernels as kernels
from .frame import fundamental_forms
from .interface import ShellEnergy
from .material import Material, check_share
from .point_tables import check_bending, point_tables, with_reduced_membrane


class KirchhoffLove(ShellEnergy):
    """The shell's energy on one basis.

    Parameters
    ----------
    basis : ElementBasis
        Vector basis (``components=3``); its reference is the unstrained configuration.
    material : Material
    exact_reference : bool
        Unknowns are displacements from the basis' exact reference; otherwise the coefficients
        are the configuration itself.
    curvature : (n_elements, n_points, 3) array, optional
        Stress-free curvature (B_00, B_11, B_01) in the reference's frame, for a folded bag cut
        from flat cloth; default that of the reference.
    formulation : {"parametrization-free", "classical"}
        [T 2.17] or [T 2.8]; the same energy.
    chart : callable, optional
        Classical formulation in other coordinates: ``chart(s, t)`` returns first and second
        derivatives of (s, t) by their own new coordinate, each ``(..., 2)`` [T tab. 6.1].
    membrane : {"gauss", "reduced"}
        Points of the membrane energy: those of the basis, or the fewer ones of
        `shells.surfaces.membrane_rule`, with which thin shells do not lock.
    seams : bool
        C0 knot lines are meant: sewn seams, about which the shell turns freely.
    compression_share : float
        k of a tension field, the share of its stiffness that the membrane keeps against
        compression: ``(1 - k) W_r + k W`` with the relaxed energy W_r of `_membrane_kernels`; usual
        are 1e-4 to 1e-3. 1 is St. Venant-Kirchhoff.
    hinges : (n_elements,) bool array, optional
        Elements without bending energy: those along a sewn seam of a smooth surface
        (`Pillow.seam`), which then turns freely within them.

    Raises
    ------
    ValueError
        A scalar basis, an unknown formulation or rule, a rule the surface does not allow, a share
        outside [0, 1], a tension field in the classical formulation; with flexural rigidity,
        degree 1 or (unless seams are meant) a C0 knot line.
    """

    basis: ElementBasis

    def __init__(
        self,
        basis: ElementBasis,
        material: Material,
        *,
        exact_reference: bool = False,
        curvature: np.ndarray | None = None,
        formulation: str = "parametrization-free",
        chart: Callable | None = None,
        membrane: str = "gauss",
        seams: bool = False,
        compression_share: float = 1.0,
        hinges: np.ndarray | None = None,
    ):
        if basis.components != 3:
            raise ValueError("the shell needs a vector basis: components=3")
        if formulation not in ("parametrization-free", "classical"):
            raise ValueError(f"unknown formulation {formulation!r}")
        if membrane not in ("gauss", "reduced"):
            raise ValueError(f"unknown membrane rule {membrane!r}: 'gauss' or 'reduced'")
        if membrane == "reduced" and formulation == "classical":
            raise ValueError("membrane='reduced' needs the parametrization-free formulation")
        check_bending(basis.surface, material, seams)
        check_share(compression_share)
        if compression_share < 1.0 and formulation == "classical":
            raise ValueError("a tension field needs the parametrization-free formulation")
        self.basis, self.material, self.exact_reference = basis, material, exact_reference
        self.formulation, self.compression_share = formulation, compression_share
        self._tables = point_tables(
            basis,
            material,
            exact_reference=exact_reference,
            curvature=curvature,
            formulation=formulation,
            chart=chart,
        )
        if hinges is not None:
            self._tables.weights[1, np.asarray(hinges, dtype=bool)] = 0.0
        self._own = slice(basis.dx.shape[1])  # reduced membrane points follow those of the basis
        if membrane == "reduced":
            self._tables = with_reduced_membrane(self._tables, basis, material, exact_reference)
        self._dofs = basis.surface.element_dofs

    @cached_property
    def _scatter(self) -> Scatter:
        return Scatter(np.ascontiguousarray(self.basis.element_dofs.T), self.basis.N)

    @cached_property
    def force(self) -> ElementForm:
        """W' as a linear form."""
        return ElementForm(lambda x: self.elements(x, False)[0], self.basis, 1, self._scatter)

    @cached_property
    def stiffness(self) -> ElementForm:
        """W'' as a bilinear form."""
        return ElementForm(lambda x: self.elements(x, True)[1], self.basis, 2, self._scatter)

    def _arguments(self, x: np.ndarray, *outputs: Any) -> tuple[Any, ...]:
        t = self._tables
        rigidity = self.material.flexural_rigidity
        coefficients = np.ascontiguousarray(np.asarray(x, dtype=float).reshape(-1, 3))
        shape = (t.jets, t.base, t.weights, t.metric, t.curvature, t.elasticity)
        return (*shape, rigidity, self.compression_share, self._dofs, coefficients, *outputs)

    def elements(self, x: np.ndarray, tangent: bool) -> tuple[np.ndarray, np.ndarray]:
        """Element arrays of W' and, if asked for, W''.

        Parameters
        ----------
        x : (n_coefficients, 3) array
        tangent : bool

        Returns
        -------
        (n_elements, m) array and (n_elements, m, m) array
            The second without meaning where no tangent is asked for.
        """
        ne, nd = self._dofs.shape[0], 3 * self._dofs.shape[1]
        R = np.empty((ne, nd))
        K = np.empty((ne, nd, nd) if tangent else (1, 1, 1))
        over(ne, kernels.force_and_tangent, *self._arguments(x, tangent, R, K))
        return R, K

    @property
    def elasticity(self) -> np.ndarray:
        """Elasticity in Voigt order at the basis' points, ``(n_elements, n_points, 3, 3)``."""
        return self._tables.elasticity[:, self._own]

    def forms(self, x: np.ndarray) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray, np.ndarray]:
        """Fundamental forms (00, 11, 01) in the shell's frame.

        Parameters
        ----------
        x : (n_coefficients, 3) array

        Returns
        -------
        tuple
            ``(A, B), a, b`` of the reference and of the configuration with coefficients ``x``,
            each ``(n_elements, n_points, 3)``.
        """
        t, own = self._tables, self._own
        local = np.asarray(x, dtype=float).reshape(-1, 3)[self._dofs]
        spline = np.einsum("eqad,eac->eqdc", t.jets[:, own], local, optimize=True)
        first, second = fundamental_forms(np.moveaxis(t.base[:, own] + spline, 2, 0))
        return (t.metric[:, own], t.curvature[:, own]), first, second

    def energy(self, x: np.ndarray) -> tuple[float, float]:
        out = np.empty((self._dofs.shape[0], 2))
        over(out.shape[0], kernels.energy, *self._arguments(x, out))
        membrane, bending = out.sum(axis=0)
        return float(membrane), float(bending)

    def gradient(self, x: np.ndarray) -> np.ndarray:
        # [T 2.18a]
        return self._scatter.vector(self.elements(x, False)[0])

    def gradient_and_tangent(self, x: np.ndarray) -> tuple[np.ndarray, csr_matrix]:
        # [T 2.18]
        R, K = self.elements(x, True)
        return self._scatter.vector(R), self._scatter.matrix(K)
