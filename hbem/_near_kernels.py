"""Compiled classification of (point, piece) pairs by their closest points."""

from __future__ import annotations

import numpy as np
from numba import njit, prange

from .near._closest_point_kernels import DEEPEST, SMALLEST, closest, dot, search

SELF = -1.0  # marks the pair of a point with its own element
OBLIQUE = 2.0  # largest factor on the nodes of a near rule


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


@njit(cache=True, error_model="numpy", nogil=True, parallel=True)
def classify(
    points, owners, indptr, pieces, elements, boxes, control, starts, st, owner_st, radii,
    flat, convexity, speeds, found,
):  # fmt: skip
    """Closest points of candidate (point, piece) pairs.

    ``starts (n_pieces, n_q, 3)`` are points of each piece at ``st (2, n_q)`` of its box.
    ``owner_st (2, n_t)`` are the local coordinates of outer points on their own elements.
    Stationary points nearer than ``flat (n_pieces,)`` are kept; all others are ensured by a search
    with the bounds ``speeds, convexity (n_pieces, 2)`` of `hbem.surfaces.subdivision`.
    ``found (n_pairs, 5)`` receives s, t and b1, b2 with ``b_i = d / |x_i|``, all in coordinates of
    the element, and the `obliqueness`; the piece on which the target lies receives `SELF` as b1
    and b2.
    """
    for p in prange(points.shape[0]):
        scratch = np.empty((6, control.shape[1] + 1))
        out = np.empty((6, 3))
        r = np.empty(3)
        stack = np.empty((DEEPEST, 4))
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
            s, t, d, stationary = closest(control[e], x, box, s, t, scratch, out, r)
            if not (stationary and d < flat[piece]):
                s, t, d = search(
                    control[e], x, box, speeds[piece], convexity[piece], SMALLEST * radii[piece],
                    s, t, d, stationary, scratch, out, r, stack,
                )  # fmt: skip
            found[k, 0], found[k, 1] = s, t
            found[k, 4] = obliqueness(out, box, 0.5 * radii[piece])
            for i in range(2):
                # the floor: at a collapsed point |x_s| = 0, and d / |x_s| would call it far
                wide = box[2 * i + 1] - box[2 * i]
                size = np.sqrt(dot(out[1 + i], out[1 + i]))
                found[k, 2 + i] = d * wide / max(size * wide, 0.5 * radii[piece])
