"""Plain point sums of the Stokes kernels: every target with every source, nothing stored.

``u(x) = sum_q G(x - y_q) f_q`` with ``G_ik = (delta_ik / r + r_i r_k / r^3) / 8 pi`` [T 3.10a];
coincident points are skipped. Threaded and vectorised: faster than reading a stored matrix.
"""

from __future__ import annotations

import numpy as np

from .._threads_kernels import over
from . import _point_sum_kernels as kernels

COINCIDENT = 1e-200  # squared distance: only equal positions are nearer, and powers stay numbers


def single_layer_sums(
    targets: np.ndarray, sources: np.ndarray, strengths: np.ndarray, within: float | None = None
) -> np.ndarray:
    """Velocities of point forces.

    Parameters
    ----------
    targets : (n_targets, 3) array
    sources : (n_sources, 3) array
    strengths : (n_sources, 3) or (n_sources, 3, k) array
        Forces, quadrature weights included.
    within : float, optional
        Squared distance up to which a pair counts as coincident.

    Returns
    -------
    (n_targets, 3) or (n_targets, 3, k) array
    """
    within = COINCIDENT if within is None else within
    x, y = pad_to_blocks(targets), np.ascontiguousarray(sources)
    if strengths.ndim == 2:
        out = np.empty_like(x)
        f = np.ascontiguousarray(strengths)
        over(x.shape[0], kernels.single_layer_sums, x, y, f, within, out)
        return np.swapaxes(out, 1, 2).reshape(-1, 3)[: targets.shape[0]]
    k = strengths.shape[2]
    groups = -(-y.shape[0] // kernels.SOURCES)
    f = np.zeros((groups * kernels.SOURCES, 3, k))
    f[: y.shape[0]] = strengths
    f = np.ascontiguousarray(np.swapaxes(f.reshape(groups, -1, k), 1, 2))
    y = y[np.minimum(np.arange(groups * kernels.SOURCES), y.shape[0] - 1)]
    out = np.empty((x.shape[0], k, 3 * kernels.BLOCK))
    y = y.reshape(groups, -1, 3)
    over(x.shape[0], kernels.single_layer_block_sums, x, y, f, within, out)
    out = out.reshape(x.shape[0], k, 3, kernels.BLOCK)
    return out.transpose(0, 3, 2, 1).reshape(-1, 3, k)[: targets.shape[0]]


def pad_to_blocks(points: np.ndarray) -> np.ndarray:
    """Points in blocks of one vector sweep, ``(n_blocks, 3, BLOCK)``; the last point repeats."""
    n = points.shape[0]
    full = np.minimum(np.arange(-(-n // kernels.BLOCK) * kernels.BLOCK), n - 1)
    blocks = points[full].reshape(-1, kernels.BLOCK, 3)
    return np.ascontiguousarray(np.swapaxes(blocks, 1, 2))
