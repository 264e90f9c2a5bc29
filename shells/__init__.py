"""shells: Kirchhoff-Love shells and strings on C1 spline bases, assembled by scikit-fem.

Names load on first use, so that importing the package costs nothing.

Examples
--------
A cantilever under a line load, in steps:

>>> import numpy as np
>>> import shells
>>> s = shells.SplineSpace(np.linspace(0.0, 10.0, 17), 3)
>>> t = shells.SplineSpace([0.0, 1.0], 3)
>>> strip = shells.SplineSurface(s, t)
>>> points = np.array([[x, y, 0.0] for x in s.greville for y in t.greville])
>>> shell = shells.KirchhoffLove(shells.SurfaceBasis(strip, points), shells.Material(1e-3))
>>> E = shells.supported(strip, shells.clamp(strip, "s", 0))
>>> force = shells.line_load(strip, "s", 1, [0.0, 0.0, 1e-6], points)
>>> structure = shells.ShellStructure(shell, E)
>>> path = shells.load_path(structure, points, lambda f: f * force, [0.5, 1.0])
>>> path.ok
True
"""

from importlib import import_module
from typing import Any

_HOME = {
    "SplineSpace": "surfaces.splines",
    "SplineSurface": "surfaces.spline_surface",
    "SurfaceBasis": "surfaces.surface_basis",
    "Material": "energy.material",
    "KirchhoffLove": "energy.kirchhoff_love",
    "EnclosedVolume": "energy.volume",
    "extraction": "conditions.supports",
    "ShellStructure": "equilibrium.structure",
    "hinge": "conditions.supports",
    "clamp": "conditions.supports",
    "pin": "conditions.supports",
    "symmetry": "conditions.supports",
    "supported": "conditions.supports",
    "point_load": "conditions.loads",
    "line_load": "conditions.loads",
    "end_moment": "conditions.loads",
    "follower_pressure": "conditions.loads",
    "NeoHookean": "energy.hyperelastic",
    "PointwiseShell": "energy.hyperelastic",
    "OpenVolume": "energy.volume",
    "static_path": "equilibrium.load_paths",
    "load_path": "equilibrium.load_paths",
}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'shells' has no attribute {name!r}")
    return getattr(import_module(f"shells.{_HOME[name]}"), name)
