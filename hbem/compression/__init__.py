"""Compression of the plain point kernel: H-matrix by cross approximation, H2-matrix by skeletons.

Read `point_kernel` (what is compressed), `cluster_tree` (which clusters are far), `operator`
(products, measured error, build until it is met); then `cross_approximation`, `far_field` and
`hmatrix`, or `nested_bases` and `h2matrix`.
"""
