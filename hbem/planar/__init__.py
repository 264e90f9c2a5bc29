"""Boundary integrals in the plane: polygons, inner integrals in closed form."""
