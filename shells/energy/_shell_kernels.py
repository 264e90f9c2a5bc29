"""Fused element kernels: Kirchhoff-Love energy, force and tangent; enclosed volume.

Every kernel loops over a span of elements; each element writes its own slice, so results do not
depend on the number of threads. Notation of `kirchhoff_love`: t = tangents, h = second
derivatives, z = t0 x t1, J = |z|, nu = z / J; Voigt order [00, 11, 2*01].
"""

import numpy as np
from numba import njit

from ._membrane_kernels import TAUT, membrane_alone, relax, relaxed_energy, state_of

FEATURES = 11


@njit(cache=True, error_model="numpy", nogil=True)
def _cross(a, b, out):
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@njit(cache=True, error_model="numpy", nogil=True)
def _point_jets(jet, base, dofs, coefficients, out):
    """Jets t0, t1, h00, h11, h01 at one point: base plus spline part, into out (5, 3)."""
    for d in range(5):
        for i in range(3):
            out[d, i] = base[d, i]
    for a in range(dofs.size):
        for i in range(3):
            c = coefficients[dofs[a], i]
            for d in range(5):
                out[d, i] += jet[a, d] * c


@njit(cache=True, error_model="numpy", nogil=True)
def _strains(g, metric, curvature, nu, e, k):
    """Membrane and bending strain (Voigt); returns J."""
    _cross(g[0], g[1], nu)
    J = np.sqrt(nu[0] * nu[0] + nu[1] * nu[1] + nu[2] * nu[2])
    for i in range(3):
        nu[i] /= J
    a00 = a11 = a01 = b00 = b11 = b01 = 0.0
    for i in range(3):
        a00 += g[0, i] * g[0, i]
        a11 += g[1, i] * g[1, i]
        a01 += g[0, i] * g[1, i]
        b00 += g[2, i] * nu[i]
        b11 += g[3, i] * nu[i]
        b01 += g[4, i] * nu[i]
    e[0] = 0.5 * (a00 - metric[0])
    e[1] = 0.5 * (a11 - metric[1])
    e[2] = a01 - metric[2]
    k[0] = b00 - curvature[0]
    k[1] = b11 - curvature[1]
    k[2] = 2.0 * (b01 - curvature[2])
    return J


@njit(cache=True, error_model="numpy", nogil=True)
def energy(
    span, jets, base, weights, metric, curvature, stiffness, flexural, share, dofs, coefficients,
    out,
):  # fmt: skip
    """Membrane and bending energy of each element into out (n_elements, 2).

    weights (2, n_elements, n_points) are those of membrane and bending energy; a share k < 1 of
    compression asks for the tension field ``(1 - k) W_r + k W``.
    """
    for el in range(span[0], span[1]):
        g, nu = np.empty((5, 3)), np.empty(3)
        e, k = np.empty(3), np.empty(3)
        membrane = bending = 0.0
        for q in range(weights.shape[2]):
            wm, wb = 0.5 * weights[0, el, q], 0.5 * flexural * weights[1, el, q]
            _point_jets(jets[el, q], base[el, q], dofs[el], coefficients, g)
            _strains(g, metric[el, q], curvature[el, q], nu, e, k)
            if share < 1.0:
                state = state_of(e, stiffness[el, q])
                if state != TAUT:
                    relaxed = relaxed_energy(e, stiffness[el, q], state)
                    membrane += 2.0 * wm * (1.0 - share) * relaxed
                    wm *= share
            for r in range(3):
                for s in range(3):
                    membrane += wm * stiffness[el, q, r, s] * e[r] * e[s]
                    bending += wb * stiffness[el, q, r, s] * k[r] * k[s]
        out[el, 0] = membrane
        out[el, 1] = bending


