"""Lowest modes of a structure: vibration about a state, buckling under a load.

Vibration: ``(W'' - p Q'') phi = w^2 M phi``. Buckling, linearised at an unloaded state: the load F
moves it by ``u = K^-1 F`` and changes its tangent by ``G = d/du W'' . u - F'``; loads ``x F`` with
``(K + x G) phi = 0`` are critical. Everything on free coordinates, ``E^T K E``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh, splu

from ..conditions.loads import Follower
from .newton import Solve, factorize
from .structure import ShellStructure

DENSE = 400  # unknowns up to which all modes are computed
STEPS = 300  # restarts of Lanczos' method for buckling
NUDGE = 1e-4  # displacement over length at which the change of the tangent is measured


@dataclass(frozen=True)
class Modes:
    """Modes in ascending order.

    Attributes
    ----------
    values : (n,) array
        Squared angular frequencies, below zero where the state is unstable; or critical
        multiples of the load.
    shapes : (n, n_full, 3) array
        Increments of the configuration, the largest component 1.
    """

    values: np.ndarray
    shapes: np.ndarray


def lowest_modes(
    structure: ShellStructure,
    coefficients: np.ndarray,
    count: int = 6,
    *,
    load: np.ndarray | Follower | None = None,
    pressure: float = 0.0,
) -> Modes:
    """Lowest modes of vibration about a state, or (with a load) of buckling.

    Parameters
    ----------
    structure : ShellStructure
    coefficients : (n_full, 3) array
        Equilibrium about which the structure vibrates; with a load, the unloaded state.
    count : int
        Number of modes.
    load : (n_full, 3) array or callable, optional
        Load whose critical multiples are asked for, as `ShellStructure.static` takes it.
    pressure : float
        Excess pressure in that state, which stays as it is while the structure moves.

    Returns
    -------
    Modes
        Fewer than ``count`` where there are no more; positive multiples of the load only.

    Raises
    ------
    ValueError
        A load on supports only or one without potential (a pressure on edges that move); for
        buckling also a free rigid motion, or a state that is unstable without the load. A
        structure with contact.
    """
    structure.refuse_contact("modes")
    K = _tangent(structure, coefficients, pressure)
    count = min(count, K.shape[0])
    if load is None:
        values, vectors = _smallest(K, structure.M_free, count)
    else:
        structure.mechanism.refuse(dead=not callable(load))
        values, vectors = _critical(structure, coefficients, pressure, load, K, count)
    shapes = (structure.E @ vectors).T.reshape(values.size, *coefficients.shape)
    return Modes(values, shapes / np.abs(shapes).max(axis=(1, 2), keepdims=True, initial=0.0))


def _tangent(structure: ShellStructure, coefficients: np.ndarray, pressure: float) -> csr_matrix:
    c = structure.own(coefficients)
    _, tangent = structure.shell.gradient_and_tangent(c)
    if pressure:
        tangent = tangent - pressure * structure.enclosure.derivatives(c)[2]
    return (structure.E_shell.T @ tangent @ structure.E_shell).tocsr()


def _critical(
    structure: ShellStructure,
    coefficients: np.ndarray,
    pressure: float,
    load: np.ndarray | Follower,
    K: csr_matrix,
    count: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Smallest positive x with a singular ``K + x G``, and its null vectors."""
    force, slope = load(coefficients) if callable(load) else (load, None)
    F = structure.E.T @ force.ravel()
    if not F.any():
        raise ValueError("the load acts on supported coefficients only: it moves nothing")
    if not _pivoted_on_diagonal(K).positive:
        raise ValueError("the state is unstable without the load: there is no load to multiply")
    solve = factorize(K)
    u = structure.expand(solve(F))
    nudge = NUDGE * structure.length / np.abs(u).max()
    ends = [_tangent(structure, coefficients + x * u, pressure) for x in (nudge, -nudge)]
    G = (ends[0] - ends[1]) / (2.0 * nudge)
    if slope is not None:
        slope = structure.E_shell.T @ slope[: structure.n, : structure.n] @ structure.E_shell
        if abs(slope - slope.T).max() > 1e-9 * abs(slope).max():
            raise ValueError(
                "the load has no potential here (its edges move): its critical multiple is no "
                "eigenvalue of a symmetric problem; follow it by shells.load_path"
            )
        G = G - slope
    n = K.shape[0]
    if n <= DENSE:
        inverse, vectors = scipy.linalg.eigh(-G.toarray(), K.toarray())
    else:
        K_inverse = LinearOperator((n, n), matvec=solve, dtype=float)
        try:
            inverse, vectors = eigsh(-G, count, K, which="LA", Minv=K_inverse, maxiter=STEPS)
        except ArpackNoConvergence as stopped:  # none, or no more, stand out from infinity
            inverse, vectors = stopped.eigenvalues, stopped.eigenvectors
    order = np.argsort(-inverse)[:count]
    order = order[inverse[order] > 1e-9 * np.abs(inverse).max(initial=0.0)]  # not at infinity
    return 1.0 / inverse[order], vectors[:, order]


def _smallest(K: csr_matrix, M: csr_matrix, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Algebraically smallest eigenvalues of ``K v = x M v``, and vectors."""
    n = K.shape[0]
    if n <= max(DENSE, 2 * count):
        return scipy.linalg.eigh(K.toarray(), M.toarray(), subset_by_index=(0, count - 1))
    # a shift below all of them leaves no negative pivot (Sylvester): the nearest are the smallest
    shift = -1e-9 * float(K.diagonal().sum() / M.diagonal().sum())
    while not (lu := _pivoted_on_diagonal(K - shift * M)).positive:
        shift *= 4.0
    inverse = LinearOperator((n, n), matvec=lu.solve, dtype=float)
    values, vectors = eigsh(K, count, M, sigma=shift, which="LM", OPinv=inverse)
    order = np.argsort(values)
    return values[order], vectors[:, order]


@dataclass(frozen=True)
class _Pivots:
    solve: Solve
    positive: bool


def _pivoted_on_diagonal(matrix: csr_matrix) -> _Pivots:
    """Factor of a symmetric matrix, and whether it is positive definite."""
    options = {"SymmetricMode": True}
    try:
        lu = splu(
            matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options
        )
    except RuntimeError:  # exactly singular
        return _Pivots(lambda b: b, False)
    on_diagonal = np.array_equal(lu.perm_r, lu.perm_c)
    return _Pivots(lu.solve, on_diagonal and bool((lu.U.diagonal() > 0.0).all()))
