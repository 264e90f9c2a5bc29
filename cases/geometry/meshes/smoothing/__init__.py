"""Facets to Bezier triangles: normals of vertices and fans, control points, exact splits."""
