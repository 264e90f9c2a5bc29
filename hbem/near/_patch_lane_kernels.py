"""Compiled polynomials of `LANES` near pairs side by side: patches and functions of their pairs.

A lane is the place of one pair in all arrays. These are flat with the lane innermost
(``[k * LANES + lane]``) and every loop over lanes has the constant length `LANES`, with all that a
lane needs inlined: only then does the compiler make vector instructions, without tails and
without sums across a vector. So degrees are known to it: they are lengths of tuples, ``form =
(powers, functions, layer)`` with as many entries as a patch has powers and a density functions in
one direction, and one entry or none for the double or the single layer.
"""

from __future__ import annotations

from numba import njit

LANES = 16


@njit(cache=True, error_model="numpy", nogil=True, forceinline=True)
def lane(flat, k):
    """Row k of a flat array."""
    return flat[k * LANES : (k + 1) * LANES]


@njit(cache=True, error_model="numpy", nogil=True)
def clear(sums):
    for x in range(sums.size):
        sums[x] = 0.0


@njit(cache=True, error_model="numpy", nogil=True, forceinline=True)
def line_values(powers, coefficients, o, step, u):
    """A polynomial of n coefficients at ``o, o + step, ...`` and its slope."""
    n = len(powers)
    slope = coefficients[o + (n - 1) * step]
    value = slope * u + coefficients[o + (n - 2) * step]
    for i in range(n - 2):
        slope = slope * u + value
        value = value * u + coefficients[o + (n - 3 - i) * step]
    return value, slope


@njit(cache=True, error_model="numpy", nogil=True)
def row_polynomials(form, shape, tau, row):
    """Coefficients in s of y and y_t at one t per lane: ``row (2, 3, g + 1, LANES)``."""
    n = len(form[0])
    for x in range(LANES):
        v = tau[x]
        for i in range(3 * n):
            y, slope = line_values(form[0], shape, i * n * LANES + x, LANES, v)
            row[i * LANES + x], row[(3 * n + i) * LANES + x] = y, slope


@njit(cache=True, error_model="numpy", nogil=True)
def node_table(form, u, w, table):
    """A node of every lane: ``table (m + 1, LANES)`` is ``2 u - 1`` and w times the functions."""
    m = len(form[1])
    for x in range(LANES):
        v, rest = u[x], 1.0 - u[x]
        table[x] = 2.0 * v - 1.0
        table[LANES + x] = w[x]
        for k in range(1, m):
            carry = 0.0
            for i in range(1, k + 1):
                old = table[i * LANES + x]
                table[i * LANES + x] = carry + rest * old
                carry = v * old
            table[(k + 1) * LANES + x] = carry


@njit(cache=True, error_model="numpy", nogil=True)
def exponentials(x, out):
    """``exp(x)``, a Taylor sum of a small number squared eight times: to 5e-14 for ``|x| < 15``."""
    for k in range(x.size):
        z = x[k] * (1.0 / 256.0)
        y = 1.0 + z * (1.0 / 8.0)
        y = 1.0 + z * (1.0 / 7.0) * y
        y = 1.0 + z * (1.0 / 6.0) * y
        y = 1.0 + z * (1.0 / 5.0) * y
        y = 1.0 + z * (1.0 / 4.0) * y
        y = 1.0 + z * (1.0 / 3.0) * y
        y = 1.0 + z * (1.0 / 2.0) * y
        y = 1.0 + z * y
        y *= y
        y *= y
        y *= y
        y *= y
        y *= y
        y *= y
        y *= y
        out[k] = y * y
