"""Near integrals: what plain point sums get wrong where a point is close to an element.

Read `closest_point` (which pairs are near), `near_rules` (polar on the own element, sinh about
the closest point elsewhere), `near_field` (tested, as a sparse matrix) and `rotated_triangles`;
`facing_gap` finds where two walls come closest, `crossing` whether bodies cross or are nested.
"""
