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

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
