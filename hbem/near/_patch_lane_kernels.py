"""Compiled polynomials of `LANES` near pairs side by side: positions and tangents of their patches.

A lane is the place of one pair in all arrays. These are flat with the lane innermost
(``[k * LANES + lane]``) and every loop has the constant length `LANES` or one row: only then does
the compiler know that loads and stores do not overlap and makes vector instructions, without
tails and without sums across a vector.
"""

from __future__ import annotations

from numba import njit

LANES = 32


@njit(cache=True, error_model="numpy", nogil=True)
def start(coefficients, y, slope):
    """Begin a Horner sum."""
    for x in range(y.size):
        y[x] = coefficients[x]
        slope[x] = 0.0


@njit(cache=True, error_model="numpy", nogil=True)
def horner(sigma, coefficients, y, slope):
    """One Horner step of a polynomial and its slope on every lane."""
    for x in range(y.size):
        slope[x] = slope[x] * sigma[x] + y[x]
        y[x] = y[x] * sigma[x] + coefficients[x]


@njit(cache=True, error_model="numpy", nogil=True)
def horner_value(sigma, coefficients, y):
    """The same without the slope."""
    for x in range(y.size):
        y[x] = y[x] * sigma[x] + coefficients[x]


@njit(cache=True, error_model="numpy", nogil=True)
def lane(flat, k):
    """Row k of a flat array."""
    return flat[k * LANES : (k + 1) * LANES]


@njit(cache=True, error_model="numpy", nogil=True)
def quadratic_row(shape, tau, y, yt):
    """`row_polynomials` of one component of biquadratic patches."""
    n = LANES
    for x in range(LANES):
        v = tau[x]
        a, b, c = shape[2 * n + x], shape[5 * n + x], shape[8 * n + x]
        d, e, f = shape[n + x], shape[4 * n + x], shape[7 * n + x]
        y[x] = (a * v + d) * v + shape[x]
        y[n + x] = (b * v + e) * v + shape[3 * n + x]
        y[2 * n + x] = (c * v + f) * v + shape[6 * n + x]
        yt[x] = 2.0 * a * v + d
        yt[n + x] = 2.0 * b * v + e
        yt[2 * n + x] = 2.0 * c * v + f


@njit(cache=True, error_model="numpy", nogil=True)
def cubic_row(shape, tau, y, yt):
    """The same for bicubic patches."""
    n = LANES
    for i in range(4):
        o, p = 4 * i * n, i * n
        for x in range(LANES):
            v = tau[x]
            a, b, c = shape[o + 3 * n + x], shape[o + 2 * n + x], shape[o + n + x]
            y[p + x] = ((a * v + b) * v + c) * v + shape[o + x]
            yt[p + x] = (3.0 * a * v + 2.0 * b) * v + c


@njit(cache=True, error_model="numpy", nogil=True)
def row_polynomials(g, shape, tau, row):
    """Coefficients in s of y and y_t at one t per lane: ``row (2, 3, g + 1, LANES)``."""
    n = (g + 1) * LANES
    for c in range(3):
        part = shape[c * n * (g + 1) : (c + 1) * n * (g + 1)]
        y, yt = row[c * n : (c + 1) * n], row[(3 + c) * n : (4 + c) * n]
        if g == 2:
            quadratic_row(part, tau, y, yt)
        elif g == 3:
            cubic_row(part, tau, y, yt)
        else:
            general_row(g, part, tau, y, yt)


@njit(cache=True, error_model="numpy", nogil=True)
def general_row(g, shape, tau, y, yt):
    """The same for any degree."""
    for i in range(g + 1):
        top = i * (g + 1) + g
        start(lane(shape, top), lane(y, i), lane(yt, i))
        for j in range(1, g + 1):
            horner(tau, lane(shape, top - j), lane(y, i), lane(yt, i))


@njit(cache=True, error_model="numpy", nogil=True, inline="always")
def quadratic(target, row, u, x):
    """``x - y``, y_s and y_t of one lane at s = u, biquadratic patch."""
    n = LANES
    y02, y12, y22 = row[2 * n + x], row[5 * n + x], row[8 * n + x]
    y01, y11, y21 = row[n + x], row[4 * n + x], row[7 * n + x]
    return (
        target[x] - ((y02 * u + y01) * u + row[x]),
        target[n + x] - ((y12 * u + y11) * u + row[3 * n + x]),
        target[2 * n + x] - ((y22 * u + y21) * u + row[6 * n + x]),
        2.0 * y02 * u + y01,
        2.0 * y12 * u + y11,
        2.0 * y22 * u + y21,
        (row[11 * n + x] * u + row[10 * n + x]) * u + row[9 * n + x],
        (row[14 * n + x] * u + row[13 * n + x]) * u + row[12 * n + x],
        (row[17 * n + x] * u + row[16 * n + x]) * u + row[15 * n + x],
    )


@njit(cache=True, error_model="numpy", nogil=True, inline="always")
def cubic(target, row, u, x):
    """The same for bicubic patches."""
    n = LANES
    y03, y13, y23 = row[3 * n + x], row[7 * n + x], row[11 * n + x]
    y02, y12, y22 = row[2 * n + x], row[6 * n + x], row[10 * n + x]
    y01, y11, y21 = row[n + x], row[5 * n + x], row[9 * n + x]
    z03, z13, z23 = row[15 * n + x], row[19 * n + x], row[23 * n + x]
    z02, z12, z22 = row[14 * n + x], row[18 * n + x], row[22 * n + x]
    z01, z11, z21 = row[13 * n + x], row[17 * n + x], row[21 * n + x]
    return (
        target[x] - (((y03 * u + y02) * u + y01) * u + row[x]),
        target[n + x] - (((y13 * u + y12) * u + y11) * u + row[4 * n + x]),
        target[2 * n + x] - (((y23 * u + y22) * u + y21) * u + row[8 * n + x]),
        (3.0 * y03 * u + 2.0 * y02) * u + y01,
        (3.0 * y13 * u + 2.0 * y12) * u + y11,
        (3.0 * y23 * u + 2.0 * y22) * u + y21,
        ((z03 * u + z02) * u + z01) * u + row[12 * n + x],
        ((z13 * u + z12) * u + z11) * u + row[16 * n + x],
        ((z23 * u + z22) * u + z21) * u + row[20 * n + x],
    )


@njit(cache=True, error_model="numpy", nogil=True)
def general(g, target, row, sigma, place):
    """``x - y``, y_s and y_t of all lanes, patches of any degree: ``place (9, LANES)``."""
    lift = 3 * (g + 1)
    for c in range(3):
        y, ys, yt = lane(place, c), lane(place, 3 + c), lane(place, 6 + c)
        top = c * (g + 1) + g
        start(lane(row, top), y, ys)
        start(lane(row, lift + top), yt, ys)
        for j in range(1, g + 1):
            horner(sigma, lane(row, top - j), y, ys)
            horner_value(sigma, lane(row, lift + top - j), yt)
        x = lane(target, c)
        for k in range(y.size):
            y[k] = x[k] - y[k]


@njit(cache=True, error_model="numpy", nogil=True)
def bernstein_lanes(degree, nodes, table):
    """Bernstein polynomials at one node of every lane: ``table (degree + 1, LANES)``."""
    n = LANES
    for x in range(LANES):
        table[x] = 1.0
    for k in range(1, degree + 1):
        for x in range(LANES):
            u = nodes[x]
            carry = 0.0
            for i in range(k):
                v = table[i * n + x]
                table[i * n + x] = carry + (1.0 - u) * v
                carry = u * v
            table[k * n + x] = carry
