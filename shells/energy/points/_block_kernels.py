"""Element matrices by pairs of components, added to the data of a CSR matrix of 3 x 3 blocks."""

from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def add_blocks(K, start, length, data):
    """Add symmetric matrices K (n, m, 6, m): of components the pairs (i, j) with i <= j.

    start (n, m, m) is the entry of each 3 x 3 block's corner, length (n, m) the entries of each
    block row. Of functions (a, b) and (b, a) equal components are read once: sums are symmetric.
    """
    for e in range(K.shape[0]):
        for a in range(K.shape[1]):
            for b in range(a + 1):
                x, y, z = K[e, a, 0, b], K[e, a, 3, b], K[e, a, 5, b]
                xy, xz, yz = K[e, a, 1, b], K[e, a, 2, b], K[e, a, 4, b]
                yx, zx, zy = K[e, b, 1, a], K[e, b, 2, a], K[e, b, 4, a]
                _add(data, start[e, a, b], length[e, a], x, xy, xz, yx, y, yz, zx, zy, z)
                if b < a:
                    _add(data, start[e, b, a], length[e, b], x, yx, zx, xy, y, zy, xz, yz, z)


@njit(cache=True, error_model="numpy", nogil=True, inline="always")
def _add(data, here, row, a, b, c, d, e, f, g, h, i):
    data[here] += a
    data[here + 1] += b
    data[here + 2] += c
    data[here + row] += d
    data[here + row + 1] += e
    data[here + row + 2] += f
    data[here + 2 * row] += g
    data[here + 2 * row + 1] += h
    data[here + 2 * row + 2] += i
