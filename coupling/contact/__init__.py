"""Where sheets come close or meet.

`barrier_contact` carries load by the potential of `potential`, with the numbers that
`contact_numbers` chooses; `crossing` is the test beside it, and `carried` what a history tells.
`smallest_gap` measures the gap of facing sheets from samples, `watch` tells from it when a test is
due. `self_intersection` finds whether a motion of the triangles of `sampled_mesh` meets a contact.
"""
