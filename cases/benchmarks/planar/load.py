"""Pressure and load of potential flow on refined meshes of one curve, as [T fig. 4.5]."""

from __future__ import annotations

import time

import numpy as np

from hbem.planar.potential import PotentialSystem

from ...kinds.planar import exact
from ...kinds.planar.config import FlatCurve, PlanarMesh
from ...kinds.planar.geometry import pieces
from ..report import Row


def load_functional(n: int, k: int, m: int = 256) -> tuple[np.ndarray, float]:
    """Pressure and load of [T fig. 4.5] on n elements of the pancake's C1 curve.

    The velocity is [T 4.31]; x_1 is the horizontal coordinate, else it does not vanish at the
    hinges. Returns pressures at ``m`` equal parameters and the load tested with sin(k pi s / L).
    """
    curve = pieces(FlatCurve(width=4.0))
    s = curve.nodes(PlanarMesh(uniform=n))
    membrane = curve.at(s)[0]
    r = 1.0 / 3.0
    inlet = np.column_stack([np.linspace(-0.5 * r, 0.5 * r, 17)[1:-1], np.full(15, -2.0 * r)])
    points = np.concatenate([membrane, inlet])
    ends = exact.ends(points)
    u = np.column_stack([np.zeros(len(ends)), 0.3 * (np.abs(ends[:, 0]) - 0.5 * r)])
    u[2 * n :] = 0.0
    system = PotentialSystem(points)
    h = np.einsum("ei,ei->e", u, np.repeat(system.normals, 2, axis=0))
    # no influx: what the membrane displaces leaves through the inlet uniformly
    weight = np.repeat(0.5 * system.lengths, 2)
    h[2 * n :] = -(weight @ h) / weight[2 * n :].sum()
    p = system.pressure(h, system.solve(h)[0])
    p -= (weight @ p) / weight.sum()
    x, w = np.polynomial.legendre.leggauss(4)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    load = 0.0
    for xi, wi in zip(x, w, strict=True):
        at = (1.0 - xi) * p[: 2 * n : 2] + xi * p[1 : 2 * n : 2]
        test = np.sin(k * np.pi * (s[:-1] + xi * np.diff(s)) / s[-1])
        load += wi * float(np.sum(at * test * (system.normals * system.lengths[:, None])[:n, 1]))
    place = (np.arange(m) + 0.5) / m * n
    e = place.astype(int)
    return (1.0 - (place - e)) * p[2 * e] + (place - e) * p[2 * e + 1], load


def rows(quick: bool) -> list[Row]:
    """Rates of pressure and load; k = 2 vanishes by parity: sin(2 pi s/L) is odd, p n_1 even."""
    meshes = [32, 64, 128] if quick else [32, 64, 128, 256]
    finest = 4 * meshes[-1]
    reference = {k: load_functional(finest, k) for k in (1, 2, 3)}
    scale = abs(reference[1][1])
    result, last = [], None
    for n in meshes:
        start = time.process_time()
        found = {k: load_functional(n, k) for k in (1, 2, 3)}
        seconds = time.process_time() - start
        p = reference[1][0]
        errors = [
            float(np.linalg.norm(found[1][0] - p) / np.linalg.norm(p)),
            abs(found[1][1] / reference[1][1] - 1.0),
            abs(found[3][1] / reference[3][1] - 1.0),
        ]
        slopes = (
            [float("nan")] * 3
            if last is None
            else [float(np.log2(a / b)) for a, b in zip(last, errors, strict=True)]
        )
        result.append(
            {
                "case": f"load functional, {n} elements",
                "seconds": seconds,
                "error": errors[1],
                "rate, k=1": slopes[1],
                "rate, k=3": slopes[2],
                "error of p": errors[0],
                "rate of p": slopes[0],
                "load, k=2 over k=1": found[2][1] / scale,
                "_figure": "4.5",
                "_size": 1.0 / n,
                "_errors": errors,
            }
        )
        last = errors
    return result
