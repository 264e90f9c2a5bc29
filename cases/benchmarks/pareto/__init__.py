"""Error against seconds: five problems, each by mesh, degree, rule and tolerance; defaults marked.

`flows` has a torus, two spheres in a thin film and a folded bag, `bags` the pancake and the roof;
`picture` draws a panel for each.
"""
