"""coupling: structure and fluid advanced together; both are known through `protocols` only.

Names load on first use, so that importing the package costs nothing.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
