"""What all compressed operators share: the kernel, products, the measured error, statistics.

The operator is ``(W B)^T G (W B)`` with the plain kernel G between points, or G itself. The error
that counts is measured on exact rows for random and for constant densities; a build that misses
its tolerance is repeated at a quarter of it, and after that everything is summed exactly.
"""

from __future__ import annotations

import logging
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from copy import copy
from dataclasses import asdict, dataclass, replace
from typing import NoReturn

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import LinearOperator

from .point_kernel import (
    TEST_RANDOM,
    PointKernel,
    components_first,
    multiply_components,
    probe_densities,
)

TEST_POINTS = 200  # exact rows behind a measured error, at least
TEST_FUNCTIONS = 48
TEST_PAIRS = 2e7  # between points: as many exact rows as this many pairs allow
EXACT = 1e-11  # tolerances below: nothing is compressed

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Statistics:
    """What a compressed operator is and how good it is.

    Attributes
    ----------
    method : str
        aca, h2 or direct.
    n : int
        Points or functions; there are 3 n unknowns.
    tolerance : float
        Of the build, after tightening.
    requested : float
    error_random, error_constant : float
        Measured relative errors on exact rows.
    far_blocks, full_blocks, near_blocks : int
        Compressed blocks, admissible ones that did not compress, pairs of leaves.
    rank_mean, rank_max
    bytes_far, bytes_near : int
    build_seconds, apply_seconds : float
    note : str
        What went another way than asked.
    """

    method: str
    n: int
    tolerance: float
    requested: float = 0.0
    error_random: float = np.nan
    error_constant: float = np.nan
    far_blocks: int = 0
    full_blocks: int = 0
    near_blocks: int = 0
    rank_mean: float = 0.0
    rank_max: int = 0
    bytes_far: int = 0
    bytes_near: int = 0
    build_seconds: float = 0.0
    apply_seconds: float = 0.0
    note: str = ""

    @property
    def achieved(self) -> float:
        """The number that is compared with the tolerance."""
        return float(np.maximum(self.error_random, self.error_constant))  # NaN if either is

    @property
    def bytes_per_unknown(self) -> float:
        return (self.bytes_far + self.bytes_near) / (3 * self.n)

    @property
    def ratio(self) -> float:
        """Bytes over those of the dense matrix."""
        return self.bytes_per_unknown / (24.0 * self.n)

    def record(self) -> dict[str, float | int | str]:
        """All of it for files."""
        more = ("achieved", "bytes_per_unknown", "ratio")
        return {**asdict(self), **{name: getattr(self, name) for name in more}}


