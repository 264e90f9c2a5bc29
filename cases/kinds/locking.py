"""Forecast of membrane locking: the share of a thin shell's bending response that a mesh loses.

Measured on the Scordelis-Lo roof (`airfold bench shells`), the loss depends on ``x = size^2 /
(radius thickness)``, size and radius across the curvature, for each degree and membrane rule;
between measured points it is interpolated in log x. A forecast within a factor of two: on very
coarse meshes (12^2) the roof's own wave length adds to it.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..geometry.bag import Bag

# x and loss of roofs of 16^2, 32^2 (64^2) elements at thickness 0.25, 0.025, 0.0025
MEASURED: Mapping[tuple[int, str], tuple[tuple[float, ...], tuple[float, ...]]] = {
    (2, "gauss"): (
        (0.19, 0.476, 0.76, 1.9, 4.76, 7.6, 19.0, 76.0),
        (0.0012, 0.007, 0.0152, 0.0956, 0.354, 0.521, 0.787, 0.947),
    ),
    (2, "reduced"): (
        (0.19, 0.76, 1.9, 7.6, 19.0, 76.0),
        (0.0009, 0.0088, 0.0319, 0.0888, 0.1055, 0.453),
    ),
    (3, "gauss"): ((0.76, 1.9, 7.6, 19.0, 76.0), (3e-5, 4.3e-4, 0.0285, 0.0916, 0.5685)),
    (3, "reduced"): ((0.76, 1.9, 19.0, 76.0), (1e-5, 2e-5, 6e-5, 0.0242)),
}
LIMIT = 0.05  # loss from which `airfold check` warns


def loss(x: float, degree: int, membrane: str) -> float:
    """Forecast loss at a locking parameter; beyond the measured range response goes as 1 / x."""
    points, values = MEASURED[degree, membrane]
    if x > points[-1]:
        stiffening = x / points[-1] * values[-1] / (1.0 - values[-1])
        return stiffening / (1.0 + stiffening)
    return float(np.interp(np.log(max(x, 1e-300)), np.log(points), values))


def locking_parameter(body: Bag, thickness: float) -> tuple[float, float]:
    """Largest ``size^2 / (radius thickness)`` of the membrane's elements, and that size.

    Flat elements count with the curvature 1 / extent that inflation gives them.
    """
    c = body.coefficients[: body.n_membrane]
    surface, half = body.membrane, np.array([0.5])
    worst, size_there = 0.0, 0.0
    for along in (0, 1):
        ends = []
        for x in (0.1, 0.9):  # the ends themselves may be poles
            place = (np.array([x]), half) if along == 0 else (half, np.array([x]))
            normal = np.cross(*(surface.sample(*place, k) @ c for k in (0, 1)))
            ends.append(normal / np.linalg.norm(normal, axis=1, keepdims=True))
        turn = np.linalg.norm(ends[1] - ends[0], axis=1) / 0.8
        size = np.linalg.norm(surface.sample(half, half, along) @ c, axis=1)
        x = size * np.maximum(turn, size / body.extent) / thickness
        if x.max() > worst:
            worst, size_there = float(x.max()), float(size[x.argmax()])
    return worst, size_there
