"""The layers as linear operators on densities: ``A = B^T W (G W B + C_near)``.

Read `layer` (what every single layer offers) and `single_layer` (assembles one), then its forms
`dense_layer`, `direct_layer` on `point_sums`, and `compressed_layer`; `choice` says in numbers
which; `dense_blocks` cuts blocks out of any; `double_layer` is K.
"""
