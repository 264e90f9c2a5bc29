"""B-spline spaces of one variable: knots, element tables, Bezier extraction, fitting.

A space is given by its breaks, its degree p and the multiplicity m of each interior knot; it is
C^(p-m) there. Open spaces interpolate at both ends; periodic ones wrap. On element e the p + 1
functions that live there are ``N_a = sum_k extraction[e, a, k] B_k`` with Bernstein ``B_k``.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, field
from functools import cached_property
from math import comb

import numpy as np
from numpy.typing import ArrayLike

log = logging.getLogger(__name__)

# Smallest element over the length of its space. Rounding eps of a coefficient is a curvature of
# eps / h^2 on an element of size h, its energy goes like eps^2 / h^3. Measured on a cantilever
# with 2 and 3 knots this near, degrees 2 to 4: errors of 1e-9 at this limit, up to 1.2e-4 at a
# tenth and 8e-2 at a hundredth of it.
RESOLVABLE = 1e-7


def bernstein(degree: int, x: np.ndarray, derivative: int = 0) -> np.ndarray:
    """Bernstein polynomials, or a derivative, at ``x`` in [0, 1]: ``(degree + 1, *x.shape)``."""
    x = np.asarray(x, dtype=float)
    if derivative:
        lower = bernstein(degree - 1, x, derivative - 1) if degree else np.zeros((0, *x.shape))
        padded = np.concatenate([np.zeros((1, *x.shape)), lower, np.zeros((1, *x.shape))])
        return degree * (padded[:-1] - padded[1:])
    k = np.arange(degree + 1).reshape(-1, *([1] * x.ndim))
    binomial = np.array([comb(degree, i) for i in range(degree + 1)], dtype=float)
    return binomial.reshape(k.shape) * x**k * (1.0 - x) ** (degree - k)


def unit_gauss(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points and weights ``(n,)`` on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(n)
    return 0.5 * (x + 1.0), 0.5 * w


def _local_values(knots: np.ndarray, p: int, spans: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The p + 1 functions that live between the knots ``spans`` and the next, at x: Cox, de Boor.

    scipy's are the same; to import them takes longer than all that is worked out here.
    """
    values = np.ones((p + 1, *x.shape))
    for d in range(1, p + 1):
        carried = np.zeros(x.shape)
        for r in range(d):
            below, above = knots[spans + 1 + r - d], knots[spans + 1 + r]
            part = values[r] / (above - below)
            values[r] = carried + (above - x) * part
            carried = (x - below) * part
        values[d] = carried
    return np.moveaxis(values, 0, -1)


