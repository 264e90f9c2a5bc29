"""Kinks and moments at Gauss points of edges: energy, with its derivatives by five vectors.

Five vectors per point, linear in the coefficients: t along the edge, on each side i the derivative
g_i along the conormal and ``m_i = h_nn + nu h_tt`` of the second derivatives. With
``z_i = g_i x t``, ``J_i = |z_i|``, ``n_i = z_i / J_i``:

    kink    theta = atan2(|t| [g1, g2, t], z1 . z2), less that of the stress-free shell
    moment  M = sum_i modulus_i m_i . n_i - M0
    energy  -M theta + stiffness / 2 theta^2

theta' is ``|t| / J_i n_i`` on g_i (minus on side 2) and minus ``g_i . t / t . t`` of that on t.
"""

import numpy as np
from numba import njit

from .._shell_kernels import PAIRS, _cross, _dot


@njit(cache=True, error_model="numpy", nogil=True)
def kink(v, free, moduli, n, J):
    """Kink less the stress-free one, whose cosine and sine are ``free``; and the moment.

    ``free[2]`` is the moment of the stress-free shell. Normals and J go into n (2, 3), J (2,).
    """
    t = v[0]
    for s in range(2):
        _cross(v[1 + s], t, n[s])
        J[s] = np.sqrt(_dot(n[s], n[s]))
    cosine = _dot(n[0], n[1])
    sine = np.sqrt(_dot(t, t)) * -_dot(n[0], v[2])  # [g1, g2, t] = -(g1 x t) . g2
    for s in range(2):
        for i in range(3):
            n[s, i] /= J[s]
    theta = np.arctan2(
        sine * free[0] - cosine * free[1],
        cosine * free[0] + sine * free[1],
    )
    moment = moduli[0] * _dot(v[3], n[0]) + moduli[1] * _dot(v[4], n[1]) - free[2]
    return theta, moment


@njit(cache=True, error_model="numpy", nogil=True)
def point_force(v, n, J, moduli, dtheta, dM, turn):
    """Gradients of kink and moment by the five vectors, dtheta (5, 3) and dM (5, 3).

    turn (2, 4, 3) keeps of each side: q = |t| n / J, p = (m - m.n n) / J, and n . z' by g and t.
    """
    t = v[0]
    tt = _dot(t, t)
    T = np.sqrt(tt)
    for i in range(3):
        dtheta[0, i] = dM[0, i] = dtheta[3, i] = dtheta[4, i] = 0.0
    for s in range(2):
        g, m, sign = v[1 + s], v[3 + s], 1.0 - 2.0 * s
        a, along = _dot(g, t) / tt, _dot(m, n[s])
        q, p = turn[s, 0], turn[s, 1]
        for i in range(3):
            q[i] = T / J[s] * n[s, i]
            p[i] = (m[i] - along * n[s, i]) / J[s]
            dtheta[1 + s, i] = sign * q[i]
            dtheta[0, i] -= sign * a * q[i]
            dM[3 + s, i] = moduli[s] * n[s, i]
        _cross(t, n[s], turn[s, 2])
        _cross(n[s], g, turn[s, 3])
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            dM[1 + s, i] = moduli[s] * (t[j] * p[k] - t[k] * p[j])
            dM[0, i] += moduli[s] * (p[j] * g[k] - p[k] * g[j])


