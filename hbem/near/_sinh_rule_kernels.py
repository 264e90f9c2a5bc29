"""Compiled moments of near pairs: integrals of the kernels times the Bernstein polynomials.

Pairs whose rules have equally many nodes are worked out side by side, `LANES` at a time. Rows of
nodes along s at fixed t reuse the patch's polynomial in s; moments are summed by row, then over
t. The plain rule that the far field adds back is subtracted in the same pass.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ._closest_point_kernels import SMALLEST
from ._patch_lane_kernels import LANES, bernstein_lanes, lane, row_polynomials
from ._polar_rule_kernels import EDGES, RAY, metric, polar_pass, triangle
from ._vector_kernels import add_node, add_nodes, clear, kernel_values

BLOCKS = 32  # sets of buffers: few, as allocating them takes turns
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


@njit(cache=True, error_model="numpy", nogil=True)
def sinh_part(n, centre, b, low, high, nodes, weights, x, line, w):
    """n nodes on ``[low, high]`` at lane x, clustered about ``centre`` at the scale ``b``.

    Weights are those of ``2 x - 1``, in which the patches are given.
    """
    start = np.arcsinh((low - centre) / b)
    length = np.arcsinh((high - centre) / b) - start
    for k in range(n):
        e = np.exp(start + length * nodes[n, k])
        line[k * LANES + x] = min(high, max(low, centre + 0.5 * b * (e - 1.0 / e)))
        w[k * LANES + x] = b * (e + 1.0 / e) * length * weights[n, k]


@njit(cache=True, error_model="numpy", nogil=True)
def sinh_line(total, centre, b, low, high, split, nodes, weights, x, line, w):
    """All nodes of one direction of one pair, split at the centre or not."""
    b = max(b, SMALLEST * (high - low))
    left, right = sides(centre, low, high, split)
    n = total // (left + right)
    if left == 1:
        sinh_part(n, centre, b, low, centre, nodes, weights, x, line, w)
        line, w = line[n * LANES :], w[n * LANES :]
        low = centre
    if right == 1:
        sinh_part(n, centre, b, low, high, nodes, weights, x, line, w)


@njit(cache=True, error_model="numpy", nogil=True)
def plain_line(n, sign, nodes, weights, line, w):
    """The nodes of the plain rule, the same on every lane."""
    for k in range(n):
        for x in range(LANES):
            line[k * LANES + x] = nodes[n, k]
            w[k * LANES + x] = 2.0 * sign * weights[n, k]


@njit(cache=True, error_model="numpy", nogil=True)
def tensor_pass(
    n1, n2, g, degree, layer, target, shape, s, ws, t, wt, tiny, sigma, bs, bt, row, place, kernel,
    sums, moments,
):  # fmt: skip
    """Add a tensor rule of every lane to ``moments (m, m, 6, LANES)``, m = degree + 1.

    ``s, ws (n1, LANES)``, ``t, wt (n2, LANES)`` nodes and weights; the rest is scratch.
    """
    m = degree + 1
    wide = 6 * LANES
    for k in range(n1):
        bernstein_lanes(degree, lane(s, k), bs[k * m * LANES : (k + 1) * m * LANES])
        for x in range(LANES):
            sigma[k * LANES + x] = 2.0 * s[k * LANES + x] - 1.0
    for q in range(n2):
        bernstein_lanes(degree, lane(t, q), bt)
        for x in range(LANES):
            place[x] = 2.0 * t[q * LANES + x] - 1.0
        row_polynomials(g, shape, lane(place, 0), row)
        clear(sums[: m * wide])
        k = 0
        while k + 4 <= n1:
            for z in range(4):
                part = kernel[z * wide : (z + 1) * wide]
                kernel_values(
                    g, layer, target, row, lane(sigma, k + z), lane(ws, k + z), lane(wt, q), tiny,
                    place, part,
                )  # fmt: skip
            add_nodes(m, bs[k * m * LANES : (k + 4) * m * LANES], kernel, sums)
            k += 4
        while k < n1:
            kernel_values(
                g, layer, target, row, lane(sigma, k), lane(ws, k), lane(wt, q), tiny, place, kernel
            )
            add_node(m, bs[k * m * LANES : (k + 1) * m * LANES], kernel, sums)
            k += 1
        for i in range(m):
            add_node(m, bt, sums[i * wide : (i + 1) * wide], moments[i * m * wide :])


@njit(cache=True, error_model="numpy", nogil=True)
def near_moments(
    span, points, point_of, elements, found, boxes, counts, plain, ordered, starts, g, shapes,
    control, collapsed, degree, layer, split, polar, plain_order, nodes, weights, tiny, moments,
):  # fmt: skip
    """Moments ``(n_pairs, (degree + 1)**2, 6)`` of near pairs.

    Parameters
    ----------
    points, point_of : (n_points, 3), (n_pairs,) array
    elements, boxes : (n_pairs,) int array, (n_pairs, 4) array
        Element and the piece of it, in its local coordinates, that the rule covers.
    found : (n_pairs, 5) array
        Closest point, relative distances and obliqueness in the element's coordinates.
    counts, plain : (n_pairs, 2), (n_pairs,) int array
        Nodes per direction; whether to subtract the plain rule.
    ordered, starts :
        Pairs ordered by equal rules, and the beginning of each group of up to `LANES`.
    shapes : (n_elements, 3 * (g + 1)**2) array
        Patches in powers of ``2 s - 1`` and ``2 t - 1``.
    polar : (int, int)
        Radial and angular order; doubled on elements with a collapsed edge.
    """
    m = degree + 1
    largest = 2 * (nodes.shape[0] - 1)
    n_blocks = min(BLOCKS, starts.size - 1)
    for block in range(span[0], span[1]):
        target, shape = np.empty(3 * LANES), np.empty(shapes.shape[1] * LANES)
        s, ws, t, wt = (
            np.empty(largest * LANES), np.empty(largest * LANES), np.empty(largest * LANES),
            np.empty(largest * LANES),
        )  # fmt: skip
        sigma, bs = np.empty(largest * LANES), np.empty(largest * m * LANES)
        bt, row = np.empty(m * LANES), np.empty(6 * (g + 1) * LANES)
        place, kernel = np.empty(9 * LANES), np.empty(24 * LANES)
        sums, total = np.empty(6 * m * LANES), np.empty(6 * m * m * LANES)
        origin, rays, ray = np.empty(2 * LANES), np.empty(4 * RAY * LANES), np.empty(3 * LANES)
        spot, values, one = np.empty(5 * LANES), np.empty(4 * m * m * LANES), np.ones(LANES)
        scratch, out = np.empty((6, max(g, degree) + 2)), np.empty((6, 3))
        # strides mix short and long rules: equal work for every thread
        for group in range(block, starts.size - 1, n_blocks):
            begin, end = starts[group], starts[group + 1]
            first = ordered[begin]
            n1, n2 = counts[first, 0], counts[first, 1]
            own = found[first, 2] < 0.0
            for x in range(LANES):
                k = ordered[min(begin + x, end - 1)]
                e, box = elements[k], boxes[k]
                for c in range(3):
                    target[c * LANES + x] = points[point_of[k], c]
                coefficients = shapes[e]
                for c in range(coefficients.size):
                    shape[c * LANES + x] = coefficients[c]
                s0, t0 = found[k, 0], found[k, 1]
                if own:
                    origin[x], origin[LANES + x] = s0, t0
                    form = metric(control[e], s0, t0, scratch, out)
                    for i in range(4):
                        part = rays[i * RAY * LANES : (i + 1) * RAY * LANES]
                        triangle(s0, t0, box, EDGES[i], form, x, part)
                else:
                    b1, b2 = found[k, 2], found[k, 3]
                    sinh_line(n1, s0, b1, box[0], box[1], split, nodes, weights, x, s, ws)
                    sinh_line(n2, t0, b2, box[2], box[3], split, nodes, weights, x, t, wt)
            clear(total)
            if own:
                double = 2 if collapsed[elements[first]] else 1
                for i in range(4):
                    polar_pass(
                        double * polar[0], double * polar[1], g, degree, layer, target, shape,
                        origin, rays[i * RAY * LANES : (i + 1) * RAY * LANES], nodes, weights,
                        tiny, ray, spot, bs, bt, row, place, kernel, values, one, total,
                    )  # fmt: skip
            else:
                tensor_pass(
                    n1, n2, g, degree, layer, target, shape, s, ws, t, wt, tiny, sigma, bs, bt,
                    row, place, kernel, sums, total,
                )  # fmt: skip
            if plain[first] == 1:
                plain_line(plain_order, -1.0, nodes, weights, s, ws)
                plain_line(plain_order, 1.0, nodes, weights, t, wt)
                tensor_pass(
                    plain_order, plain_order, g, degree, layer, target, shape, s, ws, t, wt, tiny,
                    sigma, bs, bt, row, place, kernel, sums, total,
                )  # fmt: skip
            for x in range(end - begin):
                line = moments[ordered[begin + x]]
                for b in range(m * m):
                    for c in range(6):
                        line[b, c] = total[(6 * b + c) * LANES + x]
