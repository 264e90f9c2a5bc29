"""Shells that are hard to get right: each trial ends near its exact value, or says that it failed.

Clamped strips, oval tubes, cantilevers, restricted strips, balloons, sheets without rigidity and
buckling struts, over degrees 1 to 4, knot multiplicities, knots next to each other and cuts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import product
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix

from shells.conditions.loads import follower_pressure, line_load
from shells.conditions.supports import clamp, extraction, hinge, supported, vector_dofs
from shells.energy.densities import NeoHookean
from shells.energy.hyperelastic import HyperelasticShell
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material
from shells.energy.volume import EnclosedVolume, OpenVolume
from shells.equilibrium.load_paths import load_path
from shells.equilibrium.minimise import minimise
from shells.equilibrium.modes import lowest_modes
from shells.equilibrium.structure import ShellStructure
from shells.surfaces.spline_surface import SplineSurface
from shells.surfaces.splines import SplineSpace
from shells.surfaces.surface_basis import SurfaceBasis

from ...geometry.revolution import sphere

Trial = dict[str, Any]
# What a trial computes: its relative error, or None where the software says that it failed.
Compute = Callable[[], float | None]

LENGTH, RIGIDITY = 10.0, 1e-2
GAPS = (1e-3, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-11, 1e-13)  # of the length, between two knots
ELEMENTS = {1: 32, 2: 32, 3: 16, 4: 12}  # that resolve a tube and a cantilever, by degree
SHEET = {0.0: 0.0638776, 1e-6: 0.0638880}  # lift of a sheet's middle by rigidity, p = 4 on 16^2
SHEAR_TIP = (-3.28954, 6.69989)  # cantilever of Sze, Liu and Lo, p = 4: 4 on 16 and 32 elements


def trials(quick: bool) -> list[Trial]:
    """All trials; ``quick`` takes every sixth.

    Parameters
    ----------
    quick : bool

    Returns
    -------
    list of dict
        Keys ``promise``, ``case``, ``tolerance``, ``error`` (relative; infinite without a
        result), ``refused``: whether the software refused or said that it failed. Not refused
        with an error above the tolerance is a silent violation.
    """
    families = (_strips, _tubes, _cantilevers, _cuts, _halves, _balloons, _sheets, _struts)
    posed = [trial for family in families for trial in family()]
    return [_tried(*trial) for trial in posed[:: 6 if quick else 1]]


def _tried(case: str, tolerance: float, compute: Compute) -> Trial:
    try:
        error = compute()
    except ValueError:  # refusals; any other exception is a fault of its own
        error = None
    return {
        "promise": "right or refused",
        "case": case,
        "tolerance": tolerance,
        "error": math.inf if error is None else float(error),
        "refused": error is None,
    }


def _space(
    degree: int, n: int, middle: int = 1, gap: float = 0.0, knots: bool = False
) -> SplineSpace:
    """``n`` elements; a knot of some multiplicity, or two next to each other, in the middle."""
    breaks = np.linspace(0.0, LENGTH, n + 1)
    multiplicity = np.ones(n + 1, dtype=int)
    multiplicity[n // 2] = middle
    if not gap:
        return SplineSpace(breaks, degree, multiplicity=multiplicity)
    breaks = np.insert(breaks, n // 2 + 1, breaks[n // 2] + gap * LENGTH)
    if not knots:
        return SplineSpace(breaks, degree)
    ends = np.ones(degree)
    return SplineSpace.from_knots(np.r_[0.0 * ends, breaks, LENGTH * ends], degree)


def _flat(s: SplineSpace, elements: np.ndarray | None = None) -> tuple[SplineSurface, np.ndarray]:
    surface = SplineSurface(s, SplineSpace(np.array([0.0, 1.0]), s.degree), elements=elements)
    x, y = np.repeat(s.greville, surface.t.n), np.tile(surface.t.greville, s.n)
    return surface, np.stack([x, y, 0.0 * x], axis=1)[surface.kept]


def _uniform_load(basis: SurfaceBasis, size: float) -> np.ndarray:
    """Coefficients' load of a force per area along z."""
    elements = np.einsum("aeq,eq->ea", basis.values, basis.dx)
    total = np.bincount(basis.surface.element_dofs.ravel(), elements.ravel())
    return size * total[:, None] * np.array([0.0, 0.0, 1.0])


def _bend(
    surface: SplineSurface, c: np.ndarray, ends: tuple[int, ...], at: float, exact: float
) -> float | None:
    """Error of the deflection at s = ``at`` under a load ``1e-8`` per area."""
    basis = SurfaceBasis(surface, c)
    E = supported(surface, *(clamp(surface, "s", end, (2,)) for end in ends))
    structure = ShellStructure(KirchhoffLove(basis, Material(RIGIDITY)), E)
    step = structure.static(c, load=_uniform_load(basis, 1e-8))
    if not step.ok:
        return None
    e = int(np.argmin(np.abs(surface.s.breaks[surface.selected] - at)))
    here = surface.sample(np.zeros(1), np.full(1, 0.5))[e] @ step.state.coefficients
    return abs(float(np.ravel(here)[2]) / (1e-8 * exact / RIGIDITY) - 1.0)