class Compressed(LinearOperator, ABC):
    """A plain Stokes operator in compressed form; vector unknown ``3 a + i``.

    Attributes
    ----------
    kernel : PointKernel
    basis, test : csc_matrix or None
        Weighted functions ``(n_points, n)`` of the sources and of the tests, often the same.
    statistics : Statistics
    """

    def __init__(
        self,
        kernel: PointKernel,
        basis: csc_matrix | None,
        statistics: Statistics,
        test: csc_matrix | None = None,
    ):
        n = kernel.n if basis is None else basis.shape[1]
        super().__init__(dtype=np.dtype(float), shape=(3 * n, 3 * n))
        self.kernel, self.basis, self.statistics = kernel, basis, statistics
        self.test = basis if test is None else test

    @abstractmethod
    def _apply(self, x: np.ndarray) -> np.ndarray:
        """Scaled product with ``(k, 3, n)`` components first."""

    def _between_functions(
        self, x: np.ndarray, sums: Callable[[np.ndarray], np.ndarray]
    ) -> np.ndarray:
        """Sums between points for charges of functions, tested; without functions the sums."""
        if self.basis is None or self.test is None:
            return sums(x)
        return multiply_components(self.test.T, sums(multiply_components(self.basis, x)))

    def apply(self, x: np.ndarray) -> np.ndarray:
        """Product with densities ``(n, 3, k)``, all k at once.

        Raises
        ------
        ValueError
            Complex densities.
        """
        first = components_first(x)
        # scaled to order one, exactly: single precision has a narrow range
        size = np.abs(first).max(axis=(1, 2), initial=0.0)
        exponent = np.frexp(np.where(np.isfinite(size), size, 0.0))[1][:, None, None]
        y = np.ldexp(self._apply(np.ldexp(first, -exponent)), exponent) * self.kernel.factor
        return np.moveaxis(y.swapaxes(1, 2), 0, 2)

    def _matmat(self, x: np.ndarray) -> np.ndarray:
        return self.apply(np.asarray(x).reshape(-1, 3, x.shape[-1])).reshape(x.shape)

    def _matvec(self, x: np.ndarray) -> np.ndarray:
        return self._matmat(np.asarray(x).reshape(-1, 1)).reshape(np.shape(x))

    def _rmatmat(self, x: np.ndarray) -> np.ndarray:
        if self.kernel.normals is not None:
            raise NotImplementedError(
                "the transposed double layer, with its normals at the targets, is not summed here"
            )
        if self.test is self.basis:
            return self._matmat(x)  # the Stokeslet is symmetric, and so is what approximates it
        return self._turned()._matmat(x)

    def _turned(self) -> Compressed:
        """The same with sources and tests exchanged."""
        turned = copy(self)
        turned.basis, turned.test = self.test, self.basis
        return turned

    def _rmatvec(self, x: np.ndarray) -> np.ndarray:
        return self._rmatmat(np.asarray(x).reshape(-1, 1)).reshape(np.shape(x))

    def __getitem__(self, key: int | slice | tuple) -> NoReturn:
        raise TypeError(
            "a compressed operator has no entries to index: multiply it (A @ x, A @ X for several "
            "vectors at once), or ask for exact rows with exact_rows(indices, x)"
        )

    def exact_rows(self, items: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Exact ``(A x)`` at some points or functions, ``(len(items), 3, k)``, no compression.

        Parameters
        ----------
        items : (m,) int array
        x : (n, 3, k) array
        """
        first = components_first(x)
        if self.basis is None or self.test is None:
            y = self.kernel.rows(items, first)
        else:
            test = self.test[:, items].tocsr()
            points = np.flatnonzero(np.diff(test.indptr))
            charges = multiply_components(self.basis, first)
            y = multiply_components(test[points].T, self.kernel.rows(points, charges))
        return np.moveaxis(y.swapaxes(1, 2), 0, 2) * self.kernel.factor

    def relative_error(self, x: np.ndarray, seed: int = 0) -> np.ndarray:
        """Measured relative errors ``(k,)`` for densities ``(n, 3, k)``, on sampled exact rows.

        Where ``r . n`` of the double layer cancels down to rounding, exact rows with the axes in
        another order differ by as much: that counts too.
        """
        n, count = x.shape[0], TEST_FUNCTIONS
        if self.basis is None:
            count = max(TEST_POINTS, int(TEST_PAIRS / n))
        items = np.sort(np.random.default_rng(seed).permutation(n)[:count])
        exact = self.exact_rows(items, x)
        difference = np.linalg.norm(self.apply(x)[items] - exact, axis=(0, 1))
        if self.kernel.normals is not None:
            turned, axes = copy(self), [1, 2, 0]
            turned.kernel = self.kernel.with_axes(axes)
            again = turned.exact_rows(items, x[:, axes]) - exact[:, axes]
            difference = np.maximum(difference, np.linalg.norm(again, axis=(0, 1)))
        with np.errstate(over="ignore"):
            return difference / np.maximum(np.linalg.norm(exact, axis=(0, 1)), 1e-300)

    def __repr__(self) -> str:
        s = self.statistics
        note = f"\n  note: {s.note}" if s.note else ""
        return (
            f"{type(self).__name__}({3 * s.n} unknowns, {s.method})\n"
            f"  error: {s.error_random:.1e} random, {s.error_constant:.1e} constant density; "
            f"requested {s.requested:.1e}, built at {s.tolerance:.1e}\n"
            f"  blocks: {s.far_blocks} compressed, {s.full_blocks} full, {s.near_blocks} near; "
            f"rank {s.rank_mean:.1f} mean, {s.rank_max} max\n"
            f"  memory: {s.bytes_far / 1e6:.1f} MB far + {s.bytes_near / 1e6:.1f} MB near, "
            f"{s.bytes_per_unknown / 1e3:.2f} kB an unknown, {100 * s.ratio:.3g}% of dense\n"
            f"  time: {s.build_seconds:.2f} s build, {s.apply_seconds:.4f} s apply{note}"
        )


class Direct(Compressed):
    """Exact sums over all points, nothing stored."""

    def _apply(self, x: np.ndarray) -> np.ndarray:
        return self._between_functions(x, lambda f: self.kernel.rows(np.arange(self.kernel.n), f))


def direct(
    kernel: PointKernel,
    basis: csc_matrix | None,
    note: str = "",
    test: csc_matrix | None = None,
) -> Direct:
    """The operator by exact sums."""
    n = kernel.n if basis is None else basis.shape[1]
    return Direct(kernel, basis, Statistics("direct", n, 0.0, note=note), test)


def with_measured_error(operator: Compressed, requested: float, seed: int) -> Compressed:
    """The operator with measured errors and apply time in its statistics."""
    x = probe_densities(operator.statistics.n, seed)
    errors = operator.relative_error(x, seed)
    began = time.perf_counter()
    operator.apply(x[:, :, :1])
    operator.statistics = replace(
        operator.statistics,
        requested=requested,
        error_random=float(errors[:TEST_RANDOM].max()),
        error_constant=float(errors[TEST_RANDOM:].max()),
        apply_seconds=time.perf_counter() - began,
    )
    return operator


def build_to_tolerance(
    build: Callable[[float], Compressed],
    tolerance: float,
    seed: int,
    exact: Callable[[str], Compressed],
) -> Compressed:
    """Build, measure, build again at a quarter, and at last sum exactly: never silent.

    ``build(tolerance)`` compresses; ``exact(note)`` sums and says why.

    Raises
    ------
    ValueError
        A tolerance outside (0, 1).
    """
    if not 0.0 < tolerance < 1.0:
        raise ValueError(f"tolerance must lie between 0 and 1, got {tolerance}")
    for target in (tolerance, tolerance / 4.0):
        if target < EXACT:
            note = f"tolerance {tolerance:.1e} leaves nothing to compress"
            break
        operator = with_measured_error(build(target), tolerance, seed)
        if operator.statistics.achieved <= tolerance:
            return operator
        note = f"error {operator.statistics.achieved:.1e} above the tolerance {tolerance:.1e}"
        log.warning("%s (built at %.1e): %s", operator.statistics.method, target, note)
        del operator
    note += ": exact sums"
    log.warning("not compressed: %s", note)
    operator = with_measured_error(exact(note), tolerance, seed)
    left = operator.statistics.achieved
    if not left <= tolerance:
        log.warning("rounding of the points and normals given leaves an error of %.1e", left)
    return operator
