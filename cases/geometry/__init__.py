"""Initial shapes as splines; knows no scenes.

Read `bag.py` (membrane and inlet), `pancake.py` with `revolution.py`, then folded bags: `fold.py`
(plane curves), `folding.py` (maps of the plane), `pillow.py`, `folded.py`, `crumple.py`,
`inspection.py`, `wrinkles.py`. `bodies.py` has exact closed bodies for the boundary integrals
(densities: `body_splines.py`).
"""
