"""Stokes flow on raw triangulations, against exact drags and tractions.

The flow inside alone (viscosity ratio 0, both layers) has its exact traction on any geometry:
there the solution is compared with the best approximation, element by element as they are. Outside,
exact tractions belong to the smooth body, which patches only approximate.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
from scipy.sparse.linalg import splu

from hbem.accuracy import larger_unknowns
from hbem.flows.enclosed_flow import EnclosedStokes
from hbem.flows.stokes_flow import StokesFlow
from hbem.surfaces.patches import union
from hbem.surfaces.quadrature import QuadratureOrders
from hbem.surfaces.surface_points import SampledSurface

from ...geometry.bodies import torus
from ..honesty.flows.exact import spheroid_moving
from .large_body import large_row
from .raw_bodies import RawBody, raw_ellipsoid, raw_sphere, raw_torus

Row = dict[str, Any]
GEOMETRIES: dict[str, dict[str, Any]] = {
    "quadratic": {"degree": 2},
    "cubic": {"degree": 3},
    "cubic from normals": {"from_normals": True},
    "flat": {"degree": 1},
}
STRAIN = np.array([[1.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, -2.0]])
ALONG = np.array([0.0, 0.0, 1.0])
POLE = np.array([3.5, 1.0, 2.0])  # of a Stokeslet outside all bodies
FORCE = np.array([1.0, -2.0, 0.5])
SMALL = 4000  # unknowns of the larger space up to which the mesh's share is measured
INLET = 0.6  # an enclosed flow's lies above this part of the height


def rows(quick: bool) -> Iterator[Row]:
    """All rows, as they come; ``quick`` takes coarse meshes and no large body."""
    sizes = (100,) if quick else (100, 400)
    for n in sizes:
        body = raw_sphere(n)
        for name, density in product(("quadratic", "cubic", "cubic from normals"), (1, 2)):
            yield sphere_row(body, name, density)
        yield sphere_row(body, "flat", 1)
    for name in ("quadratic", "cubic", "cubic from normals"):
        yield own_row(raw_sphere(50 if quick else 100), name)
    bodies = {
        "raw sphere": raw_sphere(sizes[-1]),
        "raw torus": raw_torus(200 if quick else 400),
        "raw ellipsoid c/a .15": raw_ellipsoid(sizes[-1], 0.15),
    }
    for (case, body), name in product(bodies.items(), GEOMETRIES):
        yield inside_row(f"{case}, flow inside", body, name, 1)
        if name == "quadratic" and not quick:
            yield inside_row(f"{case}, flow inside", body, name, 2)
    for ratio in (0.2, 5.0):
        yield drop_row(bodies["raw sphere"], ratio)
    yield torus_row(bodies["raw torus"])
    for c in (0.15, 0.04):
        for n in sizes:
            yield ellipsoid_row(n, c)
    for n in (100,) if quick else (100, 198, 400):
        yield enclosed_row(n)
    if not quick:
        yield large_row()


def sphere_row(body: RawBody, name: str, density: int, measure: str | None = None) -> Row:
    """Drag and strain traction ``5 E x`` of a raw sphere, and what the solve says of its error."""
    start = time.perf_counter()
    patches = body.patches(density=density, **GEOMETRIES[name])
    flow = StokesFlow(patches, tolerance=1e-2, measure=measure or _measure(body, density))
    drag = flow.traction(ALONG).force()[0, 2] / (6.0 * np.pi)
    found = flow.traction(lambda x: x @ STRAIN)
    seconds = time.perf_counter() - start
    surface = flow.surface
    points = surface.outer.points
    exact = 5.0 * points @ STRAIN
    own = 2.0 * surface.outer.normals @ STRAIN + 3.0 * points @ STRAIN
    error, best = relative_distance(surface, found.values, exact), _best(surface, own)
    return {
        "case": f"raw sphere, strain, {name}, density {density}, {len(body.triangles)} triangles",
        "triangles": len(body.triangles),
        "seconds": seconds,
        "error": error,
        "reference": "5 E x",
        "best, own normals": best,
        "error/best": error / best,
        "drag": drag - 1.0,
        "estimate/error": (found.error.mesh or np.nan) / error,
    }


def own_row(body: RawBody, name: str) -> Row:
    """Strain traction against that of the same patches with densities of degree 5."""
    start = time.perf_counter()
    fine = QuadratureOrders(outer=7)
    sharp = StokesFlow(body.patches(density=5, **GEOMETRIES[name]), orders=fine, measure="none")
    flow = StokesFlow(body.patches(density=2, **GEOMETRIES[name]), measure="none")
    exact = sharp.traction(lambda x: x @ STRAIN).values
    surface = flow.surface.with_points(fine)
    found = surface.basis @ flow.traction(lambda x: x @ STRAIN).coefficients
    error, best = relative_distance(surface, found, exact), _best(surface, exact)
    points, normals = surface.outer.points, surface.outer.normals
    own = 2.0 * normals @ STRAIN + 3.0 * points @ STRAIN
    return {
        "case": f"raw sphere against density 5, {name}, density 2",
        "triangles": len(body.triangles),
        "seconds": time.perf_counter() - start,
        "error": error,
        "reference": "the same patches with densities of degree 5",
        "best": best,
        "error/best": error / best,
        "reference - (2 E n + 3 E x)": relative_distance(surface, own, exact),
    }


def inside_row(case: str, body: RawBody, name: str, density: int) -> Row:
    """Traction of a Stokeslet's flow within a body, by both layers, against the best possible."""
    start = time.perf_counter()
    patches = body.patches(density=density, **GEOMETRIES[name])
    flow = StokesFlow(patches, viscosity_ratio=0.0, tolerance=1e-2, measure="none")
    found = flow.traction(stokeslet).values
    seconds, surface = time.perf_counter() - start, flow.surface
    exact = stokeslet_traction(surface.outer.points, surface.outer.normals)
    level = surface.outer.weights @ np.sum((exact - found) * surface.outer.normals, axis=1)
    exact -= level / surface.outer.weights.sum() * surface.outer.normals
    error, best = relative_distance(surface, found, exact), _best(surface, exact)
    return {
        "case": f"{case}, {name}, density {density}",
        "triangles": len(body.triangles),
        "seconds": seconds,
        "error": error,
        "reference": "a Stokeslet outside",
        "best": best,
        "error/best": error / best,
    }


