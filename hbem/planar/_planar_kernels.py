"""Galerkin matrices on polygons: inner integrals in closed form, outer Gauss points.

Segment ``a + s t``, s in [0, L], normal n = rot t; a target x has s0 = (x-a).t, h = (x-a).n, and
u = s - s0. Moments of the kernels over u^k, k = 0, 1, are elementary (log, atan2); linear functions
are ``N1 = (M1 + s0 M0)/L, N0 = M0 - N1``. Far pairs take few outer points; near ones break the
outer segment at the projections of the inner end points and grade each piece to its ends.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def stokes_moments(s0, h, L, moments):
    """Moments ``[k, (log, tt, tn, nn, Ktt, Ktn, Knn)]`` over u^k of all Stokes kernels."""
    u1, u2 = -s0, L - s0
    r1, r2 = u1 * u1 + h * h, u2 * u2 + h * h
    l1 = np.log(r1) if r1 > 0.0 else 0.0
    l2 = np.log(r2) if r2 > 0.0 else 0.0
    J = 0.5 * (l2 - l1)
    A = np.arctan2(h * L, h * h + u1 * u2) if h != 0.0 else 0.0
    moments[0, 0] = -0.5 * (u2 * l2 - u1 * l1 - 2.0 * L + 2.0 * h * A)
    moments[1, 0] = -0.25 * (r2 * (l2 - 1.0) - r1 * (l1 - 1.0))
    moments[0, 1], moments[0, 2], moments[0, 3] = L - h * A, -h * J, h * A
    moments[1, 1] = 0.5 * (u2 * u2 - u1 * u1) - h * h * J
    moments[1, 2], moments[1, 3] = -h * (L - h * A), h * h * J
    if h == 0.0:
        moments[:, 4:] = 0.0
        return
    dq, uq = 1.0 / r2 - 1.0 / r1, u2 / r2 - u1 / r1
    moments[0, 4], moments[0, 6] = 0.5 * (A - h * uq), 0.5 * (A + h * uq)
    moments[0, 5] = 0.5 * h * h * dq
    moments[1, 4] = h * (J + 0.5 * h * h * dq)
    moments[1, 5], moments[1, 6] = -0.5 * h * (A - h * uq), -0.5 * h * h * h * dq


@njit(cache=True, error_model="numpy", nogil=True)
def laplace_moments(s0, h, L, moments):
    """Moments ``[k, (log, dipole)]`` over u^k: ``log 1/r`` and ``(x-y).n / r^2``."""
    u1, u2 = -s0, L - s0
    r1, r2 = u1 * u1 + h * h, u2 * u2 + h * h
    l1 = np.log(r1) if r1 > 0.0 else 0.0
    l2 = np.log(r2) if r2 > 0.0 else 0.0
    A = np.arctan2(h * L, h * h + u1 * u2) if h != 0.0 else 0.0
    moments[0, 0] = -0.5 * (u2 * l2 - u1 * l1 - 2.0 * L + 2.0 * h * A)
    moments[1, 0] = -0.25 * (r2 * (l2 - 1.0) - r1 * (l1 - 1.0))
    moments[0, 1], moments[1, 1] = A, 0.5 * h * (l2 - l1)


@njit(cache=True, error_model="numpy", nogil=True)
def segment_distance(a, ta, La, b, tb, Lb):
    """Distance of two segments that do not cross: from the end points of each to the other."""
    best = 1e300
    for end in range(4):
        if end < 2:
            px, py = a[0] + end * La * ta[0], a[1] + end * La * ta[1]
            qx, qy, tx, ty, L = b[0], b[1], tb[0], tb[1], Lb
        else:
            px, py = b[0] + (end - 2) * Lb * tb[0], b[1] + (end - 2) * Lb * tb[1]
            qx, qy, tx, ty, L = a[0], a[1], ta[0], ta[1], La
        s = min(max((px - qx) * tx + (py - qy) * ty, 0.0), L)
        best = min(best, np.hypot(px - qx - s * tx, py - qy - s * ty))
    return best


@njit(cache=True, error_model="numpy", nogil=True)
def segments(points):
    """Unit tangents and lengths of the segments of a closed polygon."""
    n = points.shape[0]
    t, L = np.empty((n, 2)), np.empty(n)
    for i in range(n):
        dx = points[(i + 1) % n, 0] - points[i, 0]
        dy = points[(i + 1) % n, 1] - points[i, 1]
        L[i] = np.hypot(dx, dy)
        t[i, 0], t[i, 1] = dx / L[i], dy / L[i]
    return t, L


@njit(cache=True, error_model="numpy", nogil=True)
def outer_rule(a, ta, La, b, tb, Lb, far_x, far_w, near_x, near_w, x, w):
    """Outer points on segment a for the inner segment b; returns their number.

    An empty near rule switches it off: plain Gauss everywhere, to measure what that costs.
    """
    if near_x.size == 0 or segment_distance(a, ta, La, b, tb, Lb) >= max(La, Lb):
        for g in range(far_x.size):
            x[g], w[g] = La * far_x[g], La * far_w[g]
        return far_x.size
    cuts = np.empty(4)
    cuts[0], n = 0.0, 1
    first = (b[0] - a[0]) * ta[0] + (b[1] - a[1]) * ta[1]
    second = first + Lb * (tb[0] * ta[0] + tb[1] * ta[1])
    for c in (min(first, second), max(first, second)):
        if c > cuts[n - 1] + 1e-10 * La and c < La * (1.0 - 1e-10):
            cuts[n] = c
            n += 1
    cuts[n] = La
    count = 0
    for piece in range(n):
        length = cuts[piece + 1] - cuts[piece]
        for g in range(near_x.size):
            x[count] = cuts[piece] + length * near_x[g]
            w[count] = length * near_w[g]
            count += 1
    return count


@njit(cache=True, error_model="numpy", nogil=True)
def rotated(A, B, C, D, tx, ty, out):
    """``D I + A tt + B (tn + nt) + C nn`` with n = (ty, -tx)."""
    out[0, 0] = D + A * tx * tx + 2.0 * B * tx * ty + C * ty * ty
    out[1, 1] = D + A * ty * ty - 2.0 * B * tx * ty + C * tx * tx
    out[0, 1] = (A - C) * tx * ty + B * (ty * ty - tx * tx)
    out[1, 0] = out[0, 1]


@njit(cache=True, error_model="numpy", nogil=True)
def stokes_row(i, points, t, L, rules, double, log_scale, V, K):
    """Rows ``4 i .. 4 i + 3`` of both layers."""
    far_x, far_w, near_x, near_w = rules
    moments, local = np.empty((2, 7)), np.empty((2, 2, 2))
    size = max(far_x.size, 3 * near_x.size)
    x, w = np.empty(size), np.empty(size)
    for j in range(points.shape[0]):
        if i == j:
            stokes_self(L[i], t[i], log_scale, V[4 * i : 4 * i + 4, 4 * i : 4 * i + 4])
            continue
        count = outer_rule(
            points[i], t[i], L[i], points[j], t[j], L[j], far_x, far_w, near_x, near_w, x, w
        )
        tx, ty = t[j, 0], t[j, 1]
        for q in range(count):
            dx = points[i, 0] + x[q] * t[i, 0] - points[j, 0]
            dy = points[i, 1] + x[q] * t[i, 1] - points[j, 1]
            s0 = dx * tx + dy * ty
            stokes_moments(s0, dx * ty - dy * tx, L[j], moments)
            moments[0, 0] += log_scale * L[j]
            moments[1, 0] += log_scale * 0.5 * L[j] * (L[j] - 2.0 * s0)
            for layer in range(2 if double else 1):
                o = 1 + 3 * layer
                matrix = K if layer else V
                scale = w[q] / np.pi if layer else 0.25 * w[q] / np.pi
                for k in range(2):
                    D = 0.0 if layer else moments[k, 0]
                    rotated(
                        moments[k, o], moments[k, o + 1], moments[k, o + 2], D, tx, ty, local[k]
                    )
                last = x[q] / L[i]
                for c in range(2):
                    for d in range(2):
                        k1 = scale * (local[1, c, d] + s0 * local[0, c, d]) / L[j]
                        k0 = scale * local[0, c, d] - k1
                        row, col = 4 * i + c, 4 * j + d
                        matrix[row, col] += (1.0 - last) * k0
                        matrix[row, col + 2] += (1.0 - last) * k1
                        matrix[row + 2, col] += last * k0
                        matrix[row + 2, col + 2] += last * k1


@njit(cache=True, error_model="numpy", nogil=True)
def stokes_matrices(points, rules, double, log_scale, V, K):
    """Single and double layer on a closed polygon, discontinuous linear functions.

    ``points (n, 2)``; ``rules`` far and near points and weights on [0, 1]; dof ``4 e + 2 m + i`` is
    component i of function m on segment e. V and K are ``(4 n, 4 n)``, Re = 1.
    """
    t, L = segments(points)
    for i in range(points.shape[0]):
        stokes_row(i, points, t, L, rules, double, log_scale, V, K)


@njit(cache=True, error_model="numpy", nogil=True)
def stokes_self(L, t, log_scale, block):
    """``(L/8)^2/pi [delta_ik (6 + (-1)^(m+n) - 4 log L) + 4 t_i t_k]``; K is zero there.

    Departs from the closed form of [T 5.2.1]: off-diagonal terms, right for any direction.
    """
    for m in range(2):
        for k in range(2):
            even = 7.0 if m == k else 5.0
            for c in range(2):
                for d in range(2):
                    value = 4.0 * t[c] * t[d]
                    if c == d:
                        value += even - 4.0 * np.log(L) + 4.0 * log_scale
                    block[2 * m + c, 2 * k + d] = (0.125 * L) ** 2 / np.pi * value


@njit(cache=True, error_model="numpy", nogil=True)
def laplace_self(L, log_scale, block):
    """``L^2/(32 pi) (6 + (-1)^(m+n) - 4 log L)``: a 16th of what [T 4.2.1] prints."""
    for m in range(2):
        for k in range(2):
            even = 7.0 if m == k else 5.0
            value = even - 4.0 * np.log(L) + 4.0 * log_scale
            block[m, k] = L * L / (32.0 * np.pi) * value


@njit(cache=True, error_model="numpy", nogil=True)
def laplace_matrices(points, rules, log_scale, V, K):
    """Potential flow's single and double layer ``(2 n, 2 n)``, dof ``2 e + m``."""
    far_x, far_w, near_x, near_w = rules
    t, L = segments(points)
    moments = np.empty((2, 2))
    size = max(far_x.size, 3 * near_x.size)
    x, w = np.empty(size), np.empty(size)
    for i in range(points.shape[0]):
        for j in range(points.shape[0]):
            if i == j:
                laplace_self(L[i], log_scale, V[2 * i : 2 * i + 2, 2 * i : 2 * i + 2])
                continue
            count = outer_rule(
                points[i], t[i], L[i], points[j], t[j], L[j], far_x, far_w, near_x, near_w, x, w
            )
            for q in range(count):
                dx = points[i, 0] + x[q] * t[i, 0] - points[j, 0]
                dy = points[i, 1] + x[q] * t[i, 1] - points[j, 1]
                s0 = dx * t[j, 0] + dy * t[j, 1]
                laplace_moments(s0, dx * t[j, 1] - dy * t[j, 0], L[j], moments)
                moments[0, 0] += log_scale * L[j]
                moments[1, 0] += log_scale * 0.5 * L[j] * (L[j] - 2.0 * s0)
                last, scale = x[q] / L[i], 0.5 * w[q] / np.pi
                for layer in range(2):
                    matrix = K if layer else V
                    k1 = scale * (moments[1, layer] + s0 * moments[0, layer]) / L[j]
                    k0 = scale * moments[0, layer] - k1
                    row, col = 2 * i, 2 * j
                    matrix[row, col] += (1.0 - last) * k0
                    matrix[row, col + 1] += (1.0 - last) * k1
                    matrix[row + 1, col] += last * k0
                    matrix[row + 1, col + 1] += last * k1


