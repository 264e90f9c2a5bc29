"""Energy of kinks over edges, force and tangent; sums of blocks into a matrix.

Functions of an edge come in rows: its own first, then those of the next rows of either side. The
point's formulas are in `_point_kernels`.
"""

import numpy as np
from numba import njit

from ._point_kernels import kink, point_force, point_tangent


@njit(cache=True, error_model="numpy", nogil=True)
def _vectors(trace, beside, dofs, coefficients, fixed, v):
    """t, g1, g2, m1, m2 at one point into v (5, 3); beside (sides, k, 2) holds g and m."""
    for i in range(3):
        v[0, i] = v[1, i] = v[3, i] = v[4, i] = 0.0
        v[2, i] = fixed[i]
    nt, sides = trace.shape[0], beside.shape[0]
    for a in range(nt):
        for i in range(3):
            c = coefficients[dofs[a], i]
            v[0, i] += trace[a, 0] * c
            for s in range(sides):
                v[1 + s, i] += trace[a, 1 + s] * c
                v[3 + s, i] += trace[a, 3 + s] * c
    for s in range(sides):
        for k in range(beside.shape[1]):
            a = nt + s * beside.shape[1] + k
            for i in range(3):
                c = coefficients[dofs[a], i]
                v[1 + s, i] += beside[s, k, 0] * c
                v[3 + s, i] += beside[s, k, 1] * c


@njit(cache=True, error_model="numpy", nogil=True)
def energy(span, dofs, trace, beside, fixed, weights, free, moduli, stiffness, coefficients, out):
    """Energy of each edge into out (n_edges,)."""
    for e in range(span[0], span[1]):
        v, n, J = np.empty((5, 3)), np.empty((2, 3)), np.empty(2)
        total = 0.0
        for q in range(weights.shape[1]):
            _vectors(trace[e, q], beside[e, q], dofs[e], coefficients, fixed[e, q], v)
            theta, moment = kink(v, free[e, q], moduli[e], n, J)
            total += weights[e, q] * theta * (0.5 * stiffness[e] * theta - moment)
        out[e] = total


@njit(cache=True, error_model="numpy", nogil=True)
def kinks(span, dofs, trace, beside, fixed, weights, free, moduli, stiffness, coefficients, theta):
    """Kinks less the stress-free ones into theta (n_edges, n_points)."""
    for e in range(span[0], span[1]):
        v, n, J = np.empty((5, 3)), np.empty((2, 3)), np.empty(2)
        for q in range(weights.shape[1]):
            _vectors(trace[e, q], beside[e, q], dofs[e], coefficients, fixed[e, q], v)
            theta[e, q] = kink(v, free[e, q], moduli[e], n, J)[0]


@njit(cache=True, error_model="numpy", nogil=True)
def _spread(trace, beside, H, w, right, K):
    """``K += w L^T H L`` for rows up to their own block; right (15, 3 m) is scratch."""
    nt, sides, k = trace.shape[0], beside.shape[0], beside.shape[1]
    for x in range(15):
        for b in range(nt):
            for j in range(3):
                total = 0.0
                for y in range(5):
                    total += H[x, 3 * y + j] * trace[b, y]
                right[x, 3 * b + j] = w * total
        for s in range(sides):
            for b in range(k):
                column = 3 * (nt + s * k + b)
                for j in range(3):
                    right[x, column + j] = w * (
                        H[x, 3 * (1 + s) + j] * beside[s, b, 0]
                        + H[x, 3 * (3 + s) + j] * beside[s, b, 1]
                    )
    for a in range(nt):
        for i in range(3):
            row = K[3 * a + i]
            for x in range(5):
                factor, source = trace[a, x], right[3 * x + i]
                for c in range(3 * a + 3):
                    row[c] += factor * source[c]
    for s in range(sides):
        for b in range(k):
            a = nt + s * k + b
            f, h = beside[s, b, 0], beside[s, b, 1]
            for i in range(3):
                row, by_g, by_m = K[3 * a + i], right[3 * (1 + s) + i], right[3 * (3 + s) + i]
                if f == 0.0:
                    for c in range(3 * a + 3):
                        row[c] += h * by_m[c]
                else:
                    for c in range(3 * a + 3):
                        row[c] += f * by_g[c] + h * by_m[c]


@njit(cache=True, error_model="numpy", nogil=True)
def force_and_tangent(
    span,
    dofs,
    trace,
    beside,
    fixed,
    weights,
    free,
    moduli,
    stiffness,
    coefficients,
    tangent,
    R,
    K,
):
    """Variations: first into R (n_edges, 3 m), second into K (n_edges, 3 m, 3 m).

    Of K only rows up to their own block are filled. trace (n_edges, n_points, nt, 5) holds the
    five vectors' parts of the edge's own functions, beside (.., sides, k, 2) g and m of the others;
    fixed (.., 3) is g2 where the edge has one side, else zero.
    """
    nt, sides, k = trace.shape[2], beside.shape[2], beside.shape[3]
    m = dofs.shape[1]
    for e in range(span[0], span[1]):
        v, n, J = np.empty((5, 3)), np.empty((2, 3)), np.empty(2)
        dtheta, dM, slope = np.empty((5, 3)), np.empty((5, 3)), np.empty((5, 3))
        turn = np.empty((2, 4, 3))
        dn, H, right = np.empty((2, 3, 3)), np.empty((5, 3, 5, 3)), np.empty((15, 3 * m))
        flat = H.reshape(15, 15)
        R[e] = 0.0
        if tangent:
            K[e] = 0.0
        for q in range(weights.shape[1]):
            T, B = trace[e, q], beside[e, q]
            _vectors(T, B, dofs[e], coefficients, fixed[e, q], v)
            theta, moment = kink(v, free[e, q], moduli[e], n, J)
            bend, w = stiffness[e] * theta - moment, weights[e, q]
            point_force(v, n, J, moduli[e], dtheta, dM, turn)
            for x in range(5):
                for i in range(3):
                    slope[x, i] = w * (bend * dtheta[x, i] - theta * dM[x, i])
                    for a in range(nt):
                        R[e, 3 * a + i] += slope[x, i] * T[a, x]
            for s in range(sides):
                for b in range(k):
                    for i in range(3):
                        force = slope[1 + s, i] * B[s, b, 0] + slope[3 + s, i] * B[s, b, 1]
                        R[e, 3 * (nt + s * k + b) + i] += force
            if tangent:
                point_tangent(
                    v, n, J, moduli[e], theta, bend, stiffness[e], dtheta, dM, turn, dn, H
                )
                _spread(T, B, flat, w, right, K[e])


@njit(cache=True, error_model="numpy", nogil=True)
def add_blocks(K, start, length, data):
    """Add symmetric matrices, given up to their diagonal blocks, to the data of a CSR matrix.

    K (n, 3 m, 3 m); start (n, m, m) is the entry of each 3 x 3 block's corner, length (n, m) the
    entries of each block row.
    """
    m = start.shape[1]
    for e in range(start.shape[0]):
        for a in range(m):
            for b in range(a + 1):
                here, across = start[e, a, b], start[e, b, a]
                la, lb = length[e, a], length[e, b]
                for i in range(3):
                    for j in range(3):
                        value = K[e, 3 * a + i, 3 * b + j]
                        data[here + i * la + j] += value
                        if b < a:
                            data[across + j * lb + i] += value
