"""Energies of shell and volume at points, with derivatives by the jets of the configuration.

Jets (m, r, 3) of m points are t0, t1, h00, h11, h01 (r = 5; r = 2 without bending), for the volume
x, t0, t1. First derivatives are added to S (m, r, 3), second ones to H (m, r, 6, r): the pairs
(i, j) of their components with i <= j in the order of `PAIRS`; `JetSums` sums both over functions.
Scratch (`WORK`) comes from outside: without allocations there are no reference counts to keep.
Notation of `kirchhoff_love`: z = t0 x t1, J = |z|, nu = z / J; Voigt order [00, 11, 2*01].
"""

import numpy as np
from numba import njit

from ._membrane_kernels import TAUT, relax, relaxed_energy, state_of

PAIRS = np.array([[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]])
WORK = (14, 3, 3)
TWICE = np.array([1.0, 1.0, 2.0])


@njit(cache=True, error_model="numpy", nogil=True, inline="always")
def _cross(a, b, out):
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@njit(cache=True, error_model="numpy", nogil=True, inline="always")
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)  # type: ignore[call-overload]
def _stretch(g, metric, e):
    """Membrane strain (Voigt)."""
    e[0] = 0.5 * (_dot(g[0], g[0]) - metric[0])
    e[1] = 0.5 * (_dot(g[1], g[1]) - metric[1])
    e[2] = _dot(g[0], g[1]) - metric[2]


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)  # type: ignore[call-overload]
def _bend(g, curvature, nu, k):
    """Bending strain (Voigt) and normal; returns J."""
    _cross(g[0], g[1], nu)
    J = np.sqrt(_dot(nu, nu))
    for i in range(3):
        nu[i] /= J
    for c in range(3):
        k[c] = TWICE[c] * (_dot(g[2 + c], nu) - curvature[c])
    return J


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)  # type: ignore[call-overload]
def energy(g, weights, metric, curvature, stiffness, share, out, work):
    """Membrane and bending energy of each point into out (m, 2).

    weights (2, m) are those of membrane and bending energy, the latter with the rigidity; a share
    k < 1 of compression asks for the tension field ``(1 - k) W_r + k W``.
    """
    e, k, nu = work[0, 0], work[0, 1], work[0, 2]
    for p in range(g.shape[0]):
        C, wm, wb = stiffness[p], 0.5 * weights[0, p], 0.5 * weights[1, p]
        membrane = bending = 0.0
        _stretch(g[p], metric[p], e)
        if share < 1.0:
            state = state_of(e, C)
            if state != TAUT:
                membrane += 2.0 * wm * (1.0 - share) * relaxed_energy(e, C, state)
                wm *= share
        if wb != 0.0:
            _bend(g[p], curvature[p], nu, k)
        for r in range(3):
            for s in range(3):
                membrane += wm * C[r, s] * e[r] * e[s]
                if wb != 0.0:
                    bending += wb * C[r, s] * k[r] * k[s]
        out[p, 0], out[p, 1] = membrane, bending


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)  # type: ignore[call-overload]
def membrane(g, weights, metric, stiffness, share, tangent, S, H, work):
    """Derivatives of the membrane energy; weights (m,) and share are those of `energy`."""
    e, n, moduli = work[0, 0], work[0, 1], work[1]
    b, db = work[2:5, :2], work[5:8, :2]  # strains' derivatives by t0 and t1; D b
    for p in range(g.shape[0]):
        w, C = weights[p], stiffness[p]
        if w == 0.0:
            continue
        t0, t1 = g[p, 0], g[p, 1]
        _stretch(g[p], metric[p], e)
        D = C
        for r in range(3):
            n[r] = C[r, 0] * e[0] + C[r, 1] * e[1] + C[r, 2] * e[2]
        if share < 1.0:
            state = state_of(e, C)
            if state != TAUT:
                relax(e, C, state, share, n, moduli)
                D = moduli
        for r in range(3):
            n[r] *= w
        for i in range(3):
            S[p, 0, i] += n[0] * t0[i] + n[2] * t1[i]
            S[p, 1, i] += n[1] * t1[i] + n[2] * t0[i]
        if not tangent:
            continue
        for i in range(3):
            b[0, 0, i] = b[2, 1, i] = t0[i]
            b[1, 1, i] = b[2, 0, i] = t1[i]
            b[0, 1, i] = b[1, 0, i] = 0.0
        for c in range(3):
            for d in range(2):
                for i in range(3):
                    total = D[c, 0] * b[0, d, i] + D[c, 1] * b[1, d, i] + D[c, 2] * b[2, d, i]
                    db[c, d, i] = w * total
        for s in range(6):
            i, j = PAIRS[s]
            for d in range(2):
                for f in range(2):
                    value = b[0, d, i] * db[0, f, j] + b[1, d, i] * db[1, f, j]
                    value += b[2, d, i] * db[2, f, j]
                    if i == j:
                        value += n[d] if d == f else n[2]
                    H[p, d, s, f] += value


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)  # type: ignore[call-overload]
def bending(g, weights, curvature, stiffness, tangent, S, H, work):
    """Derivatives of the bending energy; weights (m,) carry the rigidity."""
    k, m, nu = work[0, 0], work[0, 1], work[0, 2]
    h, t, axis = work[1, 0], work[1, 1], work[1, 2]
    force, along, dz, dnu = work[2, :2], work[3, :2], work[4:6], work[6:8]
    b, db = work[8:11, :2], work[11:14, :2]
    axis[:] = 0.0
    for p in range(g.shape[0]):
        w, C, x = weights[p], stiffness[p], g[p]
        if w == 0.0:
            continue
        J = _bend(x, curvature[p], nu, k)
        for c in range(3):
            m[c] = w * TWICE[c] * (C[c, 0] * k[0] + C[c, 1] * k[1] + C[c, 2] * k[2])
        for i in range(3):
            h[i] = m[0] * x[2, i] + m[1] * x[3, i] + m[2] * x[4, i]
        hnu = _dot(h, nu)
        for i in range(3):
            t[i] = (h[i] - hnu * nu[i]) / J
        _cross(x[1], t, force[0])
        _cross(t, x[0], force[1])
        for i in range(3):
            S[p, 0, i] += force[0, i]
            S[p, 1, i] += force[1, i]
            for c in range(3):
                S[p, 2 + c, i] += m[c] * nu[i]
        if not tangent:
            continue
        # z' and nu' by the components of t0 and t1, of nu the part along it
        for i in range(3):
            axis[i] = 1.0
            _cross(axis, x[1], dz[0, i])
            _cross(x[0], axis, dz[1, i])
            axis[i] = 0.0
        for d in range(2):
            for i in range(3):
                along[d, i] = _dot(nu, dz[d, i])
                for c in range(3):
                    dnu[d, i, c] = (dz[d, i, c] - along[d, i] * nu[c]) / J
                for c in range(3):
                    b[c, d, i] = TWICE[c] * _dot(x[2 + c], dnu[d, i])
                for c in range(3):
                    total = C[c, 0] * b[0, d, i] + C[c, 1] * b[1, d, i] + C[c, 2] * b[2, d, i]
                    db[c, d, i] = w * total
        for s in range(6):
            i, j = PAIRS[s]
            for d in range(2):
                for f in range(2):
                    value = b[0, d, i] * db[0, f, j] + b[1, d, i] * db[1, f, j]
                    value += b[2, d, i] * db[2, f, j] - hnu * _dot(dnu[d, i], dnu[f, j])
                    value -= (force[d, i] * along[f, j] + along[d, i] * force[f, j]) / J
                    if i != j and d != f:
                        skew = t[1] if s == 2 else -t[3 - i - j]
                        value += skew if d > f else -skew
                    H[p, d, s, f] += value
                for c in range(3):
                    H[p, 2 + c, s, d] += TWICE[c] * nu[i] * db[c, d, j] + m[c] * dnu[d, j, i]
                    H[p, d, s, 2 + c] += TWICE[c] * nu[j] * db[c, d, i] + m[c] * dnu[d, i, j]
            both = w * nu[i] * nu[j]
            for c in range(3):
                for f in range(3):
                    H[p, 2 + c, s, 2 + f] += TWICE[c] * C[c, f] * TWICE[f] * both


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)  # type: ignore[call-overload]
def volume(g, thirds, order, Q, S, H, work):
    """Enclosed volume [T 2.27] of each point into Q (m,), with its derivatives [T 2.30].

    thirds (m,) are a third of the parametric weights; order 0 fills Q, 1 also S, 2 also H.
    """
    z = work[0, 0]
    for p in range(g.shape[0]):
        w, x = thirds[p], g[p]
        _cross(x[1], x[2], z)
        Q[p] = w * _dot(x[0], z)
        if order < 1:
            continue
        for d in range(3):
            _cross(x[(d + 1) % 3], x[(d + 2) % 3], z)
            for i in range(3):
                S[p, d, i] += w * z[i]
        if order < 2:
            continue
        for s in (1, 2, 4):
            i, j = PAIRS[s]
            sign = -w if s == 2 else w
            for d in range(3):
                value = sign * x[(d + 2) % 3, 3 - i - j]
                H[p, d, s, (d + 1) % 3] += value
                H[p, (d + 1) % 3, s, d] -= value
