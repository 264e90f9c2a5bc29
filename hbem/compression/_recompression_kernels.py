"""Compiled recompression of low-rank blocks, and the blocks of an H-matrix one after another.

``A = u^T v`` with rows as vectors. From the Gram matrices ``u u^T = L L^T``, ``v v^T`` the
singular values are those of ``M = L^T (v v^T) L``, ``sigma^2 = eig M``; the projection on the
leading eigenvectors is backward stable, and the lost digits (below 1e-8 of the largest singular
value) matter only for tolerances that take the QR route.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ._cross_approximation_kernels import SAMPLES, cross

DEPENDENT = 1e-13  # squared sine of the angle to earlier vectors that counts as zero
GRAM = 1e-6  # tolerances below take QR and SVD instead of Gram matrices


@njit(cache=True, error_model="numpy", nogil=True)
def gram(u, rank):
    out = np.empty((rank, rank))
    for k in range(rank):
        for j in range(k + 1):
            out[k, j] = np.dot(u[k], u[j])
            out[j, k] = out[k, j]
    return out


@njit(cache=True, error_model="numpy", nogil=True)
def cholesky(a):
    """Lower factor in place; rows that depend on earlier ones get a zero column."""
    n = a.shape[0]
    for j in range(n):
        size = a[j, j]
        for k in range(j):
            size -= a[j, k] * a[j, k]
        root = np.sqrt(size) if size > DEPENDENT * a[j, j] else 0.0
        for i in range(j + 1, n):
            value = a[i, j]
            for k in range(j):
                value -= a[i, k] * a[j, k]
            a[i, j] = value / root if root > 0.0 else 0.0
        a[j, j] = root
        for i in range(j):
            a[i, j] = 0.0


@njit(cache=True, error_model="numpy", nogil=True)
def truncated(squares, goal):
    """Number of leading values (ascending squares) such that the rest sums to <= goal."""
    left, dropped = 0.0, 0
    while dropped < squares.size:
        left += max(squares[dropped], 0.0)
        if left > goal:
            break
        dropped += 1
    return squares.size - dropped


@njit(cache=True, error_model="numpy", nogil=True)
def combine(weights, vectors, rank, out):
    """``out = weights^T vectors[:rank]``, vectors contiguous."""
    for r in range(out.shape[0]):
        line = out[r]
        line[:] = 0.0
        for k in range(rank):
            w, v = weights[k, r], vectors[k]
            for p in range(line.size):
                line[p] += w * v[p]


@njit(cache=True, error_model="numpy", nogil=True)
def recompress(u, v, rank, tolerance, projected):
    """Best approximation of ``u^T v`` to a relative Frobenius tolerance: two arrays of rows."""
    # projected vectors may outnumber their dimensions: QR is the safe route and cheap there
    if tolerance < GRAM or projected:
        qu, ru = np.linalg.qr(np.ascontiguousarray(u[:rank].T))
        qv, rv = np.linalg.qr(np.ascontiguousarray(v[:rank].T))
        w, s, z = np.linalg.svd(np.ascontiguousarray(ru @ np.ascontiguousarray(rv.T)))
        squares = s[::-1] ** 2
        kept = truncated(squares, tolerance * tolerance * squares.sum())
        root = np.sqrt(s[:kept])
        a = np.ascontiguousarray((w[:, :kept] * root).T) @ np.ascontiguousarray(qu.T)
        b = np.ascontiguousarray((z[:kept].T * root).T) @ np.ascontiguousarray(qv.T)
        return a, b
    lower = gram(u, rank)
    cholesky(lower)
    squares, vectors = np.linalg.eigh(lower.T @ gram(v, rank) @ lower)
    kept = truncated(squares, tolerance * tolerance * np.maximum(squares, 0.0).sum())
    w = np.ascontiguousarray(vectors[:, rank - kept :])
    back = w.copy()  # L^-T w
    for i in range(rank - 1, -1, -1):
        scale = 1.0 / lower[i, i] if lower[i, i] > 0.0 else 0.0
        for r in range(kept):
            back[i, r] *= scale
        for k in range(i):
            for r in range(kept):
                back[k, r] -= lower[i, k] * back[i, r]
    forth = lower @ w
    a, b = np.empty((kept, u.shape[1])), np.empty((kept, v.shape[1]))
    for r in range(kept):
        # both factors of one size, so that single precision loses nothing
        root = max(squares[rank - kept + r], 1e-300) ** 0.25
        for k in range(rank):
            back[k, r] *= root
            forth[k, r] /= root
    combine(back, u, rank, a)
    combine(forth, v, rank, b)
    return a, b


@njit(cache=True, error_model="numpy", nogil=True)
def project(vectors, rank, indptr, rows, values, owned, local, n, out):
    """Test point vectors with the functions of a cluster.

    ``vectors (rank, 3 m)`` at points, ``out (rank, 3 n_owned)``; ``indptr, rows, values`` are
    the columns of the weighted basis, ``local`` maps points to places in the cluster.
    """
    m = n
    count = owned.size
    for r in range(rank):
        for a in range(count):
            s0, s1, s2 = 0.0, 0.0, 0.0
            for k in range(indptr[owned[a]], indptr[owned[a] + 1]):
                p, w = local[rows[k]], values[k]
                s0 += w * vectors[r, p]
                s1 += w * vectors[r, m + p]
                s2 += w * vectors[r, 2 * m + p]
            out[r, a] = s0
            out[r, count + a] = s1
            out[r, 2 * count + a] = s2


@njit(cache=True, error_model="numpy", nogil=True)
def compress_blocks(
    blocks, numbers, positions, normals, tiny, item_ptr, items, point_ptr, points,
    basis_ptr, basis_rows, basis_values, tolerances, full_rank, store,
):  # fmt: skip
    """Low-rank factors of some blocks, one after the other.

    Parameters
    ----------
    blocks : (n, 2) int array
        Nodes t and s; ``numbers (n,)`` seed their samples.
    positions, normals : (3, n_points) array
        ``normals (3, 0)`` for the single layer.
    item_ptr, items, point_ptr, points :
        Items of each node and the points of their supports, by node.
    basis_ptr, basis_rows, basis_values :
        Columns of the weighted basis; empty values where items are the points themselves.
    tolerances : (2,) array
        Of the cross approximation and of the recompression.
    full_rank : float
        A rank above this share of ``m n / (m + n)`` items does not pay: rank -1.
    store : (k,) array
        Scratch in the precision of the result.

    Returns
    -------
    ranks : (n,) int array
    store : (k,) array
        Factors of t, then of s, block by block, ``(rank, 3 n_items)`` each.
    """
    n = blocks.shape[0]
    ranks = np.empty(n, np.int64)
    used = 0
    plain = basis_values.size == 0
    local = np.empty(0 if plain else positions.shape[1], np.int64)
    for k in range(n):
        t, s = blocks[k]
        pt = points[point_ptr[t] : point_ptr[t + 1]]
        ps = points[point_ptr[s] : point_ptr[s + 1]]
        it, is_ = items[item_ptr[t] : item_ptr[t + 1]], items[item_ptr[s] : item_ptr[s + 1]]
        m, q = pt.size, ps.size
        x, y = np.empty((3, m)), np.empty((3, q))
        ny = np.empty((3, q if normals.shape[1] > 0 else 0))
        for c in range(3):
            for i in range(m):
                x[c, i] = positions[c, pt[i]]
            for j in range(q):
                y[c, j] = positions[c, ps[j]]
            for j in range(ny.shape[1]):
                ny[c, j] = normals[c, ps[j]]
        share = it.size * is_.size / (it.size + is_.size)
        limit = min(3 * min(m, q), int((3.0 if plain else 2.0) * full_rank * share))
        u, v = np.empty((limit + 3, 3 * m)), np.empty((limit + 3, 3 * q))
        samples = np.empty((SAMPLES, 3, 3 * q))
        scratch = np.zeros((7, 3 * max(m, q)))
        rank = cross(
            x, y, ny, tiny, tolerances[0], limit, numbers[k], u, v, samples, scratch
        )  # fmt: skip
        if rank > 0 and not plain:
            for i in range(m):
                local[pt[i]] = i
            ut = np.empty((rank, 3 * it.size))
            project(u, rank, basis_ptr, basis_rows, basis_values, it, local, m, ut)
            for j in range(q):
                local[ps[j]] = j
            vs = np.empty((rank, 3 * is_.size))
            project(v, rank, basis_ptr, basis_rows, basis_values, is_, local, q, vs)
            u, v = ut, vs
        if rank > 0:
            u, v = recompress(u, v, rank, tolerances[1], not plain)
            rank = u.shape[0]
            if rank > full_rank * share:
                rank = -1
        ranks[k] = rank
        if rank > 0:
            need = rank * 3 * (it.size + is_.size)
            if used + need > store.size:
                larger = np.empty(max(2 * store.size, used + need), store.dtype)
                larger[:used] = store[:used]
                store = larger
            for part in (u, v):
                for r in range(rank):
                    line = part[r]
                    for p in range(line.size):
                        store[used + p] = line[p]
                    used += line.size
    return ranks, store[:used].copy()
