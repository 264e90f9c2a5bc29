"""Compiled values and derivatives of one Bezier patch at one point, safe at degree 8."""

from __future__ import annotations

from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def bernstein(degree, x, values, slopes):
    """Bernstein polynomials and their derivatives at one point."""
    y = 1.0 - x
    values[0] = 1.0
    slopes[0] = 0.0
    for k in range(1, degree + 1):
        if k == degree:
            below = 0.0
            for i in range(degree):
                slopes[i] = degree * (below - values[i])
                below = values[i]
            slopes[degree] = degree * below
        carry = 0.0
        for i in range(k):
            v = values[i]
            values[i] = carry + y * v
            carry = x * v
        values[k] = carry


@njit(cache=True, error_model="numpy", nogil=True)
def basis(powers, x, o, table):
    """Bernstein polynomials of degree n - 1, n - 2 and n - 3 at ``o, o + n, o + 2 n`` of a table.

    n is the length of ``powers``: so the compiler knows it.
    """
    n, y = len(powers), 1.0 - x
    table[o + min(2, n - 1) * n] = 1.0
    for k in range(1, n - 2):
        carry = 0.0
        for i in range(k):
            v = table[o + 2 * n + i]
            table[o + 2 * n + i] = carry + y * v
            carry = x * v
        table[o + 2 * n + k] = carry
    for raised in range(2):  # each degree from the one below
        m, low, high = n - 2 + raised, o + (2 - raised) * n, o + (1 - raised) * n
        if m > 0:
            table[high] = y * table[low]
            for i in range(1, m):
                table[high + i] = x * table[low + i - 1] + y * table[low + i]
            table[high + m] = x * table[low + m - 1]


@njit(cache=True, error_model="numpy", nogil=True)
def jet(powers, control, s, t, scratch, out):
    """Position and derivatives s, t, ss, st, tt at one point: ``out (6, 3)``.

    Slopes come from differences of control points: at a collapsed point they are exactly zero.
    ``scratch (9 n,)``, n the length of ``powers``.
    """
    n = len(powers)
    d, dd = n - 1.0, (n - 1.0) * (n - 2.0)
    basis(powers, s, 0, scratch)
    basis(powers, t, 3 * n, scratch)
    for c in range(3):
        for i in range(n):
            v, vt, vtt = 0.0, 0.0, 0.0
            for j in range(n):
                v += scratch[3 * n + j] * control[i, j, c]
            for j in range(n - 1):
                vt += scratch[4 * n + j] * (control[i, j + 1, c] - control[i, j, c])
            for j in range(n - 2):
                bend = (control[i, j + 2, c] - control[i, j + 1, c]) - (
                    control[i, j + 1, c] - control[i, j, c]
                )
                vtt += scratch[5 * n + j] * bend
            scratch[6 * n + i], scratch[7 * n + i], scratch[8 * n + i] = v, vt, vtt
        x, xs, xt, xss, xst, xtt = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(n):
            x += scratch[i] * scratch[6 * n + i]
            xt += scratch[i] * scratch[7 * n + i]
            xtt += scratch[i] * scratch[8 * n + i]
        for i in range(n - 1):
            xs += scratch[n + i] * (scratch[6 * n + i + 1] - scratch[6 * n + i])
            xst += scratch[n + i] * (scratch[7 * n + i + 1] - scratch[7 * n + i])
        for i in range(n - 2):
            bend = (scratch[6 * n + i + 2] - scratch[6 * n + i + 1]) - (
                scratch[6 * n + i + 1] - scratch[6 * n + i]
            )
            xss += scratch[2 * n + i] * bend
        out[0, c], out[1, c], out[2, c] = x, d * xs, d * xt
        out[3, c], out[4, c], out[5, c] = dd * xss, d * d * xst, dd * xtt
