"""Iterative refinement against a sharper operator: a correction measures the error before it.

The residual of a solution is taken with a sharper operator and solved for with the cheap one,
``S d = F - S_sharp x``. To first order d is the error of x, in the norm of the solution and not of
the residual, which in a film hides it: rows of ``A x`` see the film's pressure alone. ``x + d`` is
then better by the factor by which the cheap operator misses the sharp one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .saddle import DenseSaddle, IterativeSaddle
from .saddle_system import SaddleSolution

MOST = 10  # corrections of one solve
INNER = 3e-2  # relative residual of a correction: its size is then known to as much
SLOWER = 3.0  # how much worse the next correction may contract than the last one did


@dataclass(frozen=True)
class Refined:
    """A corrected solution and what the corrections tell.

    Attributes
    ----------
    solved : SaddleSolution
        With all corrections added; its iterations count theirs, its residual is the one that the
        last correction's iteration left.
    estimates : tuple of float
        Size of each correction over that of the solution: the error before it.
    """

    solved: SaddleSolution
    estimates: tuple[float, ...]


def remaining(estimates: tuple[float, ...], own: float = 0.0) -> float:
    """Error left after these corrections.

    Of a single one its own size, an upper bound; of several the last one times its contraction,
    which may be `SLOWER` times worse the next time. Not less than the sharper operator's ``own``
    error, a fraction of the first.
    """
    last = estimates[-1]
    if len(estimates) == 1:
        return last
    left = last * min(1.0, SLOWER * last / max(estimates[-2], 1e-300))
    return max(left, own * estimates[0])


def refine(
    cheap: DenseSaddle | IterativeSaddle,
    residual: Callable[[SaddleSolution], np.ndarray],
    solved: SaddleSolution,
    data: float,
    size: Callable[[np.ndarray], float],
    wanted: float,
    own: float = 0.0,
) -> Refined:
    """Correct a solution until the error left is below ``wanted``, once in any case.

    Parameters
    ----------
    cheap : DenseSaddle or IterativeSaddle
        Solves for the corrections.
    residual : callable
        A solution to the residual ``(3 n,)`` of the sharper system's first rows.
    solved : SaddleSolution
    data : float
        Norm of the right-hand side, which residuals are relative to.
    size : callable
        Norm of a solution ``(3 n,)``.
    wanted : float
        Relative error; it also ends where corrections no longer shrink.
    own : float
        Error of the sharper operator over that of the cheap one: what no correction removes.

    Returns
    -------
    Refined
    """
    estimates: list[float] = []
    while len(estimates) < MOST:
        missing = residual(solved)
        step = cheap.correction(missing, solved.solution, INNER)
        better = replace(
            solved,
            solution=solved.solution + step.solution,
            zeta=solved.zeta + step.zeta,
            result=step.result,
            iterations=solved.iterations + step.iterations,
            residual=step.residual * float(np.linalg.norm(missing)) / data,
        )
        relative = size(step.solution) / max(size(better.solution), 1e-300)
        estimates.append(relative)
        if len(estimates) > 1 and relative > 0.5 * estimates[-2]:
            break  # no longer shrinks: what is left is known, and not small
        solved = better
        if remaining(tuple(estimates)) <= max(wanted, own * estimates[0]):
            break
    return Refined(solved, tuple(estimates))
