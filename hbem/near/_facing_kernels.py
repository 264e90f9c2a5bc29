"""Compiled closest points of pairs of patches: projected Newton in four local coordinates.

Alternate projections between two walls converge like ``1 - gap / radius`` a step: useless in thin
gaps, where Newton on both points at once needs five.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ..surfaces._jet_kernels import jet
from ._closest_point_kernels import dot

STEPS = 60  # of Newton, at most
HALVINGS = 14  # of one step
SMALL = 1e-15  # relative decrease of the squared distance that ends the iteration


@njit(cache=True, error_model="numpy", nogil=True)
def difference(powers, first, second, z, scratch, x, y, r):
    """Jets of both patches at ``z = (s, t, u, v)``, ``r = x - y``; returns ``|r|^2``."""
    jet(powers, first, z[0], z[1], scratch, x)
    jet(powers, second, z[2], z[3], scratch, y)
    for c in range(3):
        r[c] = x[0, c] - y[0, c]
    return dot(r, r)


@njit(cache=True, error_model="numpy", nogil=True)
def derivatives(x, y, r, gradient, hessian, scale):
    """Gradient and Hessian of ``|r|^2 / 2``, and the squared speeds ``scale (4,)``."""
    for i in range(2):
        gradient[i] = dot(r, x[1 + i])
        gradient[2 + i] = -dot(r, y[1 + i])
        for j in range(2):
            # jets are ordered ss, st, tt
            hessian[i, j] = dot(x[1 + i], x[1 + j]) + dot(r, x[3 + i + j])
            hessian[2 + i, 2 + j] = dot(y[1 + i], y[1 + j]) - dot(r, y[3 + i + j])
            hessian[i, 2 + j] = -dot(x[1 + i], y[1 + j])
            hessian[2 + j, i] = hessian[i, 2 + j]
        scale[i] = dot(x[1 + i], x[1 + i])
        scale[2 + i] = dot(y[1 + i], y[1 + i])


@njit(cache=True, error_model="numpy", nogil=True)
def factor(matrix, shift, scale, held, lower):
    """Cholesky factor of the Hessian plus a multiple of the scales; False if not positive."""
    for i in range(4):
        for j in range(i + 1):
            v = matrix[i, j]
            if i == j:
                v += shift * scale[i]
            if held[i] or held[j]:
                v = 1.0 if i == j else 0.0
            for k in range(j):
                v -= lower[i, k] * lower[j, k]
            if i == j:
                if held[i]:
                    lower[i, i] = 1.0
                elif v <= 1e-14 * scale[i] or v <= 0.0:
                    return False
                else:
                    lower[i, i] = np.sqrt(v)
            else:
                lower[i, j] = v / lower[j, j]
    return True


@njit(cache=True, error_model="numpy", nogil=True)
def solve(lower, gradient, held, step):
    """``step = -H^-1 gradient`` on the free coordinates."""
    for i in range(4):
        v = 0.0 if held[i] else -gradient[i]
        for k in range(i):
            v -= lower[i, k] * step[k]
        step[i] = v / lower[i, i]
    for i in range(3, -1, -1):
        v = step[i]
        for k in range(i + 1, 4):
            v -= lower[k, i] * step[k]
        step[i] = v / lower[i, i]


@njit(cache=True, error_model="numpy", nogil=True)
def approach(powers, first, second, z, scratch, x, y, r):
    """Move ``z`` to the closest points of two patches near its start; returns the distance."""
    gradient, scale, step, trial = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    hessian, lower, held = np.empty((4, 4)), np.zeros((4, 4)), np.zeros(4, np.bool_)
    square = difference(powers, first, second, z, scratch, x, y, r)
    for _ in range(STEPS):
        derivatives(x, y, r, gradient, hessian, scale)
        floor = 1e-12 * scale.max() + 1e-300
        for i in range(4):
            scale[i] = max(scale[i], floor)
            held[i] = (z[i] <= 0.0 and gradient[i] > 0.0) or (z[i] >= 1.0 and gradient[i] < 0.0)
        shift = 0.0
        while not factor(hessian, shift, scale, held, lower):
            shift = 1e-12 if shift == 0.0 else 10.0 * shift
            if shift > 1e6:
                return np.sqrt(square)
        solve(lower, gradient, held, step)
        size, new = 1.0, square
        for _ in range(HALVINGS):
            for i in range(4):
                trial[i] = min(1.0, max(0.0, z[i] + size * step[i]))
            new = difference(powers, first, second, trial, scratch, x, y, r)
            if new < square:
                break
            size *= 0.5
        if not new < square:
            difference(powers, first, second, z, scratch, x, y, r)
            break
        z[:] = trial
        done = square - new <= SMALL * square
        square = new
        if done or square == 0.0:
            break
    return np.sqrt(square)


@njit(cache=True, error_model="numpy", nogil=True)
def approach_all(span, powers, control, first, second, z, distance):
    """Closest points of pairs of elements from the starts ``z (n, 4)``, which are overwritten."""
    scratch, r = np.empty(9 * len(powers)), np.empty(3)
    x, y = np.empty((6, 3)), np.empty((6, 3))
    for k in range(span[0], span[1]):
        e, f = control[first[k]], control[second[k]]
        distance[k] = approach(powers, e, f, z[k], scratch, x, y, r)


@njit(cache=True, error_model="numpy", nogil=True)
def jets(span, powers, control, elements, st, out):
    """Position and derivatives s, t, ss, st, tt at points of elements, ``out (n, 6, 3)``."""
    scratch = np.empty(9 * len(powers))
    for k in range(span[0], span[1]):
        jet(powers, control[elements[k]], st[k, 0], st[k, 1], scratch, out[k])
