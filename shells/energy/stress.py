"""What a solved shell carries at quadrature points: stress resultants, stretches, wrinkles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .densities import relaxed
from .kirchhoff_love import KirchhoffLove

VOIGT = np.array([1.0, 1.0, 2.0])


@dataclass(frozen=True)
class Stress:
    """Resultants in the reference's orthonormal tangent frame.

    Attributes
    ----------
    membrane : (n_elements, n_points, 3) array
        Second Piola-Kirchhoff membrane forces n_00, n_11, n_01, force per reference length.
    moment : (n_elements, n_points, 3) array
        Bending moments m_00, m_11, m_01 per reference length.
    stretches : (n_elements, n_points, 2) array
        Principal stretches, larger first.
    """

    membrane: np.ndarray
    moment: np.ndarray
    stretches: np.ndarray


def stress(shell: KirchhoffLove, coefficients: np.ndarray) -> Stress:
    """Stress resultants [T 2.17] and principal stretches.

    A negative principal membrane force with a stretch below one marks wrinkling; `wrinkling`
    says where a tension field wrinkles.

    Parameters
    ----------
    shell : KirchhoffLove
    coefficients : (n_coefficients, 3) array

    Returns
    -------
    Stress
        With arrays ``membrane``, ``moment`` and ``stretches`` at the quadrature points.
    """
    metric, first, second = shell.forms(coefficients)
    strain = 0.5 * (first - metric[0]) * VOIGT
    bending = (second - metric[1]) * VOIGT
    C = shell.elasticity
    if shell.compression_share < 1.0:
        n = relaxed(shell.material, strain, shell.compression_share)[2][1]
    else:
        n = np.einsum("eqij,eqj->eqi", C, strain)
    m = shell.material.flexural_rigidity * np.einsum("eqij,eqj->eqi", C, bending)
    # eigenvalues of A^-1 a: the squared principal stretches
    A, a = (_matrix(x) for x in (metric[0], first))
    values = np.linalg.eigvals(np.linalg.solve(A, a)).real
    return Stress(n, m, np.sqrt(np.sort(values, axis=-1)[..., ::-1]))


@dataclass(frozen=True)
class Wrinkling:
    """Where a membrane wrinkles.

    Attributes
    ----------
    state : (n_elements, n_points) int array
        0 taut, 1 wrinkled (tension in one direction), 2 slack.
    strains : (n_elements, n_points, 2) array
        Principal Green strains e1 >= e2.
    """

    state: np.ndarray
    strains: np.ndarray


def wrinkling(shell: KirchhoffLove, coefficients: np.ndarray) -> Wrinkling:
    """Taut, wrinkled and slack zones of a tension field; of another shell, where it would wrinkle.

    Parameters
    ----------
    shell : KirchhoffLove
    coefficients : (n_coefficients, 3) array

    Returns
    -------
    Wrinkling
        At the quadrature points of the shell's basis.

    Raises
    ------
    ValueError
        A shell in the classical formulation, whose frame is not orthonormal.
    """
    if shell.formulation == "classical":
        raise ValueError("wrinkling needs the parametrization-free formulation")
    metric, first, _ = shell.forms(coefficients)
    strain = 0.5 * (first - metric[0]) * VOIGT
    state, principal, _ = relaxed(shell.material, strain, shell.compression_share)
    return Wrinkling(state, principal)


def _matrix(form: np.ndarray) -> np.ndarray:
    """Symmetric 2 x 2 matrices of components (00, 11, 01)."""
    rows = [[form[..., 0], form[..., 2]], [form[..., 2], form[..., 1]]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))
