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
    most, corners = 1, vertices.shape[1]
    for c in range(len(vertices)):
        size = 0
        for p in range(corners):
            size += start[vertices[c, p] + 1] - start[vertices[c, p]]
        most = max(most, size)
    numbers = np.zeros(len(vertices), np.int64)
    functions = np.empty((len(vertices), most), np.int32)
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
def partners(begin, contacts, numbers, functions, n, starts, columns):
    """Functions that share a contact with each function, as rows of a sparse matrix.

    ``starts (n + 1,)`` and ``columns`` are filled; too short columns are counted only.
    """
    mark, place = np.full(n, -1, np.int64), 0
    starts[0] = 0
    for a in range(n):
        for j in range(begin[a], begin[a + 1]):
            c = contacts[j, 0]
            for i in range(numbers[c]):
                b = functions[c, i]
                if mark[b] != a:
                    mark[b] = a
                    if place < len(columns):
                        columns[place] = b
                    place += 1
        starts[a + 1] = place


@njit(cache=True, error_model="numpy", nogil=True)
def coefficient_matrix(blocks, vertices, start, index, value, n):
    """``S^T H S`` as rows of a ``(3 n, 3 n)`` sparse matrix, from blocks ``(k, p, 3, p, 3)``."""
    corners = vertices.shape[1]
    numbers, functions, values = local_functions(vertices, start, index, value, n)
    begin, contacts = by_function(numbers, functions, n)
    starts = np.empty(n + 1, np.int64)
    partners(begin, contacts, numbers, functions, n, starts, np.empty(0, np.int32))
    columns = np.empty(starts[n], np.int32)
    partners(begin, contacts, numbers, functions, n, starts, columns)
    pointer = np.empty(3 * n + 1, np.int32)
    indices, data = np.empty(9 * len(columns), np.int32), np.empty(9 * len(columns))
    dense, half = np.zeros((n, 3, 3)), np.empty((corners, 3, 3))
    pointer[0] = 0
    for a in range(n):
        for place in range(begin[a], begin[a + 1]):
            c, j = contacts[place, 0], contacts[place, 1]
            for q in range(corners):
                for k in range(3):
                    for m in range(3):
                        total = 0.0
                        for p in range(corners):
                            total += values[c, p, j] * blocks[c, p, k, q, m]
                        half[q, k, m] = total
            for i in range(numbers[c]):
                b = functions[c, i]
                for q in range(corners):
                    weight = values[c, q, i]
                    if weight != 0.0:
                        for k in range(3):
                            for m in range(3):
                                dense[b, k, m] += weight * half[q, k, m]
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
            b = columns[starts[a] + j]
            for k in range(3):
                for m in range(3):
                    dense[b, k, m] = 0.0
    return data, indices, pointer
