"""Nested dissection for saddle-point systems on any mesh, from element centres alone.

Elements are bisected again and again at the median of their longer extent. An unknown belongs to
the smallest part that holds all its elements: below that, to the separator of a cut. Separators
come after both halves; velocity comes before pressure within each set, so that no pivot vanishes.
"""

from __future__ import annotations

import numpy as np


def dissection(
    element_dofs: np.ndarray, centres: np.ndarray, last: np.ndarray, leaf: int = 8
) -> np.ndarray:
    """Order of elimination with little fill.

    Parameters
    ----------
    element_dofs : (k, n_elements) int array
        Unknowns of each element.
    centres : (n_elements, d) array
    last : (n,) bool array
        Unknowns to come last within their set (pressures).
    leaf : int
        Elements that are not divided any further.

    Returns
    -------
    (n,) int array
        All unknowns in their order.
    """
    depth = max(0, int(np.ceil(np.log2(max(1, centres.shape[0] / leaf)))))
    code = _codes(centres, depth)
    low = np.full(last.size, np.iinfo(np.int64).max)
    high = np.zeros(last.size, dtype=np.int64)
    for dofs in element_dofs:
        np.minimum.at(low, dofs, code)
        np.maximum.at(high, dofs, code)
    # the cut that separates an unknown's elements: leading bits which all their codes share
    below = np.zeros(last.size, dtype=np.int64)
    differ = low ^ high
    for bit in range(depth):
        below[(differ >> bit) > 0] = bit + 1
    end = ((low >> below) + 1) << below  # behind the last leaf of that part
    return np.lexsort((last, below, end))


def _codes(centres: np.ndarray, depth: int) -> np.ndarray:
    """Path of each element through the bisections, as a binary number."""
    code = np.zeros(centres.shape[0], dtype=np.int64)
    parts = [np.arange(centres.shape[0])]
    for _ in range(depth):
        code *= 2
        halves = []
        for part in parts:
            upper = _upper(centres[part])
            code[part[upper]] += 1
            halves += [h for h in (part[~upper], part[upper]) if h.size]
        parts = halves
    return code


def _upper(centres: np.ndarray) -> np.ndarray:
    """The half beyond the median, cut between two layers and never through one."""
    x = centres[:, np.argmax(np.ptp(centres, axis=0))]
    width = np.ptp(x)
    return x > np.median(x) - 1e-6 * width if width > 0.0 else np.zeros(x.size, dtype=bool)
