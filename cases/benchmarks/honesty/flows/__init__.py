"""Trials of tractions: what a solve says of its own error, against what it is.

`compressed` against dense matrices, `quadrature` against the finest rule, `spheres` that approach
each other against exact series, and the mesh's share of `smooth` bodies against exact tractions.
"""

from __future__ import annotations

from ..matrices import quiet
from . import compressed, quadrature, smooth, spheres
from .fields import Trial


def trials(quick: bool) -> list[Trial]:
    """All trials, or a reduced set.

    Parameters
    ----------
    quick : bool
        A few of each kind: some seconds.

    Returns
    -------
    list of dict
        ``promise``, ``case``, ``tolerance``, ``error``, ``refused`` (the program said that the
        tolerance is or may be missed), ``share`` ("compression", "quadrature" or "mesh"),
        ``estimate`` (of the same error by the program, NaN if none), ``before`` (estimate over
        error before any correction, NaN if there is none) and ``resolved``: whether the elements
        are smaller than the film that they face.
    """
    with quiet():
        kinds = (compressed, quadrature, spheres, smooth)
        return [trial for kind in kinds for trial in kind.trials(quick)]
