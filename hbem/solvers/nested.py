"""Preconditioner of a space that contains a smaller one, whose solver serves as its coarse level.

``y = J B J^T v + R v`` with the injection J, an approximate inverse B of the smaller space's saddle
system and inverses R on subdomains: no coarse operator is built. A residual between the two would
save fewer iterations than it costs products.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from .saddle import DenseSaddle, IterativeSaddle
from .saddle_system import SaddleSystem
from .schwarz import SchwarzOptions, local_inverses


@dataclass(frozen=True)
class NestedSchwarz:
    """Schwarz method of a saddle system over the solver of a smaller one.

    Attributes
    ----------
    system : SaddleSystem
    coarse : DenseSaddle or IterativeSaddle
        Of the smaller space.
    injection : (n, n_coarse) sparse matrix
        Scalar densities of the smaller space in the larger one.
    own, subdomains, inverses : lists of arrays
        See `TwoLevelSchwarz`.
    """

    system: SaddleSystem
    coarse: DenseSaddle | IterativeSaddle
    injection: csr_matrix
    own: list[np.ndarray]
    subdomains: list[np.ndarray]
    inverses: list[np.ndarray]

    def __call__(self, v: np.ndarray) -> np.ndarray:
        n = self.system.n
        scale = self.coarse.system.scale / self.system.scale  # of the constraints
        tested = (self.injection.T @ v[:n].reshape(-1, 3)).ravel()
        a = self.coarse.approximate(np.concatenate([tested, scale * v[n:]]))
        density, multipliers = np.split(a, [tested.size])
        spread = (self.injection @ density.reshape(-1, 3)).ravel()
        y = np.concatenate([spread, scale * multipliers])
        for own, around, inverse in zip(self.own, self.subdomains, self.inverses, strict=True):
            y[own] += inverse @ v[around]
        return y


def nested_schwarz(
    system: SaddleSystem, coarse: DenseSaddle | IterativeSaddle, injection: csr_matrix
) -> NestedSchwarz:
    """Build the preconditioner of a saddle system whose operator is a single layer."""
    local = local_inverses(system.operator, SchwarzOptions())
    return NestedSchwarz(system, coarse, injection, *local)
