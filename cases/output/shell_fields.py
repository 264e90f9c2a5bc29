"""A shell result as quadrilaterals for ParaView: displacement, stretches, stress resultants.

Resultants live at quadrature points; a cell carries the mean of its element.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .vtk import write_grid

if TYPE_CHECKING:
    from shells.energy.kirchhoff_love import KirchhoffLove


def shell_grid(
    shell: KirchhoffLove,
    coefficients: np.ndarray,
    start: np.ndarray | None = None,
    tessellate: int = 3,
) -> dict[str, Any]:
    """Grid of a configuration with its mechanical fields.

    Parameters
    ----------
    shell : KirchhoffLove
    coefficients : (n_coefficients, 3) array
        Unknowns of the shell: the configuration, or displacements from an exact reference.
    start : (n_coefficients, 3) array, optional
        Configuration displacements count from; default the reference.
    tessellate : int
        Cells per element and direction.

    Returns
    -------
    dict
        ``points (n, 3)``, ``quads (m, 4)``, ``point_data`` (displacement), ``cell_data``
        (principal stretches, membrane forces and moments in the reference frame).
    """
    from shells.conditions.rigid_motions import coefficients_of
    from shells.energy.stress import stress

    surface = shell.basis.surface
    reference = coefficients_of(shell.basis)
    c = coefficients + reference if shell.exact_reference else coefficients
    n = tessellate + 1
    xi, eta = (g.ravel() for g in np.meshgrid(*2 * [np.linspace(0.0, 1.0, n)], indexing="ij"))
    sample = surface.sample(xi, eta)
    i, j = (g.ravel() for g in np.meshgrid(*2 * [range(tessellate)], indexing="ij"))
    cell = np.stack([i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1], axis=1)
    first = np.arange(surface.n_elements)[:, None, None] * n * n
    result = stress(shell, coefficients)
    weights = shell.basis.dx / shell.basis.dx.sum(axis=1, keepdims=True)

    def mean(field: np.ndarray) -> np.ndarray:
        return np.repeat(np.einsum("eq,eqc->ec", weights, field), tessellate**2, axis=0)

    return {
        "points": sample @ c,
        "quads": (first + cell).reshape(-1, 4),
        "point_data": {"displacement": sample @ (c - (reference if start is None else start))},
        "cell_data": {
            "stretch": mean(result.stretches),
            "membrane_force": mean(result.membrane),
            "moment": mean(result.moment),
        },
    }


def write_shell(
    path: Path | str, shell: KirchhoffLove, coefficients: np.ndarray, **options: Any
) -> None:
    """Write a VTU file of `shell_grid`."""
    write_grid(Path(path), shell_grid(shell, coefficients, **options))
