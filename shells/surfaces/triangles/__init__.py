"""Surfaces of continuous Bezier triangles on any triangulation, and their scikit-fem basis."""
