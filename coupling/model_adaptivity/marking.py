"""Which Stokes elements become Navier-Stokes elements: greedy, fixed fraction, Doerfler.

All act on magnitudes and on the Stokes part only: signed indicators stall once contributions
cancel, and indicators that leak into the Navier-Stokes part would stop the greedy rule.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

Marking = Literal["greedy", "fraction", "doerfler"]


def mark(
    indicators: np.ndarray, flagged: np.ndarray, rule: Marking, parameter: float
) -> np.ndarray:
    """Choose the Stokes elements that become Navier-Stokes elements.

    Parameters
    ----------
    indicators : (n_elements,) array
    flagged : (n_elements,) bool array
        Navier-Stokes elements.
    rule : {"greedy", "fraction", "doerfler"}
        ``greedy``: at least ``parameter`` times the largest; ``fraction``: the largest ones,
        ``parameter`` times all elements of the mesh; ``doerfler``: the fewest that make up
        ``parameter`` of the sum.
    parameter : float
        In (0, 1].

    Returns
    -------
    (n_elements,) bool array
        Flags of the elements to add.

    Raises
    ------
    ValueError
        A parameter outside (0, 1].
    """
    if not 0.0 < parameter <= 1.0:
        raise ValueError(f"a marking parameter lies in (0, 1], got {parameter}")
    size = np.where(flagged, 0.0, np.abs(indicators))
    if rule == "greedy":
        return (size >= parameter * size.max()) & ~flagged
    order = np.argsort(-size, kind="stable")[: int((~flagged).sum())]
    if rule == "fraction":
        count = int(np.ceil(parameter * size.size))
    else:
        share = np.cumsum(size[order])
        count = int(np.searchsorted(share, parameter * share[-1])) + 1 if share.size else 0
    result = np.zeros(size.size, dtype=bool)
    result[order[:count]] = True
    return result & ~flagged
