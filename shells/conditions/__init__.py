"""What holds a shell and what pulls at it.

Read `supports` (everything held becomes one sparse extraction E) and `loads` (dead ones are
arrays, those that follow are callables); `edge` integrates along a boundary, `curve_ends` holds
plane curves, `rigid_motions` names the motions that supports leave free. `contact` is what a step
asks of contact forces, whoever makes them.
"""
