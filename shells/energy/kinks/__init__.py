"""Shells of continuous triangles: kinks across edges tied by an interior penalty.

``edge_geometry.py`` (frames and kinks at the Gauss points of edges), ``edge_tables.py`` (what the
kernel takes), ``kink_energy.py`` (its energy and variations), ``triangle_shell.py`` (the shell).
"""
