"""Compiled assembly of contact blocks between vertices into a matrix of coefficients."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy", nogil=True)
def local_functions(vertices, start, index, value, n):
    """Basis functions that the vertices ``(k, p)`` of each contact see.

    ``start, index, value`` are the sampling matrix by rows, ``n`` its columns. Returns their
    number ``(k,)``, the functions ``(k, most)`` and their values at the vertices
    ``(k, p, most)``.
    """
    most = 1
    for c in range(len(vertices)):
        size = 0
        for v in vertices[c]:
            size += start[v + 1] - start[v]
        most = max(most, size)
    numbers = np.zeros(len(vertices), np.int64)
    functions = np.empty((len(vertices), most), np.int32)
    corners = vertices.shape[1]
    values = np.zeros((len(vertices), corners, most))
    place = np.full(n, -1, np.int64)
    for c in range(len(vertices)):
        size = 0
        for v in range(corners):
            for j in range(start[vertices[c, v]], start[vertices[c, v] + 1]):
                a = index[j]
                if place[a] < 0:
                    place[a] = size
                    functions[c, size] = a
                    size += 1
                values[c, v, place[a]] += value[j]
        for j in range(size):
            place[functions[c, j]] = -1
        numbers[c] = size
    return numbers, functions, values


@njit(cache=True, error_model="numpy", nogil=True)
def by_function(numbers, functions, n):
    """Contacts that each function takes part in, and its place among theirs."""
    begin = np.zeros(n + 1, np.int64)
    for c in range(len(numbers)):
        for j in range(numbers[c]):
            begin[functions[c, j] + 1] += 1
    for a in range(n):
        begin[a + 1] += begin[a]
    contacts, fill = np.empty((begin[n], 2), np.int32), begin[:-1].copy()
    for c in range(len(numbers)):
        for j in range(numbers[c]):
            a = functions[c, j]
            contacts[fill[a], 0], contacts[fill[a], 1] = c, j
            fill[a] += 1
    return begin, contacts


@njit(cache=True, error_model="numpy", nogil=True)
def partners(begin, contacts, numbers, functions, n):
    """Sorted functions that share a contact with each function, as rows of a sparse matrix."""
    mark, seen = np.full(n, -1, np.int64), np.empty(n, np.int32)
    starts, columns = np.zeros(n + 1, np.int64), np.empty(64 * len(numbers) + 64, np.int32)
    for a in range(n):
        size = 0
        for place in range(begin[a], begin[a + 1]):
            c = contacts[place, 0]
            for j in range(numbers[c]):
                b = functions[c, j]
                if mark[b] != a:
                    mark[b] = a
                    seen[size] = b
                    size += 1
        first = starts[a]
        if first + size > len(columns):
            more = np.empty(2 * (first + size), np.int32)
            more[:first] = columns[:first]
            columns = more
        columns[first : first + size] = np.sort(seen[:size])
        starts[a + 1] = first + size
    return starts, columns[: starts[n]]


@njit(cache=True, error_model="numpy", nogil=True)
def coefficient_matrix(blocks, vertices, start, index, value, n):
    """``S^T H S`` as rows of a ``(3 n, 3 n)`` sparse matrix, from blocks ``(k, p, 3, p, 3)``."""
    corners = vertices.shape[1]
    numbers, functions, values = local_functions(vertices, start, index, value, n)
    begin, contacts = by_function(numbers, functions, n)
    starts, columns = partners(begin, contacts, numbers, functions, n)
    pointer = np.empty(3 * n + 1, np.int32)
    indices, data = np.empty(9 * len(columns), np.int32), np.empty(9 * len(columns))
    dense, half = np.zeros((n, 3, 3)), np.empty((corners, 3, 3))
    pointer[0] = 0
    for a in range(n):
        for place in range(begin[a], begin[a + 1]):
            c, j = contacts[place]
            for q in range(corners):
                for k in range(3):
                    for m in range(3):
                        total = 0.0
                        for p in range(corners):
                            total += values[c, p, j] * blocks[c, p, k, q, m]
                        half[q, k, m] = total
            for i in range(numbers[c]):
                target = dense[functions[c, i]]
                for q in range(corners):
                    weight = values[c, q, i]
                    if weight != 0.0:
                        for k in range(3):
                            for m in range(3):
                                target[k, m] += weight * half[q, k, m]
        size = starts[a + 1] - starts[a]
        for k in range(3):
            out = 9 * starts[a] + 3 * k * size
            for j in range(size):
                b = columns[starts[a] + j]
                for m in range(3):
                    indices[out + 3 * j + m] = 3 * b + m
                    data[out + 3 * j + m] = dense[b, k, m]
            pointer[3 * a + k + 1] = out + 3 * size
        for j in range(size):
            dense[columns[starts[a] + j]] = 0.0
    return data, indices, pointer