@njit(cache=True, error_model="numpy", nogil=True)
def contact_tractions(points, gx, gw, cutoff, force):
    """``int b(r/l) |(x-y).(n(x)-n(y))| (x-y)/r^3 ds(y)`` at Gauss points ``(n, m, 2)``."""
    n, m = points.shape[0], gx.size
    t, L = segments(points)
    for i in range(n):
        for j in range(n):
            if i == j:
                continue
            if segment_distance(points[i], t[i], L[i], points[j], t[j], L[j]) >= cutoff:
                continue
            nx, ny = t[i, 1] - t[j, 1], t[j, 0] - t[i, 0]
            for p in range(m):
                x0 = points[i, 0] + gx[p] * L[i] * t[i, 0]
                x1 = points[i, 1] + gx[p] * L[i] * t[i, 1]
                for q in range(m):
                    d0 = x0 - points[j, 0] - gx[q] * L[j] * t[j, 0]
                    d1 = x1 - points[j, 1] - gx[q] * L[j] * t[j, 1]
                    r = np.hypot(d0, d1)
                    s = r / cutoff
                    if s >= 1.0:
                        continue
                    window = 1.0 - 3.0 * s * s if s < 1.0 / 3.0 else 1.5 * (1.0 - s) ** 2
                    weight = gw[q] * L[j] * window * abs(d0 * nx + d1 * ny) / (r * r * r)
                    force[i, p, 0] += weight * d0
                    force[i, p, 1] += weight * d1


@njit(cache=True, error_model="numpy", nogil=True)
def facing_gap(points, facing):
    """Smallest distance of segments whose normals have a cosine below ``facing``."""
    n = points.shape[0]
    t, L = segments(points)
    best = np.inf
    for i in range(n):
        for j in range(i + 2, n - 1 if i == 0 else n):  # neighbours share a point
            if t[i, 0] * t[j, 0] + t[i, 1] * t[j, 1] < facing:
                gap = segment_distance(points[i], t[i], L[i], points[j], t[j], L[j])
                best = min(best, gap)
    return best