@njit(cache=True, error_model="numpy", nogil=True)
def point_tangent(v, n, J, moduli, theta, bend, stiffness, dtheta, dM, turn, dn, H):
    """Hessian of ``-M theta + stiffness / 2 theta^2`` by the five vectors into H (5, 3, 5, 3).

    bend is ``stiffness theta - M``; dn (2, 3, 3) is scratch. Blocks (t, g), (t, m), (g, m) are set
    on both sides of the diagonal.
    """
    t = v[0]
    tt = _dot(t, t)
    T = np.sqrt(tt)
    for x in range(5):
        for i in range(3):
            for y in range(5):
                for j in range(3):
                    H[x, i, y, j] = (
                        stiffness * dtheta[x, i] * dtheta[y, j]
                        - dM[x, i] * dtheta[y, j]
                        - dtheta[x, i] * dM[y, j]
                    )
    for s in range(2):
        g, m, nu = v[1 + s], v[3 + s], n[s]
        sign = bend * (1.0 - 2.0 * s)
        q, p, ag, at = turn[s, 0], turn[s, 1], turn[s, 2], turn[s, 3]
        gt = _dot(g, t)
        a, gg, inverse = gt / tt, _dot(g, g), 1.0 / J[s]
        # dn[0, j] and dn[1, j]: derivative of n by component j of g and of t
        for j in range(3):
            k, o = (j + 1) % 3, (j + 2) % 3
            for c in range(3):
                dn[0, j, c] = -ag[j] * nu[c] * inverse
                dn[1, j, c] = -at[j] * nu[c] * inverse
            dn[0, j, k] -= t[o] * inverse
            dn[0, j, o] += t[k] * inverse
            dn[1, j, k] += g[o] * inverse
            dn[1, j, o] -= g[k] * inverse
        size = -theta * moduli[s]
        on_normal = _dot(m, nu) * inverse * inverse
        X, M = 1 + s, 3 + s
        for i in range(3):
            i1, i2 = (i + 1) % 3, (i + 2) % 3
            mg_i = t[i1] * p[i2] - t[i2] * p[i1]
            mt_i = p[i1] * g[i2] - p[i2] * g[i1]
            for j in range(3):
                j1, j2 = (j + 1) % 3, (j + 2) % 3
                mg_j = t[j1] * p[j2] - t[j2] * p[j1]
                mt_j = p[j1] * g[j2] - p[j2] * g[j1]
                same = 1.0 if i == j else 0.0
                # moment: m with n', then n'' against m
                by_g, by_t = size * dn[0, j, i], size * dn[1, j, i]
                H[M, i, X, j] += by_g
                H[X, j, M, i] += by_g
                H[M, i, 0, j] += by_t
                H[0, j, M, i] += by_t
                H[X, i, X, j] -= size * (
                    (ag[i] * mg_j + ag[j] * mg_i) * inverse
                    + on_normal * (same * tt - t[i] * t[j] - ag[i] * ag[j])
                )
                H[0, i, 0, j] -= size * (
                    (at[i] * mt_j + at[j] * mt_i) * inverse
                    + on_normal * (same * gg - g[i] * g[j] - at[i] * at[j])
                )
                skew = 0.0  # p . (e_i x e_j)
                if j == i1:
                    skew = p[i2]
                elif j == i2:
                    skew = -p[i1]
                mixed = size * (
                    skew
                    - (ag[i] * mt_j + at[j] * mg_i) * inverse
                    - on_normal * (g[i] * t[j] - same * gt - ag[i] * at[j])
                )
                # kink: q' by g and by t
                q_g = T * inverse * (dn[0, j, i] - nu[i] * ag[j] * inverse)
                q_t = T * inverse * (dn[1, j, i] - nu[i] * at[j] * inverse)
                q_t += nu[i] * t[j] / (T * J[s])
                H[X, i, X, j] += sign * q_g
                mixed += sign * q_t
                H[X, i, 0, j] += mixed
                H[0, j, X, i] += mixed
                H[0, i, 0, j] -= sign * (a * q_t + q[i] * (g[j] - 2.0 * a * t[j]) / tt)


@njit(cache=True, error_model="numpy", nogil=True)
def energy(v, weights, free, moduli, stiffness, kinks, out):
    """Kinks less the stress-free ones of points (m,) into kinks, energies into out.

    v (m, 5, 3) holds t, g1, g2, m1, m2; moduli (m, 2) and stiffness (m,) are those of the edges.
    """
    n, J = np.empty((2, 3)), np.empty(2)
    for p in range(v.shape[0]):
        theta, moment = kink(v[p], free[p], moduli[p], n, J)
        kinks[p] = theta
        out[p] = weights[p] * theta * (0.5 * stiffness[p] * theta - moment)


@njit(cache=True, error_model="numpy", nogil=True)
def variations(v, weights, free, moduli, stiffness, tangent, S, H):
    """First derivatives of the energy into S (m, 5, 3), second ones into H (m, 5, 6, 5)."""
    n, J = np.empty((2, 3)), np.empty(2)
    dtheta, dM, turn = np.empty((5, 3)), np.empty((5, 3)), np.empty((2, 4, 3))
    dn, full = np.empty((2, 3, 3)), np.empty((5, 3, 5, 3))
    for p in range(v.shape[0]):
        theta, moment = kink(v[p], free[p], moduli[p], n, J)
        bend, w = stiffness[p] * theta - moment, weights[p]
        point_force(v[p], n, J, moduli[p], dtheta, dM, turn)
        for x in range(5):
            for i in range(3):
                S[p, x, i] = w * (bend * dtheta[x, i] - theta * dM[x, i])
        if not tangent:
            continue
        point_tangent(v[p], n, J, moduli[p], theta, bend, stiffness[p], dtheta, dM, turn, dn, full)
        for x in range(5):
            for s in range(6):
                for y in range(5):
                    H[p, x, s, y] = w * full[x, PAIRS[s, 0], y, PAIRS[s, 1]]
