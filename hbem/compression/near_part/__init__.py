"""The near part of an H2-matrix between density functions: a sparse matrix, see `stored_near`."""
