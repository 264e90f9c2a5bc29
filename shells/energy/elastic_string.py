"""Linear-elastic string ``W = int k/2 (|D theta| - 1)^2 + eps/2 |D^2 theta|^2`` [T 2.22].

Its axial force is k (s - 1) at stretch s, where the Kirchhoff-Love law has k s (s^2 - 1) / 2: the
two differ by 3/2 k (s - 1)^2 and higher powers [T remark 10].
"""

from __future__ import annotations

from typing import final

import numpy as np

from .planar_shell import PlanarMembrane


@final
class ElasticString(PlanarMembrane):
    """A string with a postulated flexural rigidity [T 2.22, 2.23]."""

    def law(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        s = np.sqrt(q)
        return 0.5 * (s - 1.0) ** 2, 1.0 - 1.0 / s, 1.0 / (s * q)
