"""Cloth that wrinkles: the mylar balloon, the square airbag and a sheared strip.

Closed pillows of rigidity 0 with hinged seams and a tension field; the start is flat, a hundredth
of the length thick. Exact are discs of cloth that neither stretches nor resists wrinkling (Paulsen
1994), here of equal sheet area, and a strip sheared between rigid edges; the airbag's displacement
is that of tension-field and of finely meshed computations in the literature.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from shells.conditions.supports import extraction
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material
from shells.energy.stress import wrinkling
from shells.energy.volume import EnclosedVolume
from shells.equilibrium.minimise import minimise
from shells.equilibrium.structure import ShellStructure
from shells.surfaces.spline_surface import SplineSurface
from shells.surfaces.splines import SplineSpace
from shells.surfaces.surface_basis import SurfaceBasis

from ...geometry.pillows.pillow import PillowBag, round_bag, square_bag
from ..report import Row

THICKNESS = 0.01  # of the flat bags of unit length
SHARE = 1e-4  # of compression that is kept
RADIUS, HEIGHT, VOLUME = 0.7627598, 0.9138932, 1.2185242  # of the mylar balloon, flat radius 1
DIAGONAL, CENTRE = 1.2, 0.216  # m, and the published displacement of the airbag's centre
AIRBAG = (0.4, 5000.0 * DIAGONAL / np.sqrt(2.0) * (1.0 - 0.4**2) / (588e6 * 6e-4))  # nu, p L / C


@dataclass(frozen=True)
class Blown:
    """A pillow under pressure: its sheets' flat area, volume, sizes, wrinkled and slack shares."""

    area: float
    volume: float
    diameter: float
    height: float
    zones: np.ndarray
    iterations: int
    seconds: float


def blown(bag: PillowBag, scale: float, pressure: float, nu: float, membrane: str) -> Blown:
    """Inflate a flat bag, scaled to unit length; stiffness 1."""
    c, surface = scale * bag.coefficients, bag.surface
    basis, start = SurfaceBasis(surface, c), time.perf_counter()
    shell = KirchhoffLove(
        basis,
        Material(0.0, poisson_ratio=nu),
        membrane=membrane,
        compression_share=SHARE,
        hinges=surface.seam,
    )
    structure = ShellStructure(shell, extraction(surface.reduction), EnclosedVolume(basis))
    end = minimise(structure, c, pressure, tolerance=1e-6)
    if not end.ok:
        raise RuntimeError(f"the bag found no equilibrium: {end.failure}")
    seconds, x = time.perf_counter() - start, end.state.coefficients
    corners = np.linspace(0.0, 1.0, 5)
    points = surface.sample(np.repeat(corners, 5), np.tile(corners, 5)) @ x
    size = np.ptp(points, axis=0)
    weights = basis.dx / basis.dx.sum()
    state = wrinkling(shell, x).state
    zones = np.array([weights[state == k].sum() for k in range(3)])
    area = 0.5 * float(basis.dx.sum())
    volume = structure.volume(x)
    return Blown(area, volume, size[0], size[2], zones, end.iterations, seconds)


def balloon(n: int, membrane: str = "gauss") -> tuple[np.ndarray, Blown]:
    """Relative errors of volume, diameter and height of the mylar balloon, p L / C = 1e-3."""
    found = blown(round_bag(n, gap=THICKNESS), 0.5, 1e-3, 0.0, membrane)
    a = np.sqrt(found.area / np.pi)
    exact = np.array([VOLUME * a**3, 2.0 * RADIUS * a, HEIGHT * a])
    return np.array([found.volume, found.diameter, found.height]) / exact - 1.0, found


def airbag(n: int, membrane: str = "gauss") -> tuple[float, Blown]:
    """Height in m of an airbag's centre over its seam's plane: 588 MPa, nu 0.4, 0.6 mm, 5 kPa."""
    nu, pressure = AIRBAG
    found = blown(square_bag(n, gap=THICKNESS), 1.0, pressure, nu, membrane)
    return 0.5 * found.height * DIAGONAL / np.sqrt(2.0), found


def sheared(shear: float, nu: float = 0.3) -> tuple[float, float]:
    """Force on a strip of unit sides sheared between rigid edges, and the exact one; k = 0."""
    space = SplineSpace(np.linspace(0.0, 1.0, 4), 2)
    flat = np.array([[a, b, 0.0] for a in space.greville for b in space.greville])
    mode = flat[:, [1, 2, 2]]  # x grows with y
    basis = SurfaceBasis(SplineSurface(space, space), flat)
    shell = KirchhoffLove(basis, Material(0.0, poisson_ratio=nu), compression_share=0.0)
    root = np.sqrt(1.0 + 0.25 * shear**2)
    e1 = 0.25 * shear**2 + 0.5 * shear * root
    slope = 0.5 * shear + 0.5 * root + shear**2 / (8.0 * root)
    force = float(shell.gradient(flat + shear * mode) @ mode.ravel())
    return force, float((1.0 - nu**2) * e1 * slope)


def cloth_rows(quick: bool) -> list[Row]:
    """Rows of the benchmark."""
    rows: list[Row] = []
    for n in (24, 32) if quick else (24, 32, 48):
        for membrane in ("gauss", "reduced"):
            errors, b = balloon(n, membrane)
            (volume, diameter, height), mesh = errors, f"{n} x {n // 2}, {membrane}"
            rows.append(
                {
                    "case": f"mylar balloon, {mesh}",
                    **_bag(b, abs(float(volume)), "closed form"),
                    "value": f"{b.volume:.5f}",
                    "diameter error": abs(float(diameter)),
                    "height error": abs(float(height)),
                }
            )
            centre, b = airbag(n, membrane)
            error = abs(centre / CENTRE - 1.0)
            row = _bag(b, error, "published, 0.216 m")
            rows.append({"case": f"square airbag, {mesh}", **row, "value": f"{centre:.4f}"})
    for shear in (0.1, 1.0):
        start = time.perf_counter()
        force, exact = sheared(shear)
        rows.append(
            {
                "case": f"wrinkled strip, shear {shear:g}",
                "seconds": time.perf_counter() - start,
                "error": abs(force / exact - 1.0),
                "reference": "closed form",
                "value": f"{force:.5f}",
            }
        )
    return rows


def _bag(b: Blown, error: float, reference: str) -> Row:
    return {
        "seconds": b.seconds,
        "error": error,
        "reference": reference,
        "iterations": b.iterations,
        "wrinkled": float(b.zones[1]),
        "slack": float(b.zones[2]),
    }