def drop_row(body: RawBody, ratio: float) -> Row:
    """Strain of a sphere with another viscosity outside, ``2 E n + 3 lambda E x``."""
    start = time.perf_counter()
    flow = StokesFlow(body.patches(), viscosity_ratio=ratio, tolerance=1e-2, measure="none")
    found = flow.traction(lambda x: x @ STRAIN).values
    seconds, surface = time.perf_counter() - start, flow.surface
    points, normals = surface.outer.points, surface.outer.normals
    exact = (2.0 * normals + 3.0 * ratio * points) @ STRAIN
    error, best = relative_distance(surface, found, exact), _best(surface, exact)
    double = flow.formulation.double
    assert double is not None
    return {
        "case": f"raw sphere, strain, quadratic, density 1, viscosity ratio {ratio:g}",
        "triangles": len(body.triangles),
        "seconds": seconds,
        "error": error,
        "reference": "2 E n + 3 lambda E x",
        "best": best,
        "error/best": error / best,
        "Gauss identity": double.gauss_error,
    }


def torus_row(body: RawBody) -> Row:
    """Drag of a torus along its axis against that of exact patches."""
    start = time.perf_counter()
    flow = StokesFlow(body.patches(density=2), tolerance=1e-2, measure="none")
    force = flow.traction(ALONG).force()[0, 2]
    seconds = time.perf_counter() - start
    exact = StokesFlow(torus(12, 16, major=2.0), tolerance=1e-3, measure="none")
    reference = exact.traction(ALONG).force()[0, 2]
    return {
        "case": "raw torus, drag, quadratic, density 2",
        "triangles": len(body.triangles),
        "seconds": seconds,
        "error": abs(force / reference - 1.0),
        "reference": "exact patches",
    }


