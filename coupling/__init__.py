"""Structure and fluid advanced together; both are known through the Protocols of `protocols` only.

Read `exchange` (states and loads), `protocols` and `records`, then the floors from below:
`schemes` and `contact`, `stepping`. Beside them stands the question where Stokes flow is enough:
`navier_stokes`, `model_adaptivity`, `partitions`. Names load on first use, so that importing the
package costs nothing.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
