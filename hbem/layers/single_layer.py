"""Galerkin single layer of Stokes flow on a closed surface [T 3.10a], Re = 1.

``V psi(x) = 1/(8 pi) int (psi / r + r (r . psi) / r^3) dS``, discretised by accurate inner
integrals from outer Gauss points to elements: ``A = B^T W (G W B + C_near)``. The matrix is not
symmetric, and symmetrising it makes the traction ten times worse. ``V n = 0``: tractions are
determined up to a constant pressure, which the constraint ``<tau, n> = 0`` fixes.
"""

from __future__ import annotations

import numpy as np

from ..near.near_field import near_field
from ..surfaces.patches import SurfacePatches
from ..surfaces.quadrature import QuadratureOrders
from ..surfaces.surface_points import SampledSurface, sample
from .choice import STORED_LIMIT, Compression
from .compressed_layer import compressed_single_layer
from .dense_layer import StoredSingleLayer
from .direct_layer import DirectSingleLayer
from .layer import SingleLayer


def single_layer(
    patches: SurfacePatches,
    coefficients: np.ndarray,
    orders: QuadratureOrders | None = None,
    *,
    storage: str = "auto",
    compression: Compression | None = None,
) -> SingleLayer:
    """Assemble the single layer on one configuration.

    Parameters
    ----------
    patches : SurfacePatches
        A closed surface with outward normal ``x_s x x_t``.
    coefficients : (n_coefficients, 3) array
        Its configuration.
    orders : QuadratureOrders, optional
        Default ``QuadratureOrders()``.
    storage : {"auto", "dense", "direct"}
        Store the matrix, or sum the far field directly at every product; ``auto`` stores
        systems up to `STORED_LIMIT` unknowns.
    compression : Compression, optional
        Compress the plain part, unless ``dense`` stores the matrix.

    Returns
    -------
    SingleLayer
        Operator ``(3 n_dofs, 3 n_dofs)``.

    Raises
    ------
    ValueError
        An unknown storage, or coefficients of a wrong shape or not finite.
    MemoryError
        A compressed operator above ``compression.memory``.
    """
    orders = QuadratureOrders() if orders is None else orders
    surface = sample(patches, coefficients, orders)
    return single_layer_on(surface, orders, storage=storage, compression=compression)


def single_layer_on(
    surface: SampledSurface,
    orders: QuadratureOrders,
    *,
    storage: str = "auto",
    compression: Compression | None = None,
) -> SingleLayer:
    """Assemble the single layer on a surface that is sampled already, with the same orders.

    The other parameters and what is raised are those of `single_layer`.
    """
    if storage not in ("auto", "dense", "direct"):
        raise ValueError(f"storage must be 'auto', 'dense' or 'direct', got {storage!r}")
    near = near_field(surface, orders)
    if compression is not None and storage != "dense":
        return compressed_single_layer(surface, near, compression)
    small = 3 * surface.patches.n_dofs <= STORED_LIMIT
    stored = storage == "dense" or (storage == "auto" and small)
    return (StoredSingleLayer if stored else DirectSingleLayer)(surface, near)
