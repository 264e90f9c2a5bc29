"""Pictures of a bag's run, made from its folder alone.

`picture` draws overview.png, `animation` the movie, `loads` what contact and wrinkles do,
`comparison` two runs at the volumes that `equal_volumes` interpolates.
"""
