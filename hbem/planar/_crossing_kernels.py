"""Crossings of closed polygons: of one at rest, and on the way from one to another."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def side(p, q, x):
    """Twice the signed area of the triangle p, q, x."""
    return (q[0] - p[0]) * (x[1] - p[1]) - (q[1] - p[1]) * (x[0] - p[0])


@njit(cache=True, error_model="numpy", nogil=True)
def first_crossing(points):
    """Indices of two segments of a closed polygon that cross, or (-1, -1)."""
    n = points.shape[0]
    for i in range(n - 2):
        p, q = points[i], points[i + 1]
        for j in range(i + 2, n - 1 if i == 0 else n):
            r, s = points[j], points[(j + 1) % n]
            if max(p[0], q[0]) < min(r[0], s[0]) or max(r[0], s[0]) < min(p[0], q[0]):
                continue
            if max(p[1], q[1]) < min(r[1], s[1]) or max(r[1], s[1]) < min(p[1], q[1]):
                continue
            if side(p, q, r) * side(p, q, s) <= 0.0 and side(r, s, p) * side(r, s, q) <= 0.0:
                return i, j
    return -1, -1


@njit(cache=True, error_model="numpy", nogil=True)
def meeting(x, dx, p, dp, q, dq):
    """Whether the point x + t dx meets the segment from p + t dp to q + t dq for a t in [0, 1].

    They are in line where a quadratic in t vanishes; then the point must lie between the ends.
    """
    ax, ay, bx, by = q[0] - p[0], q[1] - p[1], x[0] - p[0], x[1] - p[1]
    dax, day, dbx, dby = dq[0] - dp[0], dq[1] - dp[1], dx[0] - dp[0], dx[1] - dp[1]
    c0 = ax * by - ay * bx
    c1 = ax * dby - ay * dbx + dax * by - day * bx
    c2 = dax * dby - day * dbx
    if c1 == 0.0 and c2 == 0.0:
        return False  # the same at all times, and free at the start
    root = c1 * c1 - 4.0 * c2 * c0
    if root < 0.0:
        return False
    s = -0.5 * (c1 + np.copysign(np.sqrt(root), c1))
    for k in range(2):
        over, under = (s, c2) if k == 0 else (c0, s)
        if under == 0.0:
            continue
        t = over / under
        if t < 0.0 or t > 1.0:
            continue
        ux, uy = ax + t * dax, ay + t * day
        along = (bx + t * dbx) * ux + (by + t * dby) * uy
        if 0.0 <= along <= ux * ux + uy * uy:
            return True
    return False


@njit(cache=True, error_model="numpy", nogil=True)
def first_meeting(before, after):
    """A node and a segment that meet while all nodes move straight, or (-1, -1).

    A closed polygon free of crossings first touches itself with a node on a segment.
    """
    n = before.shape[0]
    for j in range(n):
        k = (j + 1) % n
        p, q, dp, dq = before[j], before[k], after[j] - before[j], after[k] - before[k]
        low0 = min(min(p[0], q[0]), min(after[j, 0], after[k, 0]))
        low1 = min(min(p[1], q[1]), min(after[j, 1], after[k, 1]))
        high0 = max(max(p[0], q[0]), max(after[j, 0], after[k, 0]))
        high1 = max(max(p[1], q[1]), max(after[j, 1], after[k, 1]))
        for i in range(n):
            if i in (j, k):
                continue
            x, y = before[i], after[i]
            if max(x[0], y[0]) < low0 or min(x[0], y[0]) > high0:
                continue
            if max(x[1], y[1]) < low1 or min(x[1], y[1]) > high1:
                continue
            if meeting(x, y - x, p, dp, q, dq):
                return i, j
    return -1, -1
