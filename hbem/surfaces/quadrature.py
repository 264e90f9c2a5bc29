"""Gauss tables and the orders of every integration rule.

The rule of a (point, element) pair follows from the distance alone: polar on the point's own
element, tensor sinh with ``n_i = a0 + a1 ln(1 / b_i)`` nodes where ``b_i = d / |x_i| <= 1``,
plain Gauss elsewhere. Defaults give tractions accurate to about 1e-5 on fat bodies.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

LARGEST = 48  # nodes per direction of the longest one-dimensional rule


@dataclass(frozen=True)
class QuadratureOrders:
    """Orders of the outer, far, near and self rules.

    Parameters
    ----------
    outer : int
        Gauss points per direction of the outer integral; 3, or 2 for half the cost.
    far : int
        Plain source points per direction; 0 takes the outer points.
    near_offset, near_slope : float
        a0 and a1 of the sinh rule.
    radial, angular : int
        Polar rule per triangle; doubled on elements with a collapsed edge.
    double_offset, double_slope : float
        The same for the double layer, on each side of the closest point.
    near_ball : float
        Points within this many radii of an element's ball are tested for the near rule.

    Raises
    ------
    ValueError
        An order outside 1..48 (doubled polar orders included).
    """

    outer: int = 3
    far: int = 0
    near_offset: float = 6.0
    near_slope: float = 2.8
    radial: int = 8
    angular: int = 10
    near_ball: float = 1.0
    double_offset: float = 6.3
    double_slope: float = 1.9

    def __post_init__(self) -> None:
        counts = (self.outer, self.far or 1, 2 * self.radial, 2 * self.angular)
        if min(counts) < 1 or max(counts) > LARGEST:
            raise ValueError(f"quadrature orders must lie in 1..{LARGEST} (polar: half of it)")
        if self.near_offset < 2.0 or self.near_slope < 0.0 or self.near_ball <= 0.0:
            raise ValueError("near rule: need near_offset >= 2, near_slope >= 0, near_ball > 0")

    @property
    def source(self) -> int:
        """Plain source points per direction."""
        return self.far or self.outer

    def rule(self, layer: int) -> tuple[float, float]:
        """Offset and slope of the sinh rule of a layer.

        Parameters
        ----------
        layer : {0, 1}
            Single or double.

        Returns
        -------
        tuple of two floats
        """
        if layer == 0:
            return self.near_offset, self.near_slope
        return self.double_offset, self.double_slope

    def finer(self) -> QuadratureOrders:
        """The next finer rule, by which the error of this one is measured.

        The outer points stay: both sides of an equation must use the same.

        Returns
        -------
        QuadratureOrders
            Equal to this one where every order is the largest already.
        """
        return replace(
            self,
            far=min(self.source + 1, LARGEST),
            near_offset=self.near_offset + 2.0,
            double_offset=self.double_offset + 2.0,
            radial=min(self.radial + 4, LARGEST // 2),
            angular=min(self.angular + 2, LARGEST // 2),
        )

    @classmethod
    def fast(cls) -> QuadratureOrders:
        """2x2 outer points: half the cost, tractions to about 1e-3."""
        return cls(outer=2, far=3)

    @classmethod
    def fine(cls) -> QuadratureOrders:
        """For gaps of a hundredth of their extent: about twice the cost of the default."""
        return cls(
            near_offset=10.0,
            near_slope=3.8,
            radial=18,
            angular=20,
            double_offset=8.0,
            double_slope=2.6,
        )


@cache
def gauss(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss nodes and weights on [0, 1], ``(n,)`` each."""
    x, w = np.polynomial.legendre.leggauss(n)
    return 0.5 * (x + 1.0), 0.5 * w


@cache
def gauss_tables() -> tuple[np.ndarray, np.ndarray]:
    """Row n holds the n-point rule on [0, 1], zero-padded: two ``(LARGEST + 1,) * 2`` arrays."""
    nodes = np.zeros((LARGEST + 1, LARGEST + 1))
    weights = np.zeros_like(nodes)
    for n in range(1, LARGEST + 1):
        nodes[n, :n], weights[n, :n] = gauss(n)
    return nodes, weights


def gauss_square(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Tensor rule on the unit square: s, t and weights, ``(n * n,)`` each, t fastest."""
    x, w = gauss(n)
    s, t = (g.ravel() for g in np.meshgrid(x, x, indexing="ij"))
    return s, t, np.outer(w, w).ravel()
