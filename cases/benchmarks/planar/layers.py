"""Planar boundary integrals against exact flows: rates, identities, sizes, narrow gaps."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from hbem.planar.contact import ContactForce
from hbem.planar.polygon import OuterRule, edges, graded, tested
from hbem.planar.potential import PotentialSystem, laplace_layers
from hbem.planar.stokes import StokesSystem, stokes_layers

from ...kinds.planar import exact
from ..report import Row


def rate(sizes: list[float], errors: list[float]) -> float:
    """Slope of log error against log size, least squares."""
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def stokes_error(n: int) -> float:
    """Relative L2 traction error of a quadratic flow in a quadrilateral, interior alone."""
    points = exact.quadrilateral(n)
    x = exact.ends(points)
    u, stress = exact.quadratic_flow(x)
    normals = np.repeat(edges(points)[1], 2, axis=0)
    true = exact.without_normal(points, np.einsum("eij,ej->ei", stress, normals))
    tau, _ = StokesSystem(points).solve(u.reshape(-1, 1))
    return exact.norm(points, tau.reshape(-1, 2) - true) / exact.norm(points, true)


def potential_error(n: int) -> float:
    """Largest nodal error of ``exp(x) cos(y)`` over its range, Neumann data interpolated."""
    points = exact.quadrilateral(n)
    x = exact.ends(points)
    gradient = np.exp(x[:, :1]) * np.column_stack([np.cos(x[:, 1]), -np.sin(x[:, 1])])
    h = np.einsum("ei,ei->e", gradient, np.repeat(edges(points)[1], 2, axis=0))
    phi, _ = PotentialSystem(points).solve(h)
    true = np.exp(points[:, 0]) * np.cos(points[:, 1])
    difference = phi - true
    lengths, _ = edges(points)
    weight = 0.5 * (lengths + np.roll(lengths, 1))
    return float(np.abs(difference - weight @ difference / weight.sum()).max() / np.ptp(true))


def self_errors() -> tuple[float, float, float]:
    """Self blocks of V (Stokes, potential) against double quadrature, and the largest entry of K.

    The outer integral is over [0, 1], the inner one graded to the point from both sides.
    """
    a, b = np.array([0.2, 0.1]), np.array([0.7, -0.3])
    points = np.array([a, b, [1.0, 1.0]])
    V, K = stokes_layers(points)
    assert K is not None
    length = float(np.linalg.norm(b - a))
    t = (b - a) / length
    x, w = graded(120)
    block = np.zeros((2, 2))  # int int N_m(x) N_n(y) log 1/|x - y|
    for xi, wi in zip(x, w, strict=True):
        for reach, sign in ((xi, -1.0), (1.0 - xi, 1.0)):
            y = xi + sign * reach * x
            log = -np.log(reach * x * length) * w * reach
            block += wi * np.outer([1.0 - xi, xi], [log @ (1.0 - y), log @ y])
    block *= length * length
    full = np.einsum("mn,ik->mink", block, np.eye(2))
    full += np.einsum("mn,ik->mink", np.full((2, 2), 0.25 * length**2), np.outer(t, t))
    stokes = full.reshape(4, 4) / (4.0 * np.pi)
    potential = block / (2.0 * np.pi)
    laplace, _ = laplace_layers(points)
    errors = [
        float(np.abs(found / true - 1.0).max())
        for found, true in ((V[:4, :4], stokes), (laplace[:2, :2], potential))
    ]
    return errors[0], errors[1], float(np.abs(K[:4, :4]).max())


def constants_error(rule: OuterRule | None = None) -> tuple[float, float]:
    """``K c + c/2`` of Stokes and potential flow in the L2 norm, relative."""
    points = exact.quadrilateral(8)
    lengths, _ = edges(points)
    one = np.zeros((2 * lengths.size, 2))
    one[:, 0] = 1.0
    _, K = stokes_layers(points, rule=rule)
    _, Kp = laplace_layers(points, rule=rule)
    assert K is not None
    assert Kp is not None
    half = 0.5 * tested(lengths, one)
    stokes = (K @ one.ravel()).reshape(-1, 2) + half
    potential = Kp @ one[:, 0] + half[:, 0]
    scale = np.linalg.norm(half)
    return float(np.linalg.norm(stokes) / scale), float(np.linalg.norm(potential) / scale)


def negative_eigenvalues(radius: float, log_radius: float = 1.0, n: int = 48) -> int:
    """Negative eigenvalues of V on ``<tau, n> = 0`` for a circle; log(s/r) with s."""
    points = exact.circle(radius, n)
    V, _ = stokes_layers(points, double=False, log_radius=log_radius)
    lengths, normals = edges(points)
    b = np.repeat(0.5 * lengths[:, None] * normals, 2, axis=0).ravel()
    complement = np.linalg.svd(b[None])[2][1:].T
    return int(np.sum(np.linalg.eigvalsh(complement.T @ (0.5 * (V + V.T)) @ complement) < 0.0))


def critical_radius(n: int = 48) -> float:
    """Radius of the circle at which V stops being definite, by bisection; exact: sqrt(e)."""
    low, high = 1.4, 1.9
    for _ in range(14):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if negative_eigenvalues(middle, n=n) else (middle, high)
    return 0.5 * (low + high)


def squeeze_load(
    H: float, n: int, rule: OuterRule | None = None, mean: float = 1.0
) -> tuple[float, float]:
    """Load ``int tau_n (mean - x^2)`` on the upper wall: computed and exact [T thm 33].

    With ``mean = 1/3`` it does not see the pressure's level.
    """
    points = exact.slot(H, n)
    x = exact.ends(points)
    u, stress = exact.squeeze_film(x, H)
    lengths, normals = edges(points)
    both = np.repeat(normals, 2, axis=0)
    walls = np.repeat(np.abs(normals[:, 1]) > 0.5, 2)
    u[walls] *= np.array([0.0, 1.0])
    # the outflow's interpolation loses flux: scale it to what the walls displace, 4 in all
    outflow = np.sum((u * both)[~walls] * np.repeat(0.5 * lengths, 2)[~walls, None])
    u[~walls] *= 4.0 / outflow
    tau, _ = StokesSystem(points, rule=rule).solve(u.reshape(-1, 1))
    true = exact.without_normal(points, np.einsum("eij,ej->ei", stress, both))
    upper = np.repeat(normals[:, 1] > 0.5, 2)
    weight = tested(lengths, mean - x[:, 0] ** 2) * upper
    return float(weight @ tau.reshape(-1, 2)[:, 1]), float(weight @ true[:, 1])


def venturi_load(H: float, n: int) -> float:
    """Pressure load ``int p (1 - x^2)`` on a wall of potential flow squeezed out of a slot."""
    points = exact.slot(H, n)
    x = exact.ends(points)
    u = np.column_stack([x[:, 0], -x[:, 1]]) / H
    lengths, normals = edges(points)
    h = np.einsum("ei,ei->e", u, np.repeat(normals, 2, axis=0))
    system = PotentialSystem(points)
    p = system.pressure(h, system.solve(h)[0])
    upper = np.repeat(normals[:, 1] > 0.5, 2)
    return float((tested(lengths, 1.0 - x[:, 0] ** 2) * upper) @ p)


def contact_pressure(gap: float, n: int = 240) -> float:
    """Contact pressure for z = 1 amid two parallel walls of length 2 at a small distance."""
    points = exact.slot(0.5 * gap, n, 2)
    force = ContactForce(1.0, 2.0, 8).tractions(points)
    return float(-force[n // 2, :, 1].mean())  # of the lower wall


def _timed(case: str, function: Any, *args: Any) -> tuple[Row, Any]:
    start = time.process_time()
    value = function(*args)
    return {"case": case, "seconds": time.process_time() - start}, value


def rows(quick: bool) -> list[Row]:
    """All static figures."""
    meshes = [4, 8, 16] if quick else [4, 8, 16, 32]
    result = []
    for name, error, expected in (
        ("Stokes traction", stokes_error, 1.5),
        ("potential", potential_error, 2.0),
    ):
        errors = []
        for n in meshes:
            row, value = _timed(f"{name}, {4 * n} segments", error, n)
            errors.append(value)
            slope = rate([1.0, 0.5], errors[-2:]) if len(errors) > 1 else float("nan")
            result.append(
                {
                    **row,
                    "error": value,
                    "rate": slope,
                    "expected rate": expected,
                    "_figure": name,
                    "_size": 1.0 / (4 * n),
                }
            )
    row, (stokes, potential, double) = _timed("self integrals", self_errors)
    result.append({**row, "error": stokes, "error of potential flow": potential, "K": double})
    row, (stokes, potential) = _timed("K c = -c/2", constants_error)
    result.append({**row, "error": stokes, "error of potential flow": potential})
    result += _sizes()
    result += _gaps(quick)
    return result


def _sizes() -> list[Row]:
    row, found = _timed("critical radius of a circle, kernel log 1/r", critical_radius)
    exact_radius = float(np.sqrt(np.e))
    result = [{**row, "error": abs(found / exact_radius - 1.0), "reference": "sqrt(e)"}]
    for radius in (exact_radius, 2.0, 20.0):
        row, count = _timed(
            f"radius {radius:.3g}, kernel log 100/r", negative_eigenvalues, radius, 100.0
        )
        result.append(
            {
                **row,
                "error": float(count),
                "error_kind": "negative eigenvalues",
                "unscaled": negative_eigenvalues(radius),
            }
        )
    return result


def _gaps(quick: bool) -> list[Row]:
    result = []
    cases = (
        [(0.01, 10), (0.01, 20), (0.001, 10)]
        if quick
        else [(0.1, 20), (0.01, 10), (0.01, 20), (0.01, 40), (0.001, 10), (0.001, 20)]
    )
    for H, n in cases:
        row, (load, true) = _timed(f"squeeze film, H = {H:g}, {n} elements", squeeze_load, H, n)
        plain, _ = squeeze_load(H, n, OuterRule(4, 0))
        result.append(
            {
                **row,
                "error": abs(load / true - 1.0),
                "element/gap": 1.0 / (n * H),
                "error, plain 4 points": plain / true - 1.0,
                "reference": "theorem 33",
            }
        )
    heights = [0.004, 0.008, 0.016]
    loads = [squeeze_load(H, 40, mean=1.0 / 3.0)[0] for H in heights]
    venturi = [-venturi_load(H, 40) for H in heights]
    for case, values, theory in (("lubrication", loads, -3.0), ("Venturi", venturi, -2.0)):
        slope = rate(heights, [abs(v) for v in values])
        result.append(
            {
                "case": f"exponent of {case}",
                "seconds": 0.0,
                "error": abs(slope - theory),
                "error_kind": "absolute",
                "exponent": slope,
                "theory": theory,
                "_figure": case,
                "_curve": [heights, [abs(v) for v in values]],
            }
        )
    for gap in (0.1, 0.03):
        row, value = _timed(f"contact pressure, z = 1, gap {gap:g}", contact_pressure, gap)
        result.append(
            {**row, "error": abs(value / 4.0 - 1.0), "pressure": value, "reference": "bound 4 z"}
        )
    return result
