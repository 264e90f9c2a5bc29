"""Readers of mesh files, one small module a format: bytes in, points, cells and groups out.

None is left to a general library: those at hand end the process on unknown elements, take missing
nodes for the last one, or drop all pieces of a grid but its last.
"""
