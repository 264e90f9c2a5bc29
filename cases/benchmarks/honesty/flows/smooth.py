"""Fat bodies on meshes that resolve them, where the mesh's share is nearly all of the error."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hbem.flows.stokes_flow import StokesFlow
from hbem.flows.surface_traction import SurfaceTraction
from hbem.surfaces.bernstein import tensor_bernstein
from hbem.surfaces.patches import BezierPatches
from hbem.traction_error import Verdict

from ....geometry.bodies import sphere, spheroid
from .exact import sphere_in, spheroid_moving
from .fields import FIELDS, Trial, resolves

TOLERANCES = (1e-2, 1e-3)
SPHERES: dict[int, tuple[int, ...]] = {
    2: (4, 6, 9),
    3: (4, 6, 8),
}  # elements along and around, by degree
SPHEROIDS: dict[int, tuple[int, ...]] = {2: (6, 9), 3: (6, 8)}
AXES = np.eye(3)
C = 0.2  # half height of the spheroids


def trials(quick: bool) -> Iterator[Trial]:
    """Spheres in linear flows, flat spheroids against exact tractions and finer meshes."""
    if quick:
        yield from _spheres(2, 6, (3e-3,), ("shear", "spin"))
        return
    for degree, sizes in SPHERES.items():
        for n in sizes:
            yield from _spheres(degree, n, TOLERANCES, ("squeeze", "spin", "tumble", "shear"))
    for degree, sizes in SPHEROIDS.items():
        for n in sizes:
            yield from _spheroids(degree, n, TOLERANCES, {"slide": 0, "fall": 2})
            yield from _against_finer(degree, n, TOLERANCES[:1], ("squeeze", "shear", "jet"))


def _spheres(
    degree: int, n: int, tolerances: tuple[float, ...], fields: tuple[str, ...]
) -> Iterator[Trial]:
    for tolerance in tolerances:
        flow = StokesFlow(sphere(n, n, degree=degree), tolerance=tolerance)
        for name in fields:
            found = flow.traction(FIELDS[name])
            exact = sphere_in(FIELDS[name](AXES).T, flow.normals)
            yield _trial("sphere", flow, found, _distance(flow, found.values, exact), name)


def _spheroids(
    degree: int, n: int, tolerances: tuple[float, ...], fields: dict[str, int]
) -> Iterator[Trial]:
    for tolerance in tolerances:
        flow = StokesFlow(_spheroid(degree, n), tolerance=tolerance)
        for name, axis in fields.items():
            found = flow.traction(FIELDS[name])
            exact = spheroid_moving(C, AXES[axis], flow.points, flow.normals)
            yield _trial("spheroid", flow, found, _distance(flow, found.values, exact), name)


def _against_finer(
    degree: int, n: int, tolerances: tuple[float, ...], fields: tuple[str, ...]
) -> Iterator[Trial]:
    finer = StokesFlow(
        _spheroid(degree, 2 * n), tolerance=1e-4, compression="dense", measure="none"
    )
    truths = {name: finer.traction(FIELDS[name]).values for name in fields}
    for tolerance in tolerances:
        flow = StokesFlow(_spheroid(degree, n), tolerance=tolerance)
        for name in fields:
            found = flow.traction(FIELDS[name])
            values = _on_finer(flow, found.coefficients, finer, n)
            error = _distance(finer, values, truths[name])
            yield _trial("spheroid, finer mesh", flow, found, error, name)


def _spheroid(degree: int, n: int) -> BezierPatches:
    return spheroid(n, n, c=C, grading=0.5, degree=degree)


def _on_finer(flow: StokesFlow, density: np.ndarray, finer: StokesFlow, n: int) -> np.ndarray:
    """A density at the points of a mesh of twice as many elements along and around."""
    patches, outer = flow.patches, finer.surface.outer
    element = np.repeat(np.arange(patches.n_elements), np.diff(patches.indptr))
    control = np.zeros((patches.n_elements, patches.extraction.shape[1], 3))
    np.add.at(control, element, patches.extraction[:, :, None] * density[patches.dofs, None])
    i, j = np.divmod(np.arange(4 * n * n), 2 * n)
    values = np.empty((4 * n * n, outer.per_element, 3))
    for a in (0, 1):
        for b in (0, 1):
            mine = (i % 2 == a) & (j % 2 == b)
            table = tensor_bernstein(
                patches.density_degree, 0.5 * (a + outer.s), 0.5 * (b + outer.t)
            )
            values[mine] = table @ control[i[mine] // 2 * n + j[mine] // 2]
    return values.reshape(-1, 3)


def _distance(flow: StokesFlow, found: np.ndarray, exact: np.ndarray) -> float:
    """Relative L2 distance of tractions at the points of a flow."""
    w = flow.weights
    off, size = (w @ np.sum(v**2, axis=1) for v in (found - exact, exact))
    return float(np.sqrt(off / size))


def _trial(body: str, flow: StokesFlow, found: SurfaceTraction, error: float, name: str) -> Trial:
    n = round(flow.patches.n_elements**0.5)
    told = found.error
    return {
        "promise": f"traction on a {body}",
        "case": f"{n} x {n}, degree {flow.patches.density_degree}, {name} for {told.tolerance:g}",
        "tolerance": told.tolerance,
        "error": error,
        "refused": told.verdict is not Verdict.MET,
        "share": "mesh",
        "estimate": told.total,
        "before": np.nan,
        "resolved": resolves(flow, told),
    }
