"""The orthonormal tangent frame of a reference, and surfaces as seen in it.

In this frame the Gamma-gradients of [T 2.17] are plain derivatives up to ``N;a = G[a, alpha]
N,alpha``; in the identity frame, or in a chart, the same functions give [T 2.8].
"""

from __future__ import annotations

import numpy as np

from ..surfaces.jets import Jets


def frame_transform(reference: Jets) -> np.ndarray:
    """Matrix G with ``N;a = G[a, alpha] N,alpha`` for an orthonormal tangent frame.

    Returns
    -------
    (n_elements, n_points, 2, 2) array
    """
    t0, t1 = reference.grad
    e0 = t0 / np.linalg.norm(t0, axis=-1, keepdims=True)
    normal = reference.normal / np.linalg.norm(reference.normal, axis=-1, keepdims=True)
    e1 = np.cross(normal, e0)
    frame = np.stack([e0, e1], axis=-1)  # columns
    T = np.stack([t0, t1], axis=-2) @ frame
    return np.linalg.inv(T)


def jets_in_frame(
    G: np.ndarray, grad: np.ndarray, hess: np.ndarray, bend: np.ndarray | None = None
) -> np.ndarray:
    """Jets (0, 1, 00, 11, 01) in the frame; leading axes of grad, hess are (d, ..., e, q, c).

    ``bend (n_elements, n_points, 2)`` holds second derivatives of the coordinates in a chart.
    """
    g = np.einsum("eqax,x...eqc->a...eqc", G, grad, optimize=True)
    full = np.stack([np.stack([hess[0], hess[2]]), np.stack([hess[2], hess[1]])])
    h = np.einsum("eqax,eqby,xy...eqc->ab...eqc", G, G, full, optimize=True)
    if bend is not None:
        h[0, 0] += bend[..., 0, None] * grad[0]
        h[1, 1] += bend[..., 1, None] * grad[1]
    return np.stack([g[0], g[1], h[0, 0], h[1, 1], h[0, 1]])


def curvature_in_frame(reference: Jets, shape: Jets) -> np.ndarray:
    """Curvature (B_00, B_11, B_01) of ``shape`` in the tangent frame of ``reference``.

    The stress-free curvature of a folded bag cut from flat cloth: ``shape`` is the flat bag on
    the same parameters.

    Returns
    -------
    (n_elements, n_points, 3) array
    """
    jets = jets_in_frame(frame_transform(reference), shape.grad, shape.hess)
    return fundamental_forms(jets)[1]


def fundamental_forms(shape: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First and second forms (00, 11, 01) from jets (5, n_elements, n_points, 3)."""
    t0, t1, h00, h11, h01 = shape
    normal = np.cross(t0, t1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)

    def dots(pairs: tuple) -> np.ndarray:
        return np.stack([np.einsum("eqc,eqc->eq", a, b) for a, b in pairs], axis=-1)

    first = dots(((t0, t0), (t1, t1), (t0, t1)))
    return first, dots(((h00, normal), (h11, normal), (h01, normal)))
