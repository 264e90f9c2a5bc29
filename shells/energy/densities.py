"""Energy densities of `HyperelasticShell`: functions of both fundamental forms of the surface.

``y = (a_00, a_11, a_01, b_00, b_11, b_01)`` in an orthonormal frame of the reference. A new
material is one class here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from . import _membrane_kernels as kernels
from .material import Material, check_share


class Density(Protocol):
    """Energy per reference area as a function of both fundamental forms."""

    @property
    def material(self) -> Material: ...

    def __call__(
        self, y: np.ndarray, reference: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """psi (...), psi_y (..., 6), psi_yy (..., 6, 6) at ``y`` and the reference's forms."""


def _quadratic(C: np.ndarray, strain: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    stress = strain @ C
    return 0.5 * np.einsum("...i,...i->...", stress, strain), stress


@dataclass(frozen=True)
class StVenantKirchhoff:
    """[T 2.17] as a density: the energy of `KirchhoffLove`, evaluated another way."""

    material: Material

    def __call__(
        self, y: np.ndarray, reference: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        C = self.material.elasticity()
        voigt_e, voigt_k = np.array([0.5, 0.5, 1.0]), np.array([1.0, 1.0, 2.0])
        D = self.material.flexural_rigidity * C
        membrane, n = _quadratic(C, (y - reference)[..., :3] * voigt_e)
        bending, m = _quadratic(D, (y - reference)[..., 3:] * voigt_k)
        hessian = np.zeros((*y.shape, 6))
        hessian[..., :3, :3] = C * np.outer(voigt_e, voigt_e)
        hessian[..., 3:, 3:] = D * np.outer(voigt_k, voigt_k)
        return membrane + bending, np.concatenate([n * voigt_e, m * voigt_k], axis=-1), hessian


def _bending(
    material: Material, y: np.ndarray, reference: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Quadratic energy without its membrane part, whose derivatives are to be overwritten."""
    psi, gradient, hessian = StVenantKirchhoff(material)(y, reference)
    strain = (y - reference)[..., :3] * np.array([0.5, 0.5, 1.0])
    return psi - _quadratic(material.elasticity(), strain)[0], gradient, hessian


def relaxed(
    material: Material, strain: np.ndarray, share: float
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """The tension field at points, by the formulas of `_membrane_kernels`.

    Parameters
    ----------
    material : Material
    strain : (..., 3) array
        Green strain (E_00, E_11, 2 E_01) in an orthonormal frame.
    share : float
        k of ``(1 - k) W_r + k W``.

    Returns
    -------
    state : (...) int array
        0 taut, 1 wrinkled, 2 slack.
    principal : (..., 2) array
        Principal strains, larger first.
    (psi, n, D) : tuple of (...), (..., 3) and (..., 3, 3) arrays
        Energy per reference area with its derivatives by the strain.
    """
    e = np.ascontiguousarray(strain, dtype=float).reshape(-1, 3)
    m, shape = e.shape[0], strain.shape[:-1]
    state, principal, psi = np.empty(m, dtype=np.int64), np.empty((m, 2)), np.empty(m)
    n, D = np.empty((m, 3)), np.empty((m, 3, 3))
    kernels.points(e, material.elasticity(), share, state, principal, psi, n, D)
    found = psi.reshape(shape), n.reshape(*shape, 3), D.reshape(*shape, 3, 3)
    return state.reshape(shape), principal.reshape(*shape, 2), found


@dataclass(frozen=True)
class TensionField:
    """St. Venant-Kirchhoff membrane that wrinkles, with the quadratic bending of [T 2.17].

    ``(1 - k) W_r + k W`` with the relaxed energy of `_membrane_kernels`: the energy of
    ``KirchhoffLove(compression_share=k)``, evaluated another way.

    Parameters
    ----------
    material : Material
    compression_share : float
        k, the share of its stiffness that the membrane keeps against compression.

    Raises
    ------
    ValueError
        A share outside [0, 1].
    """

    material: Material
    compression_share: float = 1e-3

    def __post_init__(self) -> None:
        check_share(self.compression_share)

    def __call__(
        self, y: np.ndarray, reference: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        bending, gradient, hessian = _bending(self.material, y, reference)
        voigt = np.array([0.5, 0.5, 1.0])
        strain = (y - reference)[..., :3] * voigt
        _, _, (psi, n, D) = relaxed(self.material, strain, self.compression_share)
        gradient[..., :3], hessian[..., :3, :3] = n * voigt, D * np.outer(voigt, voigt)
        return psi + bending, gradient, hessian


@dataclass(frozen=True)
class NeoHookean:
    """Incompressible neo-Hookean membrane with the quadratic bending of [T 2.17].

    ``psi = mu h / 2 (tr a + 1 / det a - 3)``; small strains agree with Poisson ratio 1/2, so that
    ``mu h`` is a quarter of the membrane stiffness.

    Parameters
    ----------
    material : Material
        With Poisson ratio 1/2.

    Raises
    ------
    ValueError
        If the material's Poisson ratio is not 1/2.
    """

    material: Material

    def __post_init__(self) -> None:
        if self.material.poisson_ratio != 0.5:
            raise ValueError("an incompressible material has poisson_ratio = 0.5")

    def __call__(
        self, y: np.ndarray, reference: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        psi, gradient, hessian = _bending(self.material, y, reference)
        half = self.material.stiffness / 8.0
        det = y[..., 0] * y[..., 1] - y[..., 2] ** 2
        slope = np.stack([y[..., 1], y[..., 0], -2.0 * y[..., 2]], axis=-1)
        bend = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -2.0]])
        psi = psi + half * (y[..., 0] + y[..., 1] + 1.0 / det - 3.0)
        gradient[..., :3] = half * (np.array([1.0, 1.0, 0.0]) - slope / det[..., None] ** 2)
        product = slope[..., :, None] * slope[..., None, :]
        d = det[..., None, None]
        hessian[..., :3, :3] = half * (2.0 * product / d**3 - bend / d**2)
        return psi, gradient, hessian


@dataclass(frozen=True)
class Skalak:
    """Membrane that resists dilatation of its area, with the quadratic bending of [T 2.17].

    ``psi = Gs / 4 (I1^2 + 2 I1 - 2 I2 + C I2^2)``, ``I1 = tr a - 2``, ``I2 = det a - 1`` (Skalak,
    Tozeren, Zarda, Chien 1973); small strains agree with Poisson ratio ``C / (1 + C)``, so that
    ``Gs`` is ``(1 - nu) / 2`` of the membrane stiffness.

    Parameters
    ----------
    material : Material
        Its Poisson ratio gives C.

    Raises
    ------
    ValueError
        If the material's Poisson ratio is not above -1/2 (C not above -1/3).
    """

    material: Material

    def __post_init__(self) -> None:
        if not self.material.poisson_ratio > -0.5:
            raise ValueError("Skalak's law has poisson_ratio = C / (1 + C) above -0.5")

    def __call__(
        self, y: np.ndarray, reference: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        psi, gradient, hessian = _bending(self.material, y, reference)
        nu = self.material.poisson_ratio
        quarter, C = self.material.stiffness * (1.0 - nu) / 8.0, nu / (1.0 - nu)
        I1, I2 = y[..., 0] + y[..., 1] - 2.0, y[..., 0] * y[..., 1] - y[..., 2] ** 2 - 1.0
        one = np.array([1.0, 1.0, 0.0])
        slope = np.stack([y[..., 1], y[..., 0], -2.0 * y[..., 2]], axis=-1)
        bend = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -2.0]])
        psi = psi + quarter * (I1**2 + 2.0 * I1 - 2.0 * I2 + C * I2**2)
        by_I1, by_I2 = 2.0 * I1 + 2.0, 2.0 * C * I2 - 2.0
        gradient[..., :3] = quarter * (by_I1[..., None] * one + by_I2[..., None] * slope)
        product = slope[..., :, None] * slope[..., None, :]
        hessian[..., :3, :3] = quarter * (
            2.0 * np.outer(one, one) + 2.0 * C * product + by_I2[..., None, None] * bend
        )
        return psi, gradient, hessian
