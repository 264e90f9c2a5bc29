"""The single layer with its plain part compressed: ``A = B^T W C_near + (W B)^T G (W B)``.

The near field stays exact and sparse; compression acts on the plain point kernel only, whose
error is measured for random and constant densities (compared with the tolerance) and for densities
that cancel across gaps (reported: relative to ``|A x|`` they see 10 to 50 times more).
"""

from __future__ import annotations

import logging
from dataclasses import replace

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

log = logging.getLogger(__name__)


class CompressedSingleLayer(SingleLayer):
    """The single layer with compressed plain part; products of many vectors at once.

    Attributes
    ----------
    plain : Compressed
        ``(W B)^T G (W B)``; its ``statistics`` tell error, ranks, bytes and seconds.
    compression : Compression
        What was asked for.
    error_gap, error_traction : float
        Measured on gap-opposed densities and on a solved traction, relative to ``|A x|``;
        NaN before.
    """

    def __init__(
        self, surface: SampledSurface, near: NearField, plain: Compressed, compression: Compression
    ):
        super().__init__(surface, near)
        self.plain, self.compression = plain, compression
        self.error_gap, self.error_traction = np.nan, np.nan

    def dense(self) -> np.ndarray:
        return dense_matrix(self.surface, self.near)

    def _matmat(self, x: np.ndarray) -> np.ndarray:
        x = densities(x)
        return (self.near.apply(x) + self.plain.apply(x)).reshape(self.shape[0], -1)

    def _rmatmat(self, x: np.ndarray) -> np.ndarray:
        near = self.near.apply_transposed(densities(x))
        return near.reshape(self.shape[0], -1) + self.plain.T @ x

    def error_on(self, density: np.ndarray, seed: int = 0) -> float:
        """Measured error of ``A x`` for densities ``(n_dofs, 3)``, relative to ``|A x|``."""
        items, exact = _exact(self, density[:, :, None], seed)
        whole = (exact + self.near.apply(density[:, :, None])[items])[:, :, 0]
        difference = (self.plain.apply(density[:, :, None])[items] - exact)[:, :, 0]
        size = float(np.linalg.norm(whole))
        return float(np.linalg.norm(difference)) / size if size > 0.0 else 0.0

    def measure_on(self, traction: np.ndarray, expected: float) -> None:
        """Measure ``error_traction`` on a solved traction ``(n_dofs, 3)``; warn above expected."""
        self.error_traction = self.error_on(traction)
        if self.error_traction > expected:
            self._warn("the traction", self.error_traction, expected)

    def measure_gap(self, expected: float, seed: int) -> None:
        """Measure ``error_gap``; warn above expected."""
        self.error_gap = self.error_on(gap_opposed(self.surface), seed)
        if self.error_gap > expected:
            self._warn("gap-opposed densities", self.error_gap, expected)

    def _warn(self, where: str, error: float, expected: float) -> None:
        message = (
            f"error on {where} {error:.1e}, expected at most {expected:.1e}: less accurate than "
            "asked in the gap"
        )
        log.warning(message)
        s = self.plain.statistics
        self.plain.statistics = replace(s, note="; ".join(filter(None, [s.note, message])))

    def statistics(self) -> dict[str, float | int | str]:
        """Everything measured, for run records."""
        return {
            **self.plain.statistics.record(),
            "error_gap": self.error_gap,
            "error_traction": self.error_traction,
        }

    def __getitem__(self, key: int | slice | tuple) -> None:
        self.plain[key]

    def __repr__(self) -> str:
        near = f"{self.near.nbytes / 1e6:.1f} MB near correction"
        cancelling = f"gap-opposed: {self.error_gap:.1e} of |A x|"
        if self.error_traction == self.error_traction:
            cancelling += f", last traction: {self.error_traction:.1e}"
        return f"{self.plain!r}\n  {cancelling}; {near}"


def _exact(
    layer: CompressedSingleLayer, density: np.ndarray, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    n = density.shape[0]
    items = np.sort(np.random.default_rng(seed).permutation(n)[:48])
    return items, layer.plain.exact_rows(items, density)


def compressed_single_layer(
    surface: SampledSurface, near: NearField, compression: Compression
) -> CompressedSingleLayer:
    """Compress the plain part of a single layer and measure what that costs in accuracy.

    Raises
    ------
    ValueError
        ACA with source points that differ from the outer points.
    MemoryError
        A forecast above ``compression.memory``.
    """
    layer = CompressedSingleLayer(surface, near, _plain(surface, compression), compression)
    layer.measure_gap(compression.expected_gap_error, compression.seed)
    return layer


def _plain(surface: SampledSurface, compression: Compression) -> Compressed:
    """The plain part by the method asked for."""
    tolerance, seed, memory = compression.tolerance, compression.seed, compression.memory
    one_set = surface.source is surface.outer
    if compression.method == "h2":
        points, basis, test = (
            (surface.outer.offsets, weighted_basis(surface), None) if one_set else _join(surface)
        )
        return h2matrix(points, tolerance, basis=basis, test=test, seed=seed, memory=memory)
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


def gap_opposed(surface: SampledSurface) -> np.ndarray:
    """A pressure that varies along the surface, ``p n`` with linear p: ``(n_dofs, 3)``.

    In a gap the forces on both sheets oppose each other and A x nearly vanishes.
    """
    area = np.asarray(surface.mass.sum(axis=1)).ravel()
    normals = surface.constraint / area[:, None]
    positions = surface.project(surface.outer.offsets) / area[:, None]
    positions = positions - positions.mean(axis=0)
    axis = int(np.argmax(np.ptp(positions, axis=0)))
    return normals * positions[:, axis : axis + 1]


def _join(surface: SampledSurface) -> tuple[np.ndarray, csr_matrix, csr_matrix]:
    """Outer and source points as one set, with the functions of sources and of tests."""
    outer, source = surface.outer, surface.source
    n = surface.patches.n_dofs
    empty = [csr_matrix((p.weights.size, n)) for p in (outer, source)]
    basis = diags(source.weights) @ surface.source_basis
    return (
        np.concatenate([outer.offsets, source.offsets]),
        vstack([empty[0], basis]).tocsr(),
        vstack([weighted_basis(surface), empty[1]]).tocsr(),
    )
