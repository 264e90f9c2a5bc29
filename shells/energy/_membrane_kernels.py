"""Relaxed St. Venant-Kirchhoff energy by point: a membrane that wrinkles without resistance.

``W_r(E) = min over A >= 0 of W(E + A)`` (Pipkin 1986, Steigmann 1990), A what wrinkles take up. By
the principal Green strains e1 >= e2 and the stiffness C = E h / (1 - nu^2):

    taut      e2 + nu e1 > 0        W itself
    wrinkled  else, where e1 > 0    (1 - nu^2) C e1^2 / 2, tension along e1 alone
    slack     else                  0

Used is ``(1 - k) W_r + k W``. Strains are Voigt (E_00, E_11, 2 E_01) in an orthonormal frame, with
the elasticity matrix there. W_r is convex and C1; its second derivative jumps between states.
"""

import numpy as np
from numba import njit

TAUT, WRINKLED, SLACK = 0, 1, 2


@njit(cache=True, error_model="numpy", nogil=True, inline="always")
def _mean_and_radius(e):
    """Centre and radius of Mohr's circle: e1, e2 = mean +- radius."""
    d = 0.5 * (e[0] - e[1])
    return 0.5 * (e[0] + e[1]), np.sqrt(d * d + 0.25 * e[2] * e[2])


@njit(cache=True, error_model="numpy", nogil=True)
def state_of(e, C):
    """Taut, wrinkled or slack."""
    m, r = _mean_and_radius(e)
    if C[0, 0] * (m - r) + C[0, 1] * (m + r) > 0.0:
        return TAUT
    return WRINKLED if m + r > 0.0 else SLACK


@njit(cache=True, error_model="numpy", nogil=True)
def relaxed_energy(e, C, state):
    """W_r of a point that is not taut."""
    if state == SLACK:
        return 0.0
    m, r = _mean_and_radius(e)
    return 0.5 * (C[0, 0] - C[0, 1] * C[0, 1] / C[0, 0]) * (m + r) ** 2


@njit(cache=True, error_model="numpy", nogil=True)
def relax(e, C, state, k, n, D):
    """Stress and tangent of ``(1 - k) W_r + k W`` at a point that is not taut, into n and D."""
    for i in range(3):
        n[i] = k * (C[i, 0] * e[0] + C[i, 1] * e[1] + C[i, 2] * e[2])
        for j in range(3):
            D[i, j] = k * C[i, j]
    if state == SLACK:
        return
    m, r = _mean_and_radius(e)  # r > 0: strains alike in all directions are taut or slack
    cosine, sine = 0.5 * (e[0] - e[1]) / r, 0.5 * e[2] / r
    young = (1.0 - k) * (C[0, 0] - C[0, 1] * C[0, 1] / C[0, 0])
    along = 0.5 * (1.0 + cosine), 0.5 * (1.0 - cosine), 0.5 * sine  # e1'
    turn = -0.5 * sine, 0.5 * sine, 0.5 * cosine  # e1'' = turn turn^T / r
    for i in range(3):
        n[i] += young * (m + r) * along[i]
        for j in range(3):
            D[i, j] += young * (along[i] * along[j] + (m + r) / r * turn[i] * turn[j])


@njit(cache=True, error_model="numpy", nogil=True)
def points(strain, C, k, state, principal, psi, n, D):
    """Everything at points ``strain (m, 3)``: state, e1 and e2, energy, stress and tangent."""
    for p in range(strain.shape[0]):
        e = strain[p]
        m, r = _mean_and_radius(e)
        principal[p, 0], principal[p, 1] = m + r, m - r
        state[p] = state_of(e, C)
        psi[p] = 0.0
        for i in range(3):
            n[p, i] = C[i, 0] * e[0] + C[i, 1] * e[1] + C[i, 2] * e[2]
            psi[p] += 0.5 * n[p, i] * e[i]
            for j in range(3):
                D[p, i, j] = C[i, j]
        if state[p] != TAUT and k < 1.0:
            psi[p] = k * psi[p] + (1.0 - k) * relaxed_energy(e, C, state[p])
            relax(e, C, state[p], k, n[p], D[p])
