"""The joint between surfaces and boundary integrals: polynomial patches with a density basis.

A surface is a set of quadrilateral (or triangular) elements. On element ``e`` the geometry is a
tensor-product Bezier patch and every density function a combination of Bernstein polynomials,
``N_a(s, t) = sum_k extraction[a, k] B_k(s, t)`` with ``k = i * (q + 1) + j`` for
``B_i(s) B_j(t)`` on the unit square. Any object with these attributes serves; bases of the
shell package do by structure.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.sparse import block_diag, csr_matrix


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
        Polynomial degree per direction of the Bezier patches and of the extraction tables; of
        triangles the total degree, with ``(p + 1) (p + 2) / 2`` coefficients, see
        `hbem.surfaces.triangles`.
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

    @property
    def shape(self) -> str: ...

    @property
    def n_elements(self) -> int: ...

    @property
    def n_dofs(self) -> int: ...

    @property
    def n_coefficients(self) -> int: ...

    @property
    def geometry_degree(self) -> int: ...

    @property
    def density_degree(self) -> int: ...

    @property
    def indptr(self) -> np.ndarray: ...

    @property
    def dofs(self) -> np.ndarray: ...

    @property
    def extraction(self) -> np.ndarray: ...

    @property
    def bezier(self) -> csr_matrix: ...


@dataclass(frozen=True)
class BezierPatches:
    """Patches given by tables: exact bodies and unions of surfaces.

    Parameters
    ----------
    n_dofs, geometry_degree, density_degree : int
    indptr, dofs, extraction, bezier :
        Tables as `SurfacePatches` describes them.
    coefficients : (n_coefficients, 3) array, optional
        Configuration of a fixed body; None where it comes from elsewhere.
    shape : {"quadrilateral", "triangle"}

    Raises
    ------
    ValueError
        Tables whose sizes contradict each other.
    """

    n_dofs: int
    geometry_degree: int
    density_degree: int
    indptr: np.ndarray
    dofs: np.ndarray
    extraction: np.ndarray
    bezier: csr_matrix
    coefficients: np.ndarray | None = None
    shape: str = "quadrilateral"

    def __post_init__(self) -> None:
        rows = int(self.indptr[-1])
        triangle = self.shape == "triangle"
        if self.dofs.shape != (rows,):
            raise ValueError(f"indptr announces {rows} table rows, dofs has {self.dofs.shape}")
        if self.extraction.shape != (rows, _functions(self.density_degree, triangle)):
            raise ValueError(f"extraction tables have the wrong shape {self.extraction.shape}")
        if self.bezier.shape[0] != self.n_elements * _functions(self.geometry_degree, triangle):
            raise ValueError("bezier must have one row per Bezier control point")
        if rows and (self.dofs.min() < 0 or self.dofs.max() >= self.n_dofs):
            raise ValueError("a table row names a density function outside 0..n_dofs - 1")

    @property
    def n_elements(self) -> int:
        """Number of elements."""
        return self.indptr.size - 1

    @property
    def n_coefficients(self) -> int:
        """Rows of a configuration."""
        return self.bezier.shape[1]


def _functions(degree: int, triangle: bool) -> int:
    """Bernstein functions of one element."""
    return (degree + 1) * (degree + 2) // 2 if triangle else (degree + 1) ** 2


def union(*surfaces: SurfacePatches) -> BezierPatches:
    """Several surfaces as one; elements, functions and coefficients follow each other.

    Parameters
    ----------
    *surfaces : SurfacePatches
        Of one shape and equal degrees.

    Returns
    -------
    BezierPatches
        With coefficients if all surfaces have them.

    Raises
    ------
    ValueError
        Surfaces of different shapes or degrees.
    """
    kinds = {(p.shape, p.geometry_degree, p.density_degree) for p in surfaces}
    if len(kinds) != 1:
        raise ValueError(f"a union needs surfaces of one shape and degree, got {sorted(kinds)}")
    shape, geometry_degree, density_degree = kinds.pop()
    first_dof = np.cumsum([0] + [p.n_dofs for p in surfaces])
    first_row = np.cumsum([0] + [p.indptr[-1] for p in surfaces])
    given = (getattr(p, "coefficients", None) for p in surfaces)
    known = [c for c in given if c is not None]
    return BezierPatches(
        n_dofs=int(first_dof[-1]),
        geometry_degree=geometry_degree,
        density_degree=density_degree,
        indptr=np.concatenate(
            [[0]] + [p.indptr[1:] + o for p, o in zip(surfaces, first_row, strict=False)]
        ),
        dofs=np.concatenate([p.dofs + o for p, o in zip(surfaces, first_dof, strict=False)]),
        extraction=np.concatenate([p.extraction for p in surfaces]),
        bezier=block_diag([p.bezier for p in surfaces], format="csr"),
        coefficients=np.concatenate(known) if len(known) == len(surfaces) else None,
        shape=shape,
    )