@dataclass(frozen=True)
class SplineSpace:
    """Splines of one variable on given breaks.

    Parameters
    ----------
    breaks : (n_elements + 1,) array
        Increasing element boundaries.
    degree : int
        Polynomial degree p >= 1.
    periodic : bool
        Identify both ends.
    multiplicity : (n_elements + 1,) int array, optional
        Knot multiplicity at each break (ends of open spaces are always p + 1); none given: 1.

    Raises
    ------
    ValueError
        Breaks that do not increase or stand nearer than double precision resolves (1e-7 of
        their length), a multiplicity outside 1..p, or a periodic space with fewer than p + 1
        functions (an element would meet one function twice).
    """

    breaks: np.ndarray
    degree: int
    periodic: bool = False
    multiplicity: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=int))

    def __post_init__(self) -> None:
        breaks = np.asarray(self.breaks, dtype=float)
        object.__setattr__(self, "breaks", breaks)
        if self.degree < 1 or breaks.ndim != 1 or breaks.size < 2:
            raise ValueError("a spline space needs degree >= 1 and at least two breaks")
        if np.any(bad := ~(np.diff(breaks) > 0.0)):
            i = int(np.flatnonzero(bad)[0])
            raise ValueError(
                f"breaks must increase: breaks[{i + 1}] = {breaks[i + 1]:g} follows "
                f"{breaks[i]:g}; repeat a knot by multiplicity, or use SplineSpace.from_knots"
            )
        gaps, length = np.diff(breaks), breaks[-1] - breaks[0]
        narrow = int(gaps.argmin())
        if gaps[narrow] < RESOLVABLE * length:
            raise ValueError(
                f"breaks[{narrow}] = {breaks[narrow]:.12g} and breaks[{narrow + 1}] = "
                f"{breaks[narrow + 1]:.12g} are {gaps[narrow] / length:.1e} of the length "
                f"{length:g} apart: below {RESOLVABLE:g} "
                "second derivatives are rounding; make them one break of higher multiplicity "
                "(SplineSpace.from_knots does)"
            )
        m = np.asarray(self.multiplicity, dtype=int)
        m = m if m.size else np.ones(breaks.size, dtype=int)
        inner = m[:-1] if self.periodic else m[1:-1]
        if m.shape != breaks.shape or m.min() < 1 or inner.max(initial=1) > self.degree:
            raise ValueError(f"knot multiplicities must lie in 1..{self.degree}, one a break")
        object.__setattr__(self, "multiplicity", m)
        if self.periodic and m[:-1].sum() < self.degree + 1:
            raise ValueError(
                f"a periodic space of degree {self.degree} needs at least {self.degree + 1} "
                f"elements, got {breaks.size - 1}"
            )

    @classmethod
    def from_knots(cls, knots: np.ndarray, degree: int) -> SplineSpace:
        """Open space of a knot vector.

        Parameters
        ----------
        knots : (n + degree + 1,) array
            With degree + 1 equal knots at each end. Different knots nearer than 1e-7 of the
            length become one (the log says so); their number, hence that of functions, stays.
        degree : int

        Returns
        -------
        SplineSpace

        Raises
        ------
        ValueError
            Knots that decrease, naming the first; ends that are not p + 1 fold; interior knots
            more than p fold, near ones counted together.
        """
        knots = np.asarray(knots, dtype=float)
        if np.any(bad := ~(np.diff(knots) >= 0.0)):
            i = int(np.flatnonzero(bad)[0])
            raise ValueError(
                f"knots must not decrease: knots[{i + 1}] = {knots[i + 1]:g} follows {knots[i]:g}"
            )
        if not knots.size:
            raise ValueError("a knot vector needs knots")
        gaps, near = np.diff(knots), RESOLVABLE * (knots[-1] - knots[0])
        for k in np.flatnonzero((gaps > 0.0) & (gaps < near)):
            log.warning(
                "knots[%d] = %.12g and knots[%d] = %.12g are too near to be resolved: merged",
                *(k, knots[k], k + 1, knots[k + 1]),
            )
        first = np.flatnonzero(np.r_[True, gaps >= max(near, 5e-324)])
        breaks, count = knots[first], np.diff(np.r_[first, knots.size])
        if breaks.size < 2 or count[0] != degree + 1 or count[-1] != degree + 1:
            raise ValueError(f"an open knot vector of degree {degree} has {degree + 1} fold ends")
        count[[0, -1]] = 1
        return cls(breaks, degree, multiplicity=count)

    @property
    def n_elements(self) -> int:
        """Number of elements."""
        return self.breaks.size - 1

    @cached_property
    def knots(self) -> np.ndarray:
        """Knot vector, extended by wrapping for periodic spaces."""
        p = self.degree
        if not self.periodic:
            inner = np.repeat(self.breaks[1:-1], self.multiplicity[1:-1])
            ends = np.ones(p + 1)
            return np.concatenate([self.breaks[0] * ends, inner, self.breaks[-1] * ends])
        period = self.breaks[-1] - self.breaks[0]
        one = np.repeat(self.breaks[:-1], self.multiplicity[:-1])
        reps = p // one.size + 2
        wrapped = np.concatenate([one + k * period for k in range(-reps, reps + 1)])
        first = reps * one.size  # the first knot of the base period
        return wrapped[first - p : first + one.size + p + 1]

    @cached_property
    def n(self) -> int:
        """Number of functions."""
        if self.periodic:
            return int(self.multiplicity[:-1].sum())
        return self.knots.size - self.degree - 1

    @cached_property
    def _spans(self) -> np.ndarray:
        middle = 0.5 * (self.breaks[:-1] + self.breaks[1:])
        return np.searchsorted(self.knots, middle, side="right") - 1

    @cached_property
    def element_dofs(self) -> np.ndarray:
        """Functions of each element, ``(n_elements, p + 1)``."""
        return (self._spans[:, None] - self.degree + np.arange(self.degree + 1)) % self.n

    @cached_property
    def extraction(self) -> np.ndarray:
        """Bezier extraction ``(n_elements, p + 1, p + 1)``: functions to Bernstein."""
        p = self.degree
        x = 0.5 - 0.5 * np.cos(np.pi * (np.arange(p + 1) + 0.5) / (p + 1))
        inverse = np.linalg.inv(bernstein(p, x))
        start = self.breaks[0]  # differences of breaks are exact, their distance to zero is not
        points = self.breaks[:-1, None] - start + x * np.diff(self.breaks)[:, None]
        values = _local_values(self.knots - start, p, self._spans[:, None], points)
        tables = np.swapaxes(values, 1, 2) @ inverse
        tables[np.abs(tables) < 1e-14] = 0.0
        return tables

    @cached_property
    def greville(self) -> np.ndarray:
        """Greville abscissae ``(n,)``: knot averages, where control points belong."""
        p = self.degree
        knots = self.knots
        return np.array([knots[j + 1 : j + p + 1].mean() for j in range(self.n)])

    def evaluate(self, x: ArrayLike, derivative: int = 0) -> np.ndarray:
        """Values or derivatives of all functions.

        Parameters
        ----------
        x : (m,) array or float
        derivative : int
            Its order; 0 for values.

        Returns
        -------
        (m, n) array
            Dense.
        """
        x = np.atleast_1d(np.asarray(x, dtype=float))
        inner = np.searchsorted(self.breaks, x, side="right") - 1
        e = np.clip(inner, 0, self.n_elements - 1)
        h = np.diff(self.breaks)[e]
        local = bernstein(self.degree, (x - self.breaks[e]) / h, derivative) / h**derivative
        rows = np.einsum("iak,ki->ia", self.extraction[e], local)
        out = np.zeros((x.size, self.n))
        np.add.at(out, (np.arange(x.size)[:, None], self.element_dofs[e]), rows)
        return out

    def fit(
        self,
        curve: np.ndarray,
        x: np.ndarray,
        constraints: list[tuple[np.ndarray, np.ndarray]] | None = None,
    ) -> np.ndarray:
        """Least-squares coefficients of samples.

        Parameters
        ----------
        curve : (m, k) array
            Samples.
        x : (m,) array
            Their parameters.
        constraints : list of (row (n,), value (k,)), optional
            ``row @ coefficients = value`` holds exactly; NaN in ``value`` frees that component.

        Returns
        -------
        (n, k) array
        """
        matrix = self.evaluate(x)
        normal = matrix.T @ matrix
        columns = []
        for c in range(curve.shape[1]):
            active = [(r, v[c]) for r, v in constraints or [] if not np.isnan(v[c])]
            rows = np.array([r for r, _ in active]).reshape(len(active), self.n)
            values = np.array([v for _, v in active])
            zero = np.zeros((len(active), len(active)))
            system = np.block([[normal, rows.T], [rows, zero]])
            rhs = np.concatenate([matrix.T @ curve[:, c], values])
            columns.append(np.linalg.lstsq(system, rhs, rcond=None)[0][: self.n])
        return np.stack(columns, axis=1)
