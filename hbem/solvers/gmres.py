"""Flexible GMRES that stops on the true residual.

Preconditioned directions are stored and combined, ``x = sum_j y_j M^-1 v_j``: in thin gaps the
inverses of subdomains are so large that applying ``M^-1`` to the combination again would lose six
digits. The estimate is checked against ``f - S x``, and the iteration restarted from there until
the true residual meets the tolerance.
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lstsq

Map = Callable[[np.ndarray], np.ndarray]
PROGRESS = 0.5  # a cycle that gains less than this factor has stagnated
STALL = 30  # iterations; below 1e-4, no gain of PROGRESS in as many means rounding: start afresh


class KrylovResult(enum.Enum):
    """How a linear solve ended; the value explains itself."""

    DIRECT = "solved by dense LU factors"
    CONVERGED = "the true residual is below the tolerance"
    ITERATIONS = "the residual is above the tolerance after all iterations; allow more"
    STAGNATED = (
        "rounding keeps the true residual above the tolerance; the gap is too thin for it: "
        "loosen the tolerance or refine the mesh"
    )
    NET_FLUX = (
        "the boundary velocity has a net flux, which an incompressible fluid cannot take up: "
        "subtract it"
    )

    @property
    def ok(self) -> bool:
        """Whether the solution is as accurate as asked."""
        return self in (KrylovResult.DIRECT, KrylovResult.CONVERGED)


@dataclass(frozen=True)
class Krylov:
    """Outcome of an iteration.

    Attributes
    ----------
    x : (n,) array
    result : KrylovResult
    residual : float
        True relative residual.
    history : tuple of float
        Estimated relative residual after each iteration.
    """

    x: np.ndarray
    result: KrylovResult
    residual: float
    history: tuple[float, ...]


def gmres(
    apply: Map,
    precondition: Map,
    rhs: np.ndarray,
    *,
    tolerance: float,
    max_iterations: int,
    restart: int = 200,
    start: np.ndarray | None = None,
) -> Krylov:
    """Solve ``apply(x) = rhs``.

    Parameters
    ----------
    apply, precondition : callable
        ``(n,)`` to ``(n,)``.
    rhs : (n,) array
    tolerance : float
        Bound of ``|rhs - apply(x)| / |rhs|``.
    restart : int
        Directions kept, two vectors each.
    start : (n,) array, optional
        First guess.
    """
    size = np.linalg.norm(rhs)
    x = np.zeros_like(rhs) if start is None else start.copy()
    if size == 0.0:
        return Krylov(np.zeros_like(rhs), KrylovResult.CONVERGED, 0.0, ())
    r = rhs - apply(x) if start is not None else rhs
    residual = float(np.linalg.norm(r) / size)
    history: list[float] = []
    while residual > tolerance:
        left = max_iterations - len(history)
        if left <= 0:
            return Krylov(x, KrylovResult.ITERATIONS, residual, tuple(history))
        # half of the tolerance: the estimate and the true residual differ by rounding
        steps = min(left, restart)
        step, estimates = _cycle(apply, precondition, r, 0.5 * tolerance / residual, steps)
        history += [e * residual for e in estimates]
        new = rhs - apply(x + step)
        gained = float(np.linalg.norm(new) / size)
        if gained < residual:
            x, r = x + step, new
        before, residual = residual, min(gained, residual)
        # a cycle that ended early believed in more than it gained; a full one is only slow
        if residual > tolerance and gained > PROGRESS * before and len(estimates) < steps:
            return Krylov(x, KrylovResult.STAGNATED, residual, tuple(history))
    return Krylov(x, KrylovResult.CONVERGED, residual, tuple(history))


def _cycle(
    apply: Map, precondition: Map, r: np.ndarray, tolerance: float, steps: int
) -> tuple[np.ndarray, list[float]]:
    """One cycle from zero: the correction and the relative residual after each step."""
    beta = np.linalg.norm(r)
    basis, directions, estimates = [r / beta], [], []
    hessenberg = np.zeros((steps + 1, steps))
    y = np.zeros(0)
    for j in range(steps):
        directions.append(precondition(basis[j]))
        w = apply(directions[j])
        scale = np.linalg.norm(w)
        for _ in range(2):  # twice is enough [Giraud et al. 2005]
            for i, v in enumerate(basis):
                h = v @ w
                w = w - h * v
                hessenberg[i, j] += h
        hessenberg[j + 1, j] = np.linalg.norm(w)
        y, estimate = _least_squares(hessenberg[: j + 2, : j + 1])
        estimates.append(estimate)
        stalled = j >= STALL and 1e-4 > estimate > PROGRESS * estimates[j - STALL]
        if estimate <= tolerance or stalled or hessenberg[j + 1, j] <= 1e-15 * scale:
            break
        basis.append(w / hessenberg[j + 1, j])
    step = beta * np.sum([c * d for c, d in zip(y, directions, strict=True)], axis=0)
    return step, estimates


def _least_squares(h: np.ndarray) -> tuple[np.ndarray, float]:
    e = np.zeros(h.shape[0])
    e[0] = 1.0
    y = lstsq(h, e, check_finite=False)[0]
    return y, float(np.linalg.norm(h @ y - e))
