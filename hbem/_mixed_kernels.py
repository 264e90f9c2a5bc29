"""A matrix stored in single precision applied in double precision.

Half the memory and traffic; the rounding of single-precision sums, amplified by the small
eigenvalues of films, would cost iterations.
"""

from __future__ import annotations

from numba import njit, prange


@njit(cache=True, error_model="numpy", nogil=True, parallel=True, fastmath={"reassoc", "contract"})
def product(matrix, x, out):
    """``out = matrix x`` for ``(n, k)`` and ``(k,)``."""
    for i in prange(matrix.shape[0]):
        row = matrix[i]
        s = 0.0
        for j in range(x.size):
            s += row[j] * x[j]
        out[i] = s
