"""Model adaptivity: `suite.py` has the thesis' loop and its effectivity and lists the other parts.

``partitions.py`` (partitioned iterations, the Stokes part by boundary elements), ``costs.py``
(strategies side by side), ``picture.py`` (all of it drawn), ``views.py`` (the tables).
"""