def _knots() -> Iterator[tuple[int, dict[str, Any], str]]:
    """Degree, options of `_space` and words for every middle of a strip."""
    for degree in (1, 2, 3, 4):
        for m in range(1, degree + 1):
            yield degree, {"middle": m}, f"p = {degree}, knot of multiplicity {m}"
    for degree, gap, knots in product((2, 3, 4), GAPS, (False, True)):
        words = "knot vector" if knots else "breaks"
        yield degree, {"gap": gap, "knots": knots}, f"p = {degree}, {words} {gap:g} L apart"


def _strips() -> Iterator[tuple[str, float, Compute]]:
    for degree, options, words in _knots():

        def compute(degree: int = degree, options: dict[str, Any] = options) -> float | None:
            surface, c = _flat(_space(degree, 2 * ELEMENTS[degree], **options))
            return _bend(surface, c, (0, 1), LENGTH / 2.0, LENGTH**4 / 384.0)

        yield f"clamped strip, {words}", 1e-2, compute


def _tubes() -> Iterator[tuple[str, float, Compute]]:
    for degree in (1, 2, 3, 4):
        for m, membrane in product(range(1, degree + 1), ("gauss", "reduced")):

            def compute(degree: int = degree, m: int = m, rule: str = membrane) -> float | None:
                return _oval(degree, m, rule)

            words = f"p = {degree}, quarters of multiplicity {m}, {membrane} points"
            yield f"oval tube under pressure, {words}", 2e-2, compute


def _oval(degree: int, m: int, membrane: str) -> float | None:
    """An oval ring under a third of its critical pressure keeps 3/4 of its amplitude."""
    n, D, amplitude = ELEMENTS[degree], 1e-3, 1e-3
    multiplicity = np.ones(n + 1, dtype=int)
    multiplicity[:: n // 4] = m
    t = SplineSpace(np.linspace(0.0, 2.0 * np.pi, n + 1), degree, True, multiplicity)
    s = SplineSpace(np.array([0.0, 0.5, 1.0]), degree)
    angle = np.linspace(0.0, 2.0 * np.pi, 20 * n, endpoint=False)
    radius = 1.0 + amplitude * np.cos(2.0 * angle)
    ring = t.fit(radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1), angle)
    c = np.column_stack([np.tile(ring, (s.n, 1)), -np.repeat(s.greville, t.n)])
    tie = coo_matrix((np.ones(len(c)), (np.arange(len(c)), np.tile(np.arange(t.n), s.n))))
    basis = SurfaceBasis(SplineSurface(s, t), c)
    E = extraction(tie.tocsr(), vector_dofs(np.arange(len(c)), (2,)))
    shell = KirchhoffLove(basis, Material(D), membrane=membrane)
    end = minimise(ShellStructure(shell, E, OpenVolume(basis)), c, D)
    if not end.ok:
        return None
    x = t.evaluate(angle) @ end.state.coefficients[: t.n, :2]
    x = x - x.mean(axis=0)
    turned = 2.0 * np.arctan2(x[:, 1], x[:, 0])
    waves = np.stack([np.ones_like(turned), np.cos(turned), np.sin(turned)], axis=1)
    found = np.linalg.lstsq(waves, np.hypot(*x.T), rcond=None)[0]
    return abs(math.hypot(found[1], found[2]) / amplitude / 0.75 - 1.0)


def _cantilevers() -> Iterator[tuple[str, float, Compute]]:
    for degree, options, words in _knots():
        if options.get("knots") or options.get("gap", 0.0) > 1e-5:
            continue

        def compute(degree: int = degree, options: dict[str, Any] = options) -> float | None:
            return _shear(*_flat(_space(degree, ELEMENTS[degree], **options)))

        yield f"cantilever under end shear, {words}", 1e-2, compute


def _shear(surface: SplineSurface, c: np.ndarray) -> float | None:
    shell = KirchhoffLove(SurfaceBasis(surface, c), Material(1.0 / 1200.0, 1.2e5))
    force = line_load(surface, "s", 1, [0.0, 0.0, 4.0], c)
    structure = ShellStructure(shell, supported(surface, clamp(surface, "s", 0, (2,))), reuse=0.5)
    path = load_path(structure, c, lambda f: f * force, [0.25, 0.5, 1.0], floor=1e-2)
    if not path.ok:
        return None
    tip = path.state.coefficients[surface.ring(-1)].mean(axis=0)
    moved = tip[0] - LENGTH - SHEAR_TIP[0], tip[2] - SHEAR_TIP[1]
    return math.hypot(*moved) / math.hypot(*SHEAR_TIP)


