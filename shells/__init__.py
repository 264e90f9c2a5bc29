"""shells: Kirchhoff-Love shells and strings on C1 spline bases, assembled by scikit-fem.

Names load on first use, so that importing the package costs nothing.
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
