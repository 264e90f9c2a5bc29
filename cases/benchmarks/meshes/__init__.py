"""Raw triangulations, as mesh files hold them: `suite.py` lists what is measured.

``raw.py`` (smoothed Delaunay meshes of rectangles and spheres, a third of the vertices with six
neighbours), ``plates.py`` (bending rates), ``shells.py`` (roof, large rotations, inflation, zero
modes, speed), ``flow.py`` (the fluid on ``raw_bodies.py``), ``large_body.py`` (1e5 unknowns).
``views.py``: the tables.
"""
