"""Which form a single layer takes, dense, direct or compressed, in numbers.

``auto`` minimises build time plus products from measured costs: direct sums need no build, H2
builds fastest, ACA applies fastest. Needs no compiled code.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

METHODS = ("aca", "h2")
STORED_LIMIT = 6000  # unknowns up to which the matrix is stored dense
SINGLE = {"aca": 1e-5, "h2": 1e-4}  # tolerances from which single precision is stored
PAIRS = 2e9  # plain kernels summed in a second by one thread
SHARPER = 30.0  # how much sharper than the operator the one is that measures its error
OWN = 0.25  # its own error over that of the operator, the worst measured (usually .01)
MEASUREMENTS = 3  # products with that one, in a solve of its own


@dataclass(frozen=True)
class Compression:
    """How to compress, in numbers.

    Parameters
    ----------
    method : {"aca", "h2"}
    tolerance : float
        Of the matrix, for random and constant densities.
    seed : int
    memory : float, optional
        Bytes that the operator may take.

    Raises
    ------
    ValueError
        An unknown method.
    """

    method: str
    tolerance: float
    seed: int = 0
    memory: float | None = None

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise ValueError(f"compression method {self.method!r} is none of {METHODS}")


def choose(
    method: str,
    tolerances: Mapping[str, float],
    *,
    n_dofs: int,
    n_outer: int,
    n_source: int,
    products: int = 40,
    memory: float | None = None,
    seed: int = 0,
) -> Compression | None:
    """The compression of a run; None for dense or direct.

    ``auto`` takes the method with the least build time plus ``products`` applications.

    Parameters
    ----------
    method : {"auto", "dense", "aca", "h2"}
    tolerances : mapping
        Matrix tolerance of ``"aca"`` and ``"h2"``.
    n_dofs, n_outer, n_source : int
        Density functions, outer and source points.
    products : int
        Applications on one geometry, preconditioner included.
    memory : float, optional
        Bytes that the operator may take.
    seed : int
        Of random rows and densities.

    Returns
    -------
    Compression or None

    Raises
    ------
    ValueError
        An unknown method.
    """
    if method not in ("auto", "dense", "direct", *METHODS):
        raise ValueError(f"compression must be 'auto', 'dense', 'aca' or 'h2', got {method!r}")
    if method == "auto" and 3 * n_dofs <= STORED_LIMIT:
        return None
    if method == "auto":
        costs = costs_of(tolerances, n_dofs, n_outer, n_source, products)
        method = min(costs, key=lambda name: costs[name])
    if method in ("dense", "direct"):
        return None
    tolerance = tolerances[method]
    return Compression(method, tolerance, seed, memory)


def sharper(
    compression: Compression, *, n_dofs: int, n_outer: int, n_source: int
) -> Compression | None:
    """By what the error of a compressed solve is measured; None for exact sums.

    A few products with exact sums, or H2 at a thirtieth of the tolerance, where that costs less:
    measuring stays O(N log N).

    Parameters
    ----------
    compression : Compression
        Of the operator that is solved with.
    n_dofs, n_outer, n_source : int
        Density functions, outer and source points.

    Returns
    -------
    Compression or None
    """
    tolerance = compression.tolerance / SHARPER
    costs = costs_of({"h2": tolerance}, n_dofs, n_outer, n_source, MEASUREMENTS)
    if costs["direct"] <= costs["h2"]:
        return None
    return replace(compression, method="h2", tolerance=tolerance)


def costs_of(
    tolerances: Mapping[str, float], n_dofs: int, n_outer: int, n_source: int, products: int
) -> dict[str, float]:
    """Seconds of each method on one thread: build plus products.

    Measured on disc bags of 1000 to 10000 elements: seconds a function (ACA) or a point (H2),
    growing with the digits of the tolerance.
    """
    costs = {"direct": products * n_outer * n_source / PAIRS}
    digits = {name: -np.log10(tolerance) for name, tolerance in tolerances.items()}
    points = n_outer if n_outer == n_source else n_outer + n_source
    d = digits["h2"]
    build, product = (6e-6, 4.0e-7) if tolerances["h2"] >= 1e-4 else (5e-6, 1.5e-7)
    costs["h2"] = points * (build * d**1.9 + products * product * d**1.35)
    if n_outer == n_source and "aca" in tolerances:
        build, product = 3e-4 * digits["aca"] ** 1.4, 2.5e-7 * digits["aca"] ** 1.5
        costs["aca"] = n_dofs * (build * np.log2(max(n_dofs / 200.0, 2.0)) + products * product)
    return costs


def bytes_of(method: str, tolerance: float, n_dofs: int, n_outer: int, n_source: int) -> float:
    """Memory of a compressed operator before it is built, near field left out.

    Measured on disc bags of 968 to 2592 elements (thinness 0.05, 0.01) and on points: H2 takes
    1.2 kB a point at 1e-3, 1.8 at 1e-4 and, in double precision, 4.1 at 3.5e-5, at any size, and
    the near part 440 functions a function, 340 with two sets of points;
    ACA 4 to 7 kB an unknown, growing with the logarithm of the size.

    Parameters
    ----------
    method : {"aca", "h2"}
    tolerance : float
        Of the matrix.
    n_dofs, n_outer, n_source : int
        Density functions, outer and source points.

    Returns
    -------
    float
        Bytes, right within a factor of 1.5 where it was measured.
    """
    digits, single = -np.log10(tolerance), tolerance >= SINGLE[method]
    if method == "h2":
        points = n_outer if n_outer == n_source else n_outer + n_source
        near = n_dofs * (440.0 if n_outer == n_source else 340.0) * (28.0 if single else 52.0)
        return float(points * (250.0 * digits**1.4 if single else 138.0 * digits**2.27) + near)
    blocks = np.log2(max(n_dofs / 200.0, 2.0))
    return float(3.0 * n_dofs * (1.0 if single else 2.0) * 700.0 * digits**0.6 * blocks)