@njit(cache=True, error_model="numpy", nogil=True)
def _first_variations(jet, g, nu, J, n, m, Bm, Bb, dnu, nuz, Hdnu, H):
    """Rows of e', k', nu', nu.z' and H.nu' for every local vector dof."""
    w, z = np.empty(3), np.empty(3)
    for i in range(3):
        H[i] = m[0] * g[2, i] + m[1] * g[3, i] + 2.0 * m[2] * g[4, i]
    for a in range(jet.shape[0]):
        n0, n1, n00, n11, n01 = jet[a, 0], jet[a, 1], jet[a, 2], jet[a, 3], jet[a, 4]
        for i in range(3):
            w[i] = n0 * g[1, i] - n1 * g[0, i]
        for i in range(3):
            r = 3 * a + i
            # z' = e_i x w
            z[i] = 0.0
            z[(i + 1) % 3] = -w[(i + 2) % 3]
            z[(i + 2) % 3] = w[(i + 1) % 3]
            along = nu[0] * z[0] + nu[1] * z[1] + nu[2] * z[2]
            nuz[r] = along
            k0 = k1 = k2 = hd = 0.0
            for c in range(3):
                d = (z[c] - along * nu[c]) / J
                dnu[c, r] = d
                k0 += g[2, c] * d
                k1 += g[3, c] * d
                k2 += g[4, c] * d
                hd += H[c] * d
            Hdnu[r] = hd
            Bm[0, r] = n0 * g[0, i]
            Bm[1, r] = n1 * g[1, i]
            Bm[2, r] = n0 * g[1, i] + n1 * g[0, i]
            Bb[0, r] = n00 * nu[i] + k0
            Bb[1, r] = n11 * nu[i] + k1
            Bb[2, r] = 2.0 * (n01 * nu[i] + k2)


@njit(cache=True, error_model="numpy", nogil=True)
def _second_variations(jet, nu, J, n, m, H, dnu, K):
    """Terms of e'' and k'' that are not products of first variations, block by block.

    n and m carry the point's weight.
    """
    nb = jet.shape[0]
    hnu = H[0] * nu[0] + H[1] * nu[1] + H[2] * nu[2]
    t = np.empty(3)
    for i in range(3):
        t[i] = (H[i] - hnu * nu[i]) / J
    for a in range(nb):
        Ma = m[0] * jet[a, 2] + m[1] * jet[a, 3] + 2.0 * m[2] * jet[a, 4]
        for b in range(a + 1):
            A0, A1, B0, B1 = jet[a, 0], jet[a, 1], jet[b, 0], jet[b, 1]
            Mb = m[0] * jet[b, 2] + m[1] * jet[b, 3] + 2.0 * m[2] * jet[b, 4]
            diagonal = n[0] * A0 * B0 + n[1] * A1 * B1 + n[2] * (A0 * B1 + A1 * B0)
            skew = A0 * B1 - A1 * B0
            for i in range(3):
                for j in range(3):
                    value = Ma * dnu[i, 3 * b + j] + Mb * dnu[j, 3 * a + i]
                    if i == j:
                        value += diagonal
                    elif (j - i) % 3 == 1:
                        value += skew * t[3 - i - j]
                    else:
                        value -= skew * t[3 - i - j]
                    K[3 * a + i, 3 * b + j] += value


@njit(cache=True, error_model="numpy", nogil=True)
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
                for c in range(3):
                    total += n[c] * Bm[c, r] + m[c] * Bb[c, r]
                R[el, r] += total
            if not tangent:
                continue
            hnu = H[0] * nu[0] + H[1] * nu[1] + H[2] * nu[2]
            for r in range(nd):
                for c in range(3):
                    mem = D[c, 0] * Bm[0, r] + D[c, 1] * Bm[1, r] + D[c, 2] * Bm[2, r]
                    ben = C[c, 0] * Bb[0, r] + C[c, 1] * Bb[1, r] + C[c, 2] * Bb[2, r]
                    right[c, r] = wm * mem
                    right[3 + c, r] = wb * ben
                    right[6 + c, r] = -hnu * dnu[c, r]
                right[9, r] = -Hdnu[r] / J
                right[10, r] = -nuz[r] / J
            # points of bending alone skip the features of the membrane
            first = 0 if wm != 0.0 else 3
            for r in range(nd):
                stop = r - r % 3 + 3
                row = K[el, r]
                for f in range(first, FEATURES):
                    factor = left[f, r]
                    for c in range(stop):
                        row[c] += factor * right[f, c]
            _second_variations(jets[el, q], nu, J, n, m, H, dnu, K[el])
        if tangent:
            for r in range(nd):
                for c in range(r + 1, nd):
                    K[el, r, c] = K[el, c, r]


@njit(cache=True, error_model="numpy", nogil=True)
def volume_terms(span, values, dw, dofs, coefficients, order, Q, R, K):
    """Enclosed volume [T 2.27] of each element with its exact variations [T 2.30].

    values (n_elements, n_points, nb, 3) holds N, N_s, N_t; dw the parametric weights; order 0
    fills Q, 1 also R, 2 also K.
    """
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
