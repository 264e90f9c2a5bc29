"""The single layer with its plain part compressed: ``A = B^T W C_near + (W B)^T G (W B)``.

The near field stays exact and sparse; compression acts on the plain point kernel only, whose
error is measured for random and constant densities. What that costs a traction is measured by its
solve, see `hbem.flows.measured_solve`: no product with the operator tells it.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix, diags, vstack

from ..compression.h2matrix import h2matrix
from ..compression.hmatrix import hmatrix
from ..compression.operator import Compressed
from ..near.near_field import NearField
from ..surfaces.surface_points import SampledSurface
from .choice import Compression
from .dense_layer import dense_matrix
from .layer import SingleLayer, densities


class CompressedSingleLayer(SingleLayer):
    """The single layer with compressed plain part; products of many vectors at once.

    Attributes
    ----------
    plain : Compressed
        ``(W B)^T G (W B)``; its ``statistics`` tell error, ranks, bytes and seconds.
    compression : Compression
        What was asked for.
    """

    def __init__(
        self, surface: SampledSurface, near: NearField, plain: Compressed, compression: Compression
    ):
        super().__init__(surface, near)
        self.plain, self.compression = plain, compression

    def dense(self) -> np.ndarray:
        return dense_matrix(self.surface, self.near)

    def _matmat(self, x: np.ndarray) -> np.ndarray:
        x = densities(x)
        return (self.near.apply(x) + self.plain.apply(x)).reshape(self.shape[0], -1)

    def _rmatmat(self, x: np.ndarray) -> np.ndarray:
        near = self.near.apply_transposed(densities(x))
        return near.reshape(self.shape[0], -1) + self.plain.T @ x

    def statistics(self) -> dict[str, float | int | str]:
        """Everything measured, for run records."""
        return self.plain.statistics.record()

    def __getitem__(self, key: int | slice | tuple) -> None:
        self.plain[key]

    def __repr__(self) -> str:
        return f"{self.plain!r}\n  {self.near.nbytes / 1e6:.1f} MB near correction"


def compressed_single_layer(
    surface: SampledSurface, near: NearField, compression: Compression
) -> CompressedSingleLayer:
    """Compress the plain part of a single layer.

    Raises
    ------
    ValueError
        ACA with source points that differ from the outer points.
    MemoryError
        A forecast above ``compression.memory``.
    """
    return CompressedSingleLayer(surface, near, _plain(surface, compression), compression)


def _plain(surface: SampledSurface, compression: Compression) -> Compressed:
    """The plain part by the method asked for."""
    tolerance, seed, memory = compression.tolerance, compression.seed, compression.memory
    one_set = surface.source is surface.outer
    if compression.method == "h2":
        points, basis, test = (
            (surface.outer.offsets, weighted_basis(surface), None) if one_set else _join(surface)
        )
        group = points.shape[0] // surface.patches.n_elements
        functions = {"basis": basis, "test": test, "group": group}
        return h2matrix(points, tolerance, **functions, seed=seed, memory=memory)
    if not one_set:
        raise ValueError(
            "compression by ACA needs equal outer and source points: set far = 0 in the "
            'quadrature orders, or compression = "h2"'
        )
    basis = weighted_basis(surface)
    return hmatrix(surface.outer.offsets, tolerance, basis=basis, seed=seed, memory=memory)


def weighted_basis(surface: SampledSurface) -> csr_matrix:
    """``W B`` at the outer points, ``(n_points, n_dofs)``."""
    return (diags(surface.outer.weights) @ surface.basis).tocsr()


def _join(surface: SampledSurface) -> tuple[np.ndarray, csr_matrix, csr_matrix]:
    """Outer and source points element by element, with the functions of sources and of tests."""
    outer, source = surface.outer, surface.source
    n = surface.patches.n_dofs
    empty = [csr_matrix((p.weights.size, n)) for p in (outer, source)]
    basis = diags(source.weights) @ surface.source_basis
    numbers = [np.arange(p.weights.size).reshape(-1, p.per_element) for p in (outer, source)]
    order = np.hstack([numbers[0], outer.weights.size + numbers[1]]).ravel()
    return (
        np.concatenate([outer.offsets, source.offsets])[order],
        vstack([empty[0], basis]).tocsr()[order],
        vstack([weighted_basis(surface), empty[1]]).tocsr()[order],
    )
