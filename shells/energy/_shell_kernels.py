"""Energies of shell and volume at points, with derivatives by the jets of the configuration.

<<<<<<< HEAD
Every kernel loops over a span of elements; each element writes its own slice, so results do not
depend on the number of threads. Notation of `kirchhoff_love`: t = tangents, h = second
derivatives, z = t0 x t1, J = |z|, nu = z / J; Voigt order [00, 11, 2*01].
=======
Jets (m, r, 3) of m points are t0, t1, h00, h11, h01 (r = 5; r = 2 without bending), for the volume
x, t0, t1. First derivatives are added to S (m, r, 3), second ones to H (m, r, 6, r): the pairs
(i, j) of their components with i <= j in the order of `PAIRS`; `JetSums` sums both over functions.
Notation of `kirchhoff_love`: z = t0 x t1, J = |z|, nu = z / J; Voigt order [00, 11, 2*01].
>>>>>>> h-6
"""

import numpy as np
from numba import njit

from ._membrane_kernels import TAUT, relax, relaxed_energy, state_of

<<<<<<< HEAD
FEATURES = 11
=======
PAIRS = np.array([[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]])
TWICE = np.array([1.0, 1.0, 2.0])
>>>>>>> h-6


@njit(cache=True, error_model="numpy", nogil=True, inline="always")
def _cross(a, b, out):
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@njit(cache=True, error_model="numpy", nogil=True, inline="always")
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy", nogil=True)
def _stretch(g, metric, e):
    """Membrane strain (Voigt)."""
    e[0] = 0.5 * (_dot(g[0], g[0]) - metric[0])
    e[1] = 0.5 * (_dot(g[1], g[1]) - metric[1])
    e[2] = _dot(g[0], g[1]) - metric[2]


@njit(cache=True, error_model="numpy", nogil=True)
def _bend(g, curvature, nu, k):
    """Bending strain (Voigt) and normal; returns J."""
    _cross(g[0], g[1], nu)
    J = np.sqrt(_dot(nu, nu))
    for i in range(3):
        nu[i] /= J
    for c in range(3):
        k[c] = TWICE[c] * (_dot(g[2 + c], nu) - curvature[c])
    return J


@njit(cache=True, error_model="numpy", nogil=True)
<<<<<<< HEAD
def energy(
    span, jets, base, weights, metric, curvature, stiffness, flexural, share, dofs, coefficients,
    out,
):  # fmt: skip
    """Membrane and bending energy of each element into out (n_elements, 2).
=======
def energy(g, weights, metric, curvature, stiffness, share, out):
    """Membrane and bending energy of each point into out (m, 2).
