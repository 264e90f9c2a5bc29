"""Compiled closest points: of one patch by projected Newton and search, of all near pairs.

Newton's point is kept where a bound proves it closest; elsewhere boxes are halved and discarded
by ``|y(s, t) - x| >= |y(centre) - x| - (L_s w_s + L_t w_t) / 2``. Patches are in Bernstein form,
safe at degree 8.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ..surfaces._jet_kernels import basis, jet

MAX_STEPS = 20  # of the closest-point iteration
SMALLEST = 1e-6  # relative distance below which the sinh rule is not graded further
NEARER = 0.8  # the search ends when no point is nearer than this part of the distance found
DEEPEST = 64  # halvings of one box: the stack holds one box of each
SELF = -1.0  # marks the pair of a point with its own element
OBLIQUE = 2.0  # largest factor on the nodes of a near rule


@njit(cache=True, error_model="numpy", nogil=True)
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy", nogil=True)
def descent(s, t, box, r, out):
    """Newton step towards the closest point; Gauss-Newton where the Hessian is not positive."""
    a11, a12, a22 = dot(out[1], out[1]), dot(out[1], out[2]), dot(out[2], out[2])
    g1, g2 = dot(r, out[1]), dot(r, out[2])
    free1 = not ((s <= box[0] and g1 > 0.0) or (s >= box[1] and g1 < 0.0))
    free2 = not ((t <= box[2] and g2 > 0.0) or (t >= box[3] and g2 < 0.0))
    floor = 1e-12 * (a11 + a22) + 1e-300
    h11, h22 = a11 + dot(r, out[3]), a22 + dot(r, out[5])
    h12 = a12 + dot(r, out[4])
    if free1 and free2:
        det = h11 * h22 - h12 * h12
        if h11 <= 0.0 or det <= 1e-6 * a11 * a22 + floor * floor:
            h11, h22, h12 = a11 + floor, a22 + floor, a12
            det = h11 * h22 - h12 * h12
        return -(h22 * g1 - h12 * g2) / det, -(h11 * g2 - h12 * g1) / det
    if free1:
        return -g1 / (h11 if h11 > 0.1 * a11 + floor else a11 + floor), 0.0
    if free2:
        return 0.0, -g2 / (h22 if h22 > 0.1 * a22 + floor else a22 + floor)
    return 0.0, 0.0


@njit(cache=True, error_model="numpy", nogil=True)
def closest(powers, control, x, box, s, t, scratch, out, r):
    """Closest point of a box of a patch to ``x`` by projected Newton from ``(s, t)``.

    Returns ``s, t``, the distance and whether the point is stationary; ``out`` holds the jet
    there. Ends when a step is below a twentieth of the distance: the near rule does not see more.
    """
    jet(powers, control, s, t, scratch, out)
    for c in range(3):
        r[c] = out[0, c] - x[c]
    square, small = dot(r, r), False
    for _ in range(MAX_STEPS):
        ds, dt = descent(s, t, box, r, out)
        moved = False
        for _ in range(6):
            s1 = min(box[1], max(box[0], s + ds))
            t1 = min(box[3], max(box[2], t + dt))
            size = 0.0
            for c in range(3):
                size += (out[1, c] * (s1 - s) + out[2, c] * (t1 - t)) ** 2
            if size <= 1e-4 * square:
                return s1, t1, np.sqrt(square), True
            jet(powers, control, s1, t1, scratch, out)
            for c in range(3):
                r[c] = out[0, c] - x[c]
            new = dot(r, r)
            if new < square:
                small = size <= 2.5e-3 * new
                s, t, square, moved = s1, t1, new, True
                break
            ds, dt = 0.5 * ds, 0.5 * dt
            jet(powers, control, s, t, scratch, out)
        if not moved:
            for c in range(3):
                r[c] = out[0, c] - x[c]
            small = False
            break
        if small:
            break
    return s, t, np.sqrt(square), small


@njit(cache=True, error_model="numpy", nogil=True)
def apart(powers, control, x, s, t, scratch):
    """Distance of one point of a patch from ``x``."""
    n = len(powers)
    basis(powers, s, 0, scratch)
    basis(powers, t, 3 * n, scratch)
    square = 0.0
    for c in range(3):
        y = 0.0
        for i in range(n):
            v = 0.0
            for j in range(n):
                v += scratch[3 * n + j] * control[i, j, c]
            y += scratch[i] * v
        square += (y - x[c]) * (y - x[c])
    return np.sqrt(square)


@njit(cache=True, error_model="numpy", nogil=True)
def behind(net, x, r, limit):
    """Whether a piece lies behind a plane: all of its ``(y - x) . r >= limit``.

    Its control points ``net (n, 3)`` do if so, and it lies in their convex hull.
    """
    for i in range(net.shape[0]):
        if (net[i, 0] - x[0]) * r[0] + (net[i, 1] - x[1]) * r[1] + (net[i, 2] - x[2]) * r[
            2
        ] < limit:
            return False
    return True


@njit(cache=True, error_model="numpy", nogil=True)
def covered(box, s, t, d, convexity, speeds):
    """Whether a stationary point at distance d is the closest one of a box.

    The bounds are those of `hbem.surfaces.subdivision`.
    """
    far1 = speeds[0] * max(abs(s - box[0]), abs(s - box[1]))
    far2 = speeds[1] * max(abs(t - box[2]), abs(t - box[3]))
    return d + convexity[1] * np.sqrt(far1 * far1 + far2 * far2) / 3.0 < convexity[0]


@njit(cache=True, error_model="numpy", nogil=True)
def search(
    powers, control, x, box, speeds, convexity, smallest, s, t, d, stationary, scratch, out, r,
    stack,
):  # fmt: skip
    """Closest point of a box up to the factor `NEARER` of the distance, from a first guess.

    ``speeds (2,)`` bound ``|x_s|`` and ``|x_t|`` on the box; boxes below `smallest` are left.
    """
    for k in range(4):
        stack[0, k] = box[k]
    top = 1
    while top > 0:
        top -= 1
        if stationary and covered(stack[top], s, t, d, convexity, speeds):
            continue
        a0, a1, c0, c1 = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        sc, tc = 0.5 * (a0 + a1), 0.5 * (c0 + c1)
        half1, half2 = 0.5 * speeds[0] * (a1 - a0), 0.5 * speeds[1] * (c1 - c0)
        away = apart(powers, control, x, sc, tc, scratch)
        if away < NEARER * d:
            s, t, d, stationary = closest(powers, control, x, box, sc, tc, scratch, out, r)
        if away - half1 - half2 >= NEARER * d or half1 + half2 <= smallest or top + 2 > DEEPEST:
            continue
        for k in range(4):
            stack[top + 1, k] = stack[top, k]
        if half1 >= half2:
            stack[top, 1], stack[top + 1, 0] = sc, sc
        else:
            stack[top, 3], stack[top + 1, 2] = tc, tc
        top += 2
    jet(powers, control, s, t, scratch, out)
    return s, t, d


@njit(cache=True, error_model="numpy", nogil=True)
def obliqueness(out, box, floor):
    """Factor on the nodes of a tensor rule: a right angle over the angle between x_s and x_t.

    The integrand on a line of nodes is singular at that angle to it. At a collapsed point (lines
    shorter than the floor) there is no angle.
    """
    a, b = np.sqrt(dot(out[1], out[1])), np.sqrt(dot(out[2], out[2]))
    if min(a * (box[1] - box[0]), b * (box[3] - box[2])) < floor:
        return 1.0
    angle = np.arccos(min(1.0, abs(dot(out[1], out[2])) / (a * b)))
    return min(OBLIQUE, 0.5 * np.pi / max(angle, 1e-3))


@njit(cache=True, error_model="numpy", nogil=True)
def classify(
    span, powers, points, owners, indptr, pieces, elements, boxes, control, nets, starts, st,
    owner_st, radii, flat, convexity, speeds, found,
):  # fmt: skip
    """Closest points of candidate (point, piece) pairs.

    ``starts (n_pieces, n_q, 3)`` are points of each piece at ``st (2, n_q)`` of its box.
    ``owner_st (2, n_t)`` are the local coordinates of outer points on their own elements.
    Stationary points nearer than ``flat (n_pieces,)`` are kept, and points that no other undercuts
    by the piece's control points ``nets (n_pieces, n, 3)``; the rest is ensured by a search with
    the bounds ``speeds, convexity (n_pieces, 2)`` of `hbem.surfaces.subdivision`.
    ``found (n_pairs, 5)`` receives s, t and b1, b2 with ``b_i = d / |x_i|``, all in coordinates of
    the element, and the `obliqueness`; the piece on which the target lies receives `SELF` as b1
    and b2.
    """
    scratch, out = np.empty(9 * len(powers)), np.empty((6, 3))
    r, stack = np.empty(3), np.empty((DEEPEST, 4))
    for p in range(span[0], span[1]):
        x = points[p]
        for k in range(indptr[p], indptr[p + 1]):
            piece = pieces[k]
            e, box = elements[piece], boxes[piece]
            if owners[p] == e:
                q = p % owner_st.shape[1]
                s, t = owner_st[0, q], owner_st[1, q]
                if box[0] <= s <= box[1] and box[2] <= t <= box[3]:
                    found[k, 0], found[k, 1] = s, t
                    found[k, 2], found[k, 3], found[k, 4] = SELF, SELF, 1.0
                    continue
            best, at = 1e300, 0
            for q in range(starts.shape[1]):
                d0 = starts[piece, q, 0] - x[0]
                d1 = starts[piece, q, 1] - x[1]
                d2 = starts[piece, q, 2] - x[2]
                square = d0 * d0 + d1 * d1 + d2 * d2
                # ties go to the first point even after rounding: rotated scenes stay equal
                if square < (1.0 - 1e-9) * best:
                    best, at = square, q
            s = box[0] + (box[1] - box[0]) * st[0, at]
            t = box[2] + (box[3] - box[2]) * st[1, at]
            s, t, d, stationary = closest(powers, control[e], x, box, s, t, scratch, out, r)
            sure = (stationary and d < flat[piece]) or behind(nets[piece], x, r, NEARER * dot(r, r))
            if not sure:
                s, t, d = search(
                    powers, control[e], x, box, speeds[piece], convexity[piece],
                    SMALLEST * radii[piece], s, t, d, stationary, scratch, out, r, stack,
                )  # fmt: skip
            found[k, 0], found[k, 1] = s, t
            found[k, 4] = obliqueness(out, box, 0.5 * radii[piece])
            for i in range(2):
                # the floor: at a collapsed point |x_s| = 0, and d / |x_s| would call it far
                wide = box[2 * i + 1] - box[2 * i]
                size = np.sqrt(dot(out[1 + i], out[1 + i]))
                found[k, 2 + i] = d * wide / max(size * wide, 0.5 * radii[piece])
