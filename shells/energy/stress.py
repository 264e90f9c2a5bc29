"""What a solved shell carries: stress resultants and principal stretches at quadrature points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .kirchhoff_love import KirchhoffLove


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

    A negative principal membrane force with a stretch below one marks wrinkling.

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
    strain = 0.5 * (first - metric[0]) * np.array([1.0, 1.0, 2.0])
    bending = (second - metric[1]) * np.array([1.0, 1.0, 2.0])
    C = shell.elasticity
    n = np.einsum("eqij,eqj->eqi", C, strain)
    m = shell.material.flexural_rigidity * np.einsum("eqij,eqj->eqi", C, bending)
    # eigenvalues of A^-1 a: the squared principal stretches
    A, a = (_matrix(x) for x in (metric[0], first))
    values = np.linalg.eigvals(np.linalg.solve(A, a)).real
    return Stress(n, m, np.sqrt(np.sort(values, axis=-1)[..., ::-1]))


def _matrix(form: np.ndarray) -> np.ndarray:
    """Symmetric 2 x 2 matrices of components (00, 11, 01)."""
    rows = [[form[..., 0], form[..., 2]], [form[..., 2], form[..., 1]]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))
