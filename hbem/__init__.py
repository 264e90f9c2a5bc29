"""hbem: boundary integral operators of Stokes flow on polynomial surface patches.

In the order of the method, which is also the order of the floors: imports go down only, from
flows through solvers, layers, compression and near to surfaces. Beside them stand `accuracy`
(tolerances, above surfaces), `traction` (a result, below all) and `planar`, the same in the plane.
Names load on first use, so that importing the package costs nothing. README.md leads on.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
