"""Where sheets come close or meet.

`barrier_contact` carries load: `facing_search` finds the triangle that each sample faces,
`barrier_blocks` gives forces and tangents. `smallest_gap` measures the gap of facing sheets from
samples, `watch` tells from it when a test is due. `self_intersection` finds whether a motion of
the triangles of `sampled_mesh` meets a contact; `crossing` asks less where contact carries load,
and `carried` is what a history tells of it.
"""