def ellipsoid_row(n: int, c: float) -> Row:
    """Traction of an oblate ellipsoid that moves edgewise, and what the solve says of its error."""
    start = time.perf_counter()
    body, velocity = raw_ellipsoid(n, c), np.array([1.0, 0.0, 0.0])
    flow = StokesFlow(body.patches(), tolerance=1e-2, measure=_measure(body, 1))
    found = flow.traction(velocity)
    seconds, surface = time.perf_counter() - start, flow.surface
    exact = spheroid_moving(c, velocity, surface.outer.points, surface.outer.normals)
    error, best = relative_distance(surface, found.values, exact), _best(surface, exact)
    force = exact.T @ surface.outer.weights
    return {
        "case": f"raw ellipsoid c/a {c:g}, moving, {len(body.triangles)} triangles",
        "triangles": len(body.triangles),
        "seconds": seconds,
        "error": error,
        "reference": "closed form",
        "best": best,
        "error/best": error / best,
        "drag": found.force()[0, 0] / force[0] - 1.0,
        "quadrature": found.error.quadrature,
        "estimate/error": (found.error.mesh or np.nan) / error,
    }


def enclosed_row(n: int, c: float = 0.35) -> Row:
    """zeta of the flow that fills a bag: a raw ellipsoid with an inlet at its top."""
    start = time.perf_counter()
    body, level = raw_ellipsoid(n, c), INLET * c
    inlet = body.shape(body.corners.mean(axis=1))[:, 2] > level
    patches = union(*(body.part(mask).patches(degree=3) for mask in (~inlet, inlet)))
    flow = EnclosedStokes(
        patches,
        np.sort(inlet),
        lambda x: np.maximum(x[:, 2] - level, 0.0),
        mass_ratio=5e-3,
    )
    assert patches.coefficients is not None
    x = patches.coefficients
    velocity = x * np.maximum(level - x[:, 2:], 0.0)
    operator = flow.assemble(x)
    found = operator.traction(velocity)
    fastest = np.linalg.norm(operator.boundary_velocity(velocity), axis=1).max()
    return {
        "case": f"filling a raw ellipsoid c/a {c:g}, {len(body.triangles)} triangles",
        "triangles": len(body.triangles),
        "seconds": time.perf_counter() - start,
        "error": float(abs(np.ravel(found.zeta)[0])) / fastest,
        "error_kind": "zeta over the largest velocity",
    }


def _measure(body: RawBody, density: int) -> str:
    """What is measured: the mesh's share only where that is cheap."""
    cheap = larger_unknowns(len(body.triangles), density, "triangle") <= SMALL
    return "all" if cheap else "operator"


def stokeslet(x: np.ndarray) -> np.ndarray:
    """Velocity of a Stokeslet at `POLE`, over ``8 pi``."""
    r = x - POLE
    distance = np.linalg.norm(r, axis=1, keepdims=True)
    return FORCE / distance + r * (r @ FORCE)[:, None] / distance**3


def stokeslet_traction(x: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Its traction ``-6 r (r . f) (r . n) / r^5``."""
    r = x - POLE
    along = (r @ FORCE) * np.sum(r * normals, axis=1) / np.linalg.norm(r, axis=1) ** 5
    return -6.0 * r * along[:, None]


def relative_distance(surface: SampledSurface, values: np.ndarray, exact: np.ndarray) -> float:
    """Relative L2 distance of values at the outer points."""
    weights = surface.outer.weights[:, None]
    return float(np.sqrt(np.sum(weights * (values - exact) ** 2) / np.sum(weights * exact**2)))


def _best(surface: SampledSurface, exact: np.ndarray) -> float:
    """Distance of the best approximation."""
    coefficients = splu(surface.mass.tocsc()).solve(surface.project(exact))
    return relative_distance(surface, surface.basis @ coefficients, exact)