>>>>>>> h-6

    weights (2, m) are those of membrane and bending energy, the latter with the rigidity; a share
    k < 1 of compression asks for the tension field ``(1 - k) W_r + k W``.
    """
<<<<<<< HEAD
    for el in range(span[0], span[1]):
        g, nu = np.empty((5, 3)), np.empty(3)
        e, k = np.empty(3), np.empty(3)
=======
    e, k, nu = np.empty(3), np.empty(3), np.empty(3)
    for p in range(g.shape[0]):
        C, wm, wb = stiffness[p], 0.5 * weights[0, p], 0.5 * weights[1, p]
>>>>>>> h-6
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


@njit(cache=True, error_model="numpy", nogil=True)
def membrane(g, weights, metric, stiffness, share, tangent, S, H):
    """Derivatives of the membrane energy; weights (m,) and share are those of `energy`."""
    e, n, moduli = np.empty(3), np.empty(3), np.empty((3, 3))
    b, db = np.zeros((3, 2, 3)), np.empty((3, 2, 3))  # strains' derivatives by t0 and t1; D b
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


@njit(cache=True, error_model="numpy", nogil=True)
<<<<<<< HEAD
def force_and_tangent(
    span,
    jets,
    base,
    weights,
    metric,
    curvature,
    stiffness,
    flexural,
    share,
    dofs,
    coefficients,
    tangent,
    R,
    K,
):
    """Variations [T 2.18a, b]: first into R (n_elements, 3 nb), second into K (.., 3 nb, 3 nb).

    weights and share are those of `energy`.
    """
    nb = dofs.shape[1]
    nd = 3 * nb
    for el in range(span[0], span[1]):
        g, nu, H = np.empty((5, 3)), np.empty(3), np.empty(3)
        e, k, n, m = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
        left, right = np.empty((FEATURES, nd)), np.empty((FEATURES, nd))
        Bm, Bb, dnu = left[0:3], left[3:6], left[6:9]
        nuz, Hdnu = left[9], left[10]
        stress, moduli = np.empty(3), np.empty((3, 3))
        R[el] = 0.0
        if tangent:
            K[el] = 0.0
        for q in range(weights.shape[2]):
            wm, wb = weights[0, el, q], flexural * weights[1, el, q]
            if wm == 0.0 and wb == 0.0:
                continue
            C = stiffness[el, q]
            _point_jets(jets[el, q], base[el, q], dofs[el], coefficients, g)
            J = _strains(g, metric[el, q], curvature[el, q], nu, e, k)
            D = C  # of the membrane
            for r in range(3):
                n[r] = wm * (C[r, 0] * e[0] + C[r, 1] * e[1] + C[r, 2] * e[2])
                m[r] = wb * (C[r, 0] * k[0] + C[r, 1] * k[1] + C[r, 2] * k[2])
            if share < 1.0:
                state = state_of(e, C)
                if state != TAUT:
                    relax(e, C, state, share, stress, moduli)
                    D = moduli
                    for r in range(3):
                        n[r] = wm * stress[r]
            if wb == 0.0:
                membrane_alone(jets[el, q], g, wm, n, D, left, right, tangent, R[el], K[el])
                continue
            _first_variations(jets[el, q], g, nu, J, n, m, Bm, Bb, dnu, nuz, Hdnu, H)
            for r in range(nd):
                total = 0.0
=======
def bending(g, weights, curvature, stiffness, tangent, S, H):
    """Derivatives of the bending energy; weights (m,) carry the rigidity."""
    k, m, nu, h, t = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    axis, force = np.zeros(3), np.empty((2, 3))
    dz, along, dnu = np.empty((2, 3, 3)), np.empty((2, 3)), np.empty((2, 3, 3))
    b, db = np.empty((3, 2, 3)), np.empty((3, 2, 3))
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
>>>>>>> h-6
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


@njit(cache=True, error_model="numpy", nogil=True)
<<<<<<< HEAD
def volume_terms(span, values, dw, dofs, coefficients, order, Q, R, K):
    """Enclosed volume [T 2.27] of each element with its exact variations [T 2.30].
=======
def volume(g, thirds, order, Q, S, H):
    """Enclosed volume [T 2.27] of each point into Q (m,), with its derivatives [T 2.30].
>>>>>>> h-6

    thirds (m,) are a third of the parametric weights; order 0 fills Q, 1 also S, 2 also H.
    """
<<<<<<< HEAD
    nb = dofs.shape[1]
    for el in range(span[0], span[1]):
        x, t0, t1 = np.empty(3), np.empty(3), np.empty(3)
        z, u, v = np.empty(3), np.empty(3), np.empty(3)
        Q[el] = 0.0
        if order > 0:
            R[el] = 0.0
        if order > 1:
            K[el] = 0.0
        for q in range(dw.shape[1]):
            third = dw[el, q] / 3.0
            x[:] = 0.0
            t0[:] = 0.0
            t1[:] = 0.0
            for a in range(nb):
                for i in range(3):
                    c = coefficients[dofs[el, a], i]
                    x[i] += values[el, q, a, 0] * c
                    t0[i] += values[el, q, a, 1] * c
                    t1[i] += values[el, q, a, 2] * c
            _cross(t0, t1, z)
            Q[el] += third * (x[0] * z[0] + x[1] * z[1] + x[2] * z[2])
            if order < 1:
                continue
            _cross(t1, x, u)
            _cross(x, t0, v)
            for a in range(nb):
                N, N0, N1 = values[el, q, a, 0], values[el, q, a, 1], values[el, q, a, 2]
                for i in range(3):
                    R[el, 3 * a + i] += third * (N * z[i] + N0 * u[i] + N1 * v[i])
            if order < 2:
                continue
            for a in range(nb):
                N, N0, N1 = values[el, q, a, 0], values[el, q, a, 1], values[el, q, a, 2]
                for b in range(nb):
                    M, M0, M1 = values[el, q, b, 0], values[el, q, b, 1], values[el, q, b, 2]
                    p1, p0, p = N * M0 - M * N0, M * N1 - N * M1, N0 * M1 - M0 * N1
                    for k in range(3):
                        w = third * (p1 * t1[k] + p0 * t0[k] + p * x[k])
                        i, j = (k + 1) % 3, (k + 2) % 3
                        K[el, 3 * a + i, 3 * b + j] += w
                        K[el, 3 * a + j, 3 * b + i] -= w
=======
    z = np.empty(3)
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
>>>>>>> h-6
