"""Triangular patches as quadrilateral ones with a contracted edge.

A Bezier triangle of degree p, ``sum_{a+b+c=p} P_abc p!/(a! b! c!) u^a v^b w^c``, is on the square
``u = 1 - s, v = s (1 - t), w = s t`` the tensor patch whose row i is a line of degree i, raised to
degree p: exact, for geometry and density alike. All rules for collapsed elements then serve.
"""

from __future__ import annotations

from functools import cache
from math import comb

import numpy as np
from scipy.sparse import csr_matrix, identity, kron

from .patches import BezierPatches, SurfacePatches


def triangle_index(degree: int) -> np.ndarray:
    """Exponents ``(a, b, c)`` of the Bernstein functions of a triangle, ``(n, 3)``, in order.

    Vertex u = 1 first, then row by row towards the opposite edge: (p, 0, 0), (p-1, 1, 0), ...
    """
    return np.array([(degree - i, i - j, j) for i in range(degree + 1) for j in range(i + 1)])


def collapse_table(degree: int, vertex: int = 0) -> np.ndarray:
    """Triangular control points to tensor ones: ``((degree + 1)**2, n)``.

    Row ``i * (degree + 1) + j`` is the tensor point (i, j); ``vertex`` is contracted.
    """
    index = {tuple(abc): k for k, abc in enumerate(triangle_index(degree))}
    table = np.zeros(((degree + 1) ** 2, len(index)))
    for i in range(degree + 1):
        for j in range(degree + 1):
            for k in range(max(0, i + j - degree), min(i, j) + 1):
                # degree raising of the line (i, k), k = 0..i, to degree p
                weight = comb(i, k) * comb(degree - i, j - k) / comb(degree, j)
                abc = tuple(np.roll((degree - i, i - k, k), vertex).tolist())
                table[i * (degree + 1) + j, index[abc]] += weight
    return table


@cache
def rotation_table(degree: int, vertex: int) -> np.ndarray:
    """Tensor points contracted at vertex 0 to those at ``vertex``, ``((degree + 1)**2,) * 2``."""
    return collapse_table(degree, vertex) @ np.linalg.pinv(collapse_table(degree))


def barycentric(s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """``(u, v, w)`` of local coordinates ``s, t (n,)`` contracted at vertex 0, ``(n, 3)``."""
    return np.stack([1.0 - s, s * (1.0 - t), s * t], axis=1)


def quadrilaterals(patches: SurfacePatches, vertex: int = 0) -> BezierPatches:
    """A triangular surface as quadrilateral patches, contracted at one vertex of each.

    Tables of triangles have ``(p + 1) (p + 2) / 2`` columns (rows of ``bezier``) an element, in
    the order of `triangle_index`; ``x_v x x_w`` with ``u = 1 - v - w`` points outwards.

    Raises
    ------
    ValueError
        Patches that are not triangular, or tables of the wrong size.
    """
    if patches.shape != "triangle":
        raise ValueError(f"expected triangular patches, got {patches.shape!r}")
    g, q, n = patches.geometry_degree, patches.density_degree, patches.indptr.size - 1
    geometry, density = collapse_table(g, vertex), collapse_table(q, vertex)
    if patches.bezier.shape[0] != n * geometry.shape[1]:
        raise ValueError(f"bezier must have {geometry.shape[1]} rows per triangle of degree {g}")
    if patches.extraction.shape[1] != density.shape[1]:
        raise ValueError(
            f"extraction must have {density.shape[1]} columns for triangles of degree {q}"
        )
    return BezierPatches(
        n_dofs=patches.n_dofs,
        geometry_degree=g,
        density_degree=q,
        indptr=patches.indptr,
        dofs=patches.dofs,
        extraction=np.ascontiguousarray(patches.extraction @ density.T),
        bezier=csr_matrix(kron(identity(n), geometry) @ patches.bezier),
        coefficients=getattr(patches, "coefficients", None),
    )
