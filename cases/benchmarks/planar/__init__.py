"""The plane: `suite.py` lists the parts, from integrals alone to whole runs.

``layers.py`` (exact flows, gaps), ``load.py`` (load functional), ``convergence.py`` (space and
time), ``runs.py`` (coupled runs of the scenes), ``models.py`` (Stokes flow beside a uniform
pressure). ``picture.py`` draws all, ``views.py`` holds the tables.
"""
