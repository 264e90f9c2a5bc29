"""Plane curves held at both ends, as one sparse extraction."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix, identity


def end_supports(coefficients: np.ndarray, kind: str = "hinged") -> csr_matrix:
    """Extraction ``(2 n_full, n_free)`` of a curve held at both ends.

    Hinged ends keep their position; clamped ends also their tangent's direction, its length
    stays free.

    Raises
    ------
    ValueError
        A kind other than ``"hinged"`` or ``"clamped"``.
    """
    if kind not in ("hinged", "clamped"):
        raise ValueError(f"an end is 'hinged' or 'clamped', not {kind!r}")
    n = coefficients.shape[0]
    full = identity(2 * n, format="csc")
    first, last = n - 2, n - 1
    keep = np.setdiff1d(np.arange(2 * n), [0, 1, 2 * first, 2 * first + 1])
    if kind == "hinged":
        return full[:, keep].tocsr()
    extraction = full[:, keep].tolil()
    for coefficient in (1, last):
        columns = np.flatnonzero(np.isin(keep, [2 * coefficient, 2 * coefficient + 1]))
        tangent = coefficients[coefficient] / np.linalg.norm(coefficients[coefficient])
        extraction[[2 * coefficient, 2 * coefficient + 1], columns[0]] = tangent[:, None]
        extraction[2 * coefficient + 1, columns[1]] = 0.0
        keep = np.delete(keep, columns[1])
        extraction = extraction[:, np.delete(np.arange(extraction.shape[1]), columns[1])]
    return extraction.tocsr()
