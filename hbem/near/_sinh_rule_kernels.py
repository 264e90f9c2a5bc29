"""Compiled moments of near pairs: integrals of the kernels times the Bernstein polynomials.

Pairs whose rules have equally many nodes are worked out side by side, `LANES` at a time. Rows of
nodes along s at fixed t reuse the patch's polynomial in s; moments are summed by row, then over
t. The plain rule that the far field adds back is subtracted in the same pass.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .._stokes_kernels import OVER_8_PI
from ._closest_point_kernels import SMALLEST
from ._patch_lane_kernels import LANES, clear, exponentials, lane, node_table, row_polynomials
from ._polar_rule_kernels import EDGES, RAY, metric, polar_pass, triangle
from ._vector_kernels import add_nodes, add_row

POLAR = 65532  # first of four keys of polar rules: usual or doubled, without or with plain rule


@njit(cache=True, error_model="numpy", nogil=True)
def order(offset, slope, b, oblique, largest):
    """Number of sinh nodes at relative distance b."""
    n = int(np.ceil(oblique * (offset - slope * np.log(max(b, SMALLEST)))))
    return min(max(n, 4), largest)


@njit(cache=True, error_model="numpy", nogil=True)
def sides(centre, low, high, split):
    """Which parts of ``[low, high]`` beside the centre carry nodes of their own: left, right."""
    if not split:
        return 0, 1
    edge = 1e-9 * (high - low)
    left, right = centre - low > edge, high - centre > edge
    return (1 if left else 0), (1 if right or not left else 0)


@njit(cache=True, error_model="numpy", nogil=True)
def choose(span, found, boxes, elements, collapsed, plain, rule, split, largest, counts, keys):
    """Nodes per direction ``counts (n_pairs, 2)`` and ``keys (n_pairs,)`` of equal rules."""
    for k in range(span[0], span[1]):
        if found[k, 2] < 0.0:
            keys[k] = POLAR + (2 if collapsed[elements[k]] else 0) + plain[k]
            continue
        box = boxes[k]
        for i in range(2):
            low, high = box[2 * i], box[2 * i + 1]
            n = order(rule[0], rule[1], found[k, 2 + i] / (high - low), found[k, 4], largest)
            left, right = sides(found[k, i], low, high, split)
            counts[k, i] = n * (left + right)
        keys[k] = (counts[k, 0] * 128 + counts[k, 1]) * 2 + plain[k]


@njit(cache=True, error_model="numpy", nogil=True, forceinline=True)
def sinh_part(n, centre, b, low, high, nodes, weights, o, v, w):
    """n nodes on ``[low, high]`` from place o on, clustered about ``centre`` at the scale ``b``.

    In the variable v of ``centre + b sinh(v)``; weights lack the factor ``2 cosh(v)``.
    """
    # asinh of positive numbers: np.arcsinh takes twice as long
    up, down = (high - centre) / b, (centre - low) / b
    up, down = np.log(up + np.sqrt(1.0 + up * up)), np.log(down + np.sqrt(1.0 + down * down))
    length = up + down
    for k in range(n):
        v[o + k * LANES] = length * nodes[n, k] - down
        w[o + k * LANES] = b * length * weights[n, k]


@njit(cache=True, error_model="numpy", nogil=True)
def sinh_line(total, where, split, nodes, weights, v, w):
    """All nodes of one direction of every lane, split at the centre or not; last a void one.

    ``where (4, LANES)``: closest point, half the scale, beginning and end of the piece.
    """
    for x in range(LANES):
        centre, b = where[x], 2.0 * where[LANES + x]
        low, high = where[2 * LANES + x], where[3 * LANES + x]
        v[total * LANES + x], w[total * LANES + x] = 0.0, 0.0
        left, right = sides(centre, low, high, split)
        n = total // (left + right)
        if left == 1:
            sinh_part(n, centre, b, low, centre, nodes, weights, x, v, w)
            low = centre
        if right == 1:
            sinh_part(n, centre, b, low, high, nodes, weights, left * n * LANES + x, v, w)


@njit(cache=True, error_model="numpy", nogil=True)
def sinh_tables(form, n, where, v, w, growth, tables):
    """Node tables ``(n, m + 1, LANES)`` of a line; weights are those of ``2 x - 1``."""
    size = (len(form[1]) + 1) * LANES
    exponentials(v[: n * LANES], growth[: n * LANES])
    for k in range(n):
        u, factor, grown = lane(v, k), lane(w, k), lane(growth, k)
        for x in range(LANES):
            e, low, high = grown[x], where[2 * LANES + x], where[3 * LANES + x]
            inverse = 1.0 / e
            at = where[x] + where[LANES + x] * (e - inverse)
            at = at if at > low else low
            u[x] = at if at < high else high
            factor[x] *= e + inverse
        node_table(form, u, factor, tables[k * size : (k + 1) * size])


@njit(cache=True, error_model="numpy", nogil=True)
def plain_tables(form, n, sign, nodes, weights, u, w, tables):
    """Node tables of the plain rule, the same on every lane; last a void one."""
    size = (len(form[1]) + 1) * LANES
    for k in range(n + 1):
        for x in range(LANES):
            u[x], w[x] = nodes[n, k], 2.0 * sign * weights[n, k]
        node_table(form, u, w, tables[k * size : (k + 1) * size])


@njit(cache=True, error_model="numpy", nogil=True)
def tensor_pass(form, n1, n2, shape, s, t, tiny, row, sums, moments):
    """Add a tensor rule of every lane to ``moments (m, m, 6, LANES)``.

    ``s (n1 + 1, m + 1, LANES)``, ``t (n2, m + 1, LANES)`` node tables; the rest is scratch.
    """
    size = (len(form[1]) + 1) * LANES
    for q in range(n2):
        at = t[q * size : (q + 1) * size]
        row_polynomials(form, shape, lane(at, 0), row)
        clear(sums)
        for k in range(0, n1, 2):
            add_nodes(form, row, s[k * size : (k + 2) * size], tiny, sums)
        add_row(form, at[LANES:], sums, moments)


@njit(cache=True, error_model="numpy", nogil=True)
def near_moments(
    span, form, points, point_of, elements, found, boxes, counts, plain, ordered, starts, patches,
    control, collapsed, split, polar, plain_order, nodes, weights, tiny, moments,
):  # fmt: skip
    """Moments ``(n_pairs, (degree + 1)**2, 6)`` of near pairs, by a span of the groups.

    Parameters
    ----------
    form : tuple of three tuples
        As in `_patch_lane_kernels`.
    points, point_of : (n_points, 3), (n_pairs,) array
    elements, boxes : (n_pairs,) int array, (n_pairs, 4) array
        Element and the piece of it, in its local coordinates, that the rule covers.
    found : (n_pairs, 5) array
        Closest point, relative distances and obliqueness in the element's coordinates.
    counts, plain : (n_pairs, 2), (n_pairs,) int array
        Nodes per direction; whether to subtract the plain rule.
    ordered, starts :
        Pairs ordered by equal rules, and the beginning of each group of up to `LANES`.
    patches : (n_elements, 3, g + 1, g + 1) array
        In powers of ``2 s - 1`` and ``2 t - 1``.
    polar : (int, int)
        Radial and angular order; doubled on elements with a collapsed edge.
    """
    m, g = len(form[1]), len(form[0]) - 1
    longest = 2 * nodes.shape[0] * LANES
    shape, where = np.empty(3 * (g + 1) * (g + 1) * LANES), np.empty(8 * LANES)
    v, w, growth = np.empty(longest), np.empty(longest), np.empty(longest)
    s, t = np.empty((m + 1) * longest), np.empty((m + 1) * longest)
    row, values = np.empty(6 * (g + 1) * LANES), np.empty(12 * LANES)
    sums, total = np.empty(6 * m * LANES), np.empty(6 * m * m * LANES)
    origin, rays, ray = np.empty(2 * LANES), np.empty(4 * RAY * LANES), np.empty(3 * LANES)
    spot, scratch, out = np.empty(4 * LANES), np.empty(9 * (g + 1)), np.empty((6, 3))
    for group in range(span[0], span[1]):
        begin, end = starts[group], starts[group + 1]
        first = ordered[begin]
        n1, n2 = counts[first, 0], counts[first, 1]
        own = found[first, 2] < 0.0
        for x in range(LANES):
            k = ordered[min(begin + x, end - 1)]
            e, box = elements[k], boxes[k]
            for c in range(3):
                for i in range(g + 1):
                    for j in range(g + 1):
                        shape[((c * (g + 1) + i) * (g + 1) + j) * LANES + x] = patches[e, c, i, j]
                shape[c * (g + 1) * (g + 1) * LANES + x] -= points[point_of[k], c]
            s0, t0 = found[k, 0], found[k, 1]
            if own:
                origin[x], origin[LANES + x] = s0, t0
                metric_at = metric(form[0], control[e], s0, t0, scratch, out)
                for i in range(4):
                    part = rays[i * RAY * LANES : (i + 1) * RAY * LANES]
                    triangle(s0, t0, box, EDGES[i], metric_at, x, part)
            else:
                for i in range(2):
                    low, high, o = box[2 * i], box[2 * i + 1], 4 * i * LANES + x
                    where[o], where[2 * LANES + o], where[3 * LANES + o] = found[k, i], low, high
                    where[LANES + o] = 0.5 * max(found[k, 2 + i], SMALLEST * (high - low))
        clear(total)
        if own:
            double = 2 if collapsed[elements[first]] else 1
            for i in range(4):
                polar_pass(
                    form, double * polar[0], double * polar[1], shape, origin,
                    rays[i * RAY * LANES : (i + 1) * RAY * LANES], nodes, weights, tiny, ray,
                    spot, s, t, row, values, total,
                )  # fmt: skip
        else:
            sinh_line(n1, where, split, nodes, weights, v, w)
            sinh_tables(form, n1 + 1, where, v, w, growth, s)
            sinh_line(n2, where[4 * LANES :], split, nodes, weights, v, w)
            sinh_tables(form, n2, where[4 * LANES :], v, w, growth, t)
            tensor_pass(form, n1, n2, shape, s, t, tiny, row, sums, total)
        if plain[first] == 1:
            plain_tables(form, plain_order, -1.0, nodes, weights, v, w, s)
            plain_tables(form, plain_order, 1.0, nodes, weights, v, w, t)
            tensor_pass(form, plain_order, plain_order, shape, s, t, tiny, row, sums, total)
        for x in range(end - begin):
            line = moments[ordered[begin + x]]
            for b in range(m * m):
                for c in range(6):
                    line[b, c] = OVER_8_PI * total[(6 * b + c) * LANES + x]
