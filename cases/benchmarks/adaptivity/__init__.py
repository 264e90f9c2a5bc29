"""Model adaptivity: `suite.py` (the thesis' loop, effectivity, cost), then ``partitions.py``.

``partitions.py`` has partitioned iterations and the Stokes part by boundary elements; ``views.py``
the tables.
"""
