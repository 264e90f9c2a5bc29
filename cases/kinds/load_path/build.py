"""The factory of shell scenes: surface, structure, load and the points that history.csv follows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from shells.conditions.loads import Follower, end_moment, line_load
from shells.conditions.supports import clamp, supported
from shells.energy.kirchhoff_love import KirchhoffLove
from shells.energy.material import Material
from shells.equilibrium.load_paths import Path, load_path
from shells.equilibrium.structure import ShellStructure
from shells.surfaces.spline_surface import SplineSurface
from shells.surfaces.splines import SplineSpace
from shells.surfaces.surface_basis import SurfaceBasis

from .config import NEWTON, AnnulusGeometry, EndMoment, LoadPathScene, ShellMesh, StripGeometry


@dataclass(frozen=True)
class LoadPathProblem:
    """What a scene stands for.

    Attributes
    ----------
    shell : KirchhoffLove
    structure : ShellStructure
    start : (n, 3) array
        Unknowns of the unloaded shell: its configuration, or zero displacements.
    load : callable
        Load fraction to what `ShellStructure.static` takes.
    tracked : mapping of (n,) arrays
        Weights of the coefficients at the points that are followed, by name.
    """

    shell: KirchhoffLove
    structure: ShellStructure
    start: np.ndarray
    load: Callable[[float], np.ndarray | Follower]
    tracked: Mapping[str, np.ndarray]

    def displacement(self, coefficients: np.ndarray) -> dict[str, np.ndarray]:
        """Displacements ``(3,)`` of the points that are followed."""
        moved = coefficients - self.start
        return {name: weights @ moved for name, weights in self.tracked.items()}

    def follow(
        self, fractions: Sequence[float], coefficients: np.ndarray | None = None, **options: Any
    ) -> Path:
        """Equilibria at load fractions (see `shells.equilibrium.load_paths.load_path`)."""
        start = self.start if coefficients is None else coefficients
        return load_path(self.structure, start, self.load, fractions, **options)


def problem(scene: LoadPathScene) -> LoadPathProblem:
    """Structure, load and followed points of a scene."""
    c = scene.structure
    surface, flat, source = SHAPES[scene.geometry.kind](scene.geometry, scene.mesh)
    stiffness = c.young_modulus * c.thickness / (1.0 - c.poisson_ratio**2)
    material = Material(c.thickness**2 / 12.0, stiffness, c.poisson_ratio)
    exact = callable(source)
    shell = KirchhoffLove(
        SurfaceBasis(surface, source), material, exact_reference=exact, membrane=c.membrane
    )
    # the second row is held across the shell only: no strain at the clamp is suppressed
    E = supported(surface, clamp(surface, "s", 0, (2,)))
    structure = ShellStructure(shell, E, tolerance=NEWTON)
    start = np.zeros_like(flat) if exact else flat
    return LoadPathProblem(
        shell, structure, start, _load(scene, surface, flat), _tracked(surface, flat, exact)
    )


def _load(
    scene: LoadPathScene, surface: SplineSurface, flat: np.ndarray
) -> Callable[[float], np.ndarray | Follower]:
    load = scene.load
    if isinstance(load, EndMoment):
        return lambda f: end_moment(surface, "s", 1, load.moment * f, flat)
    force = line_load(surface, "s", 1, np.array(load.force), flat)
    return lambda f: f * force


def _tracked(surface: SplineSurface, flat: np.ndarray, corners: bool) -> dict[str, np.ndarray]:
    """Mean of a strip's loaded end; both corners of an annulus' loaded lip."""
    if corners:
        unit = np.eye(len(flat))
        inner, outer = surface.ring(-1)[[0, -1]]
        return {"inner": unit[inner], "outer": unit[outer]}
    weights = line_load(surface, "s", 1, np.array([1.0, 0.0, 0.0]), flat)[:, 0]
    return {"tip": weights / weights.sum()}


def _strip(g: StripGeometry, m: ShellMesh) -> tuple[SplineSurface, np.ndarray, np.ndarray]:
    s = SplineSpace(np.linspace(0.0, g.length, m.along + 1), m.degree)
    t = SplineSpace(np.linspace(0.0, g.width, m.across + 1), m.degree)
    flat = _stack(np.repeat(s.greville, t.n), np.tile(t.greville, s.n), 0.0)
    return SplineSurface(s, t), flat, flat


def _annulus(g: AnnulusGeometry, m: ShellMesh) -> tuple[SplineSurface, np.ndarray, Callable]:
    """Surface, its flat coefficients (for lengths on the straight lip) and its exact jets."""
    s = SplineSpace(np.linspace(0.0, 2.0 * np.pi, m.along + 1), m.degree)
    t = SplineSpace(np.linspace(g.inner, g.outer, m.across + 1), m.degree)

    def jets(a: np.ndarray, r: np.ndarray) -> tuple:
        c, d, zero = np.cos(a), -np.sin(a), 0.0 * a
        return (
            _stack(r * c, r * d, zero),
            (r[..., None] * _stack(d, -c, zero), _stack(c, d, zero)),
            (
                r[..., None] * _stack(-c, -d, zero),
                _stack(zero, zero, zero),
                _stack(d, -c, zero),
            ),
        )

    a, r = np.repeat(s.greville, t.n), np.tile(t.greville, s.n)
    return SplineSurface(s, t), _stack(r * np.cos(a), -r * np.sin(a), 0.0), jets


def _stack(*components: Any) -> np.ndarray:
    return np.stack(np.broadcast_arrays(*components), axis=-1)


SHAPES: Mapping[str, Callable] = {"strip": _strip, "annulus": _annulus}
