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
    "SplineSpace": "splines",
    "SplineSurface": "surface",
    "SurfaceBasis": "surface_basis",
    "Material": "material",
    "KirchhoffLove": "kirchhoff_love",
    "EnclosedVolume": "volume",
    "extraction": "support",
    "ShellStructure": "dynamics",
    "hinge": "support",
    "clamp": "support",
    "pin": "support",
    "symmetry": "support",
    "supported": "support",
    "point_load": "loads",
    "line_load": "loads",
    "end_moment": "loads",
    "follower_pressure": "loads",
    "NeoHookean": "pointwise",
    "PointwiseShell": "pointwise",
    "OpenVolume": "volume",
    "static_path": "continuation",
    "load_path": "continuation",
}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'shells' has no attribute {name!r}")
    return getattr(import_module(f"shells.{_HOME[name]}"), name)
