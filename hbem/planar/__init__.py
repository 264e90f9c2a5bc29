"""hbem.planar: boundary integrals on polygons, everything analytic in the inner variable.

Names load on first use, so that importing the package costs nothing.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "OuterRule": "polygon",
    "Boundary": "polygon",
    "crossing": "polygon",
    "meeting": "polygon",
    "smallest_gap": "polygon",
    "stokes_layers": "stokes",
    "StokesSystem": "stokes",
    "PlanarStokes": "stokes",
    "laplace_layers": "potential",
    "PotentialSystem": "potential",
    "PlanarPotential": "potential",
    "ContactForce": "contact",
    "PolygonStokes": "polygon_stokes",
}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'hbem.planar' has no attribute {name!r}")
    return getattr(import_module(f"hbem.planar.{_HOME[name]}"), name)
