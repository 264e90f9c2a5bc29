"""The joint between surfaces and boundary integrals: polynomial patches with a density basis.

A surface is a set of quadrilateral (or triangular) elements. On element ``e`` the geometry is a
tensor-product Bezier patch and every density function a combination of Bernstein polynomials,
``N_a(s, t) = sum_k extraction[a, k] B_k(s, t)`` with ``k = i * (q + 1) + j`` for
``B_i(s) B_j(t)`` on the unit square. Any object with these attributes serves; bases of the
shell package do by structure.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from scipy.sparse import csr_matrix


class SurfacePatches(Protocol):
    """Elements, geometry and density basis of a surface, as the boundary integrals see it.

    Attributes
    ----------
    shape : str
        ``"quadrilateral"`` or ``"triangle"``.
    n_elements, n_dofs : int
        Number of elements and of scalar density functions.
    n_coefficients : int
        Rows of the coefficient array that ``geometry`` expects.
    geometry_degree, density_degree : int
        Polynomial degree per direction of the Bezier patches and of the extraction tables.
    indptr : (n_elements + 1,) int array
        Element ``e`` owns the table rows ``indptr[e]:indptr[e + 1]``; ragged where elements
        differ (poles, cuts).
    dofs : (n_rows,) int array
        Density function of each table row.
    extraction : (n_rows, (density_degree + 1) ** 2) array
        Bernstein coefficients of each table row.
    bezier : (n_elements * (geometry_degree + 1) ** 2, n_coefficients) sparse matrix
        Coefficients to Bezier control points. It carries configurations and velocities alike,
        and its transpose carries forces back.
    """

    shape: str
    n_elements: int
    n_dofs: int
    n_coefficients: int
    geometry_degree: int
    density_degree: int
    indptr: np.ndarray
    dofs: np.ndarray
    extraction: np.ndarray
    bezier: csr_matrix
