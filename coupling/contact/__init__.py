"""Where sheets come close or meet.

`smallest_gap` measures the gap of facing sheets from samples. `self_intersection` certifies that a
motion meets no contact: it takes the mesh of `sampled_mesh` and the distances of
`triangle_distance`, or the continuous collision detection of ipctk.
"""
