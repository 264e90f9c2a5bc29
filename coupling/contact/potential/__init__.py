"""What the contact potential is made of.

`barrier` is its function of the distance. `facing_search` finds the triangle that each sample
faces, `barrier_blocks` gives the forces and tangents between them; `obstacle_forces` does so for
the rigid bodies of `obstacles`. `contact_state` is all of it at one configuration.
"""
