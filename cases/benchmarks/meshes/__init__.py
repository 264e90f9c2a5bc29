"""Raw triangulations, as mesh files hold them: `suite.py` lists what is measured.

``raw.py`` (smoothed Delaunay meshes of rectangles and spheres, a third of the vertices with six
neighbours), ``plates.py`` (bending rates), ``shells.py`` (roof, large rotations, inflation, zero
modes, speed), ``flow.py`` (the fluid). ``views.py``: the tables.
"""