def _cut(degree: int, width: int) -> tuple[SplineSurface, np.ndarray, float]:
    """A strip without some columns of elements from its middle on, and where it goes on."""
    n = 2 * ELEMENTS[degree]
    left = np.setdiff1d(np.arange(n), n // 2 + np.arange(width))
    return *_flat(_space(degree, n), left), LENGTH * (n // 2 + width) / n


def _cuts() -> Iterator[tuple[str, float, Compute]]:
    """Cantilevers cut in two: the free half has no equilibrium, whatever value is given."""
    for degree, width in product((2, 3, 4), (0, 1, 2, 3, 5)):

        def compute(degree: int = degree, width: int = width) -> float | None:
            surface, c, at = _cut(degree, width)
            moment = at**2 * (6.0 * LENGTH**2 - 4.0 * LENGTH * at + at**2) / 24.0
            error = _bend(surface, c, (0,), at, moment)
            return error if error is None or not width else math.inf

        yield f"cantilever, {width} columns missing, p = {degree}", 1e-2, compute


def _halves() -> Iterator[tuple[str, float, Compute]]:
    """Both ends clamped, columns missing: the second half is a cantilever of its own."""
    for degree, width in product((2, 3, 4), (1, 2, 3)):

        def compute(degree: int = degree, width: int = width) -> float | None:
            surface, c, at = _cut(degree, width)
            return _bend(surface, c, (0, 1), at, (LENGTH - at) ** 4 / 8.0)

        yield f"strip clamped at both ends, {width} columns missing, p = {degree}", 1e-2, compute


def _balloons() -> Iterator[tuple[str, float, Compute]]:
    for (degree, rows), share in product(((2, 8), (3, 4)), (0.5, 0.8, 0.95, 0.98, 1.05, 1.5)):

        def compute(degree: int = degree, rows: int = rows, share: float = share) -> float | None:
            return _balloon(degree, rows, share)

        yield f"balloon of rubber at {share:g} of its limit, p = {degree}", 1e-2, compute


def _balloon(degree: int, rows: int, share: float) -> float | None:
    """Stretch of a neo-Hookean sphere under ``1/2 (1/l - 1/l^7)``, which has a maximum."""
    stretch = np.linspace(1.0, 7.0 ** (1.0 / 6.0), 20001)
    pressure = 0.5 * (1.0 / stretch - 1.0 / stretch**7)
    surface, c = sphere(degree, rows, 2 * rows)
    basis = SurfaceBasis(surface, c)
    shell = HyperelasticShell(basis, NeoHookean(Material(1e-8, poisson_ratio=0.5)))
    structure = ShellStructure(shell, extraction(surface.reduction), EnclosedVolume(basis))
    end = minimise(structure, c, share * pressure[-1])
    if not end.ok:
        return None
    if share > 1.0:
        return math.inf
    found = (structure.volume(end.state.coefficients) / structure.volume(c)) ** (1.0 / 3.0)
    return abs(found / float(np.interp(share * pressure[-1], pressure, stretch)) - 1.0)


def _sheets() -> Iterator[tuple[str, float, Compute]]:
    for rigidity, bulged in product((0.0, 1e-14, 1e-11, 1e-6), (False, True)):

        def compute(rigidity: float = rigidity, bulged: bool = bulged) -> float | None:
            return _sheet(rigidity, bulged)

        start = "a bulge" if bulged else "flat"
        yield f"sheet of rigidity {rigidity:g} under pressure, from {start}", 1e-2, compute


def _sheet(rigidity: float, bulged: bool) -> float | None:
    """Lift of the middle of a hinged unit square under a pressure that follows it."""
    s = SplineSpace(np.linspace(0.0, 1.0, 9), 3)
    square = SplineSurface(s, s)
    x, y = np.repeat(s.greville, s.n), np.tile(s.greville, s.n)
    c = np.stack([x, y, 0.0 * x], axis=1)
    basis = SurfaceBasis(square, c)
    shell = KirchhoffLove(basis, Material(rigidity, poisson_ratio=0.3))
    E = supported(square, *(hinge(square, d, end) for d in "st" for end in (0, 1)))
    start = c + np.outer(x * (1 - x) * y * (1 - y), [0.0, 0.0, 0.5 * bulged])
    step = ShellStructure(shell, E).static(start, load=follower_pressure(basis, 1e-2))
    middle = np.outer(s.evaluate(0.5)[0], s.evaluate(0.5)[0]).ravel()
    exact = SHEET[rigidity if rigidity > 1e-9 else 0.0]
    return abs(middle @ step.state.coefficients[:, 2] / exact - 1.0) if step.ok else None


def _struts() -> Iterator[tuple[str, float, Compute]]:
    for degree, m in ((2, 1), (2, 2), (3, 1), (3, 2), (3, 3), (4, 3)):

        def compute(degree: int = degree, m: int = m) -> float | None:
            surface, c = _flat(_space(degree, 16, m))
            shell = KirchhoffLove(SurfaceBasis(surface, c), Material(1e-4))
            structure = ShellStructure(shell, supported(surface, clamp(surface, "s", 0, (2,))))
            load = line_load(surface, "s", 1, [-1.0, 0.0, 0.0], c)
            found = lowest_modes(structure, c, 1, load=load).values[0]
            return abs(found / (1e-4 * (0.5 * np.pi / LENGTH) ** 2) - 1.0)

        yield f"Euler's strut, p = {degree}, knot of multiplicity {m}", 1e-2, compute
