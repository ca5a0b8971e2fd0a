"""Solves with the Cholesky factor of `supernodal` for many right sides, as loops over these."""

from __future__ import annotations

import numpy as np

from .._types import FloatArray, IntArray
from .choice import only_loops
from .supernodal import Subtrees
from .supernodes import Supernodes
from .unsigned import FOUR, ONE, THREE, TWO, ZERO, index


def _forward_many(
    values: FloatArray,
    a: Supernodes,
    parts: Subtrees,
    which: IntArray,
    root: int,
    b: FloatArray,
    left: FloatArray,
    x: FloatArray,
) -> None:
    # a look into a tuple counts who refers to the array
    order, start, below, value_start = a.order, a.start, a.below, a.value_start
    below_start, number, rows = a.below_start, parts.number, parts.rows
    end = index(start[root + 1] if root >= 0 else len(order))
    sides = index(b.shape[1])
    y, above = np.empty((a.front, sides), values.dtype), np.empty((len(order) - end, sides), values.dtype)
    if root >= 0:
        for i in range(below_start[root], below_start[root + 1]):
            for c in range(sides):
                above[below[i] - end, c] = 0.0
    for s in which:
        first, under = index(start[s]), index(below_start[s])
        width, m = index(start[s + 1]) - first, index(below_start[s + 1]) - under
        if number[s] >= 0 and s != root:
            begin = index(rows[number[s]])
            for i in range(m):
                for c in range(sides):
                    x[below[under + i], c] += left[begin + i, c]
            continue
        size, at = width + m, index(value_start[s])
        anything = False
        for j in range(width):
            i = index(order[first + j])
            for c in range(sides):
                y[j, c] = x[first + j, c] + b[i, c]
                anything |= y[j, c] != 0.0
        if not anything:
            continue
        for i in range(width, size):
            for c in range(sides):
                y[i, c] = 0.0
        j = ZERO
        while j < width & THREE:
            k0 = at + j * size + j
            for c in range(sides):
                y[j, c] *= values[k0]
            for i in range(ONE, size - j):
                e = values[k0 + i]
                for c in range(sides):
                    y[j + i, c] -= e * y[j, c]
            j += ONE
        while j < width:
            k0 = at + j * size + j
            for q in range(FOUR):
                d = values[k0 + q * size + q]
                for p in range(q):
                    e = values[k0 + p * size + q]
                    for c in range(sides):
                        y[j + q, c] -= e * y[j + p, c]
                for c in range(sides):
                    y[j + q, c] *= d
            k1, k2, k3 = k0 + size, k0 + TWO * size, k0 + THREE * size
            for i in range(FOUR, size - j):
                e, r, t, d = values[k0 + i], values[k1 + i], values[k2 + i], values[k3 + i]
                for c in range(sides):
                    y[j + i, c] -= e * y[j, c] + r * y[j + ONE, c] + t * y[j + TWO, c] + d * y[j + THREE, c]
            j += FOUR
        for j in range(width):
            for c in range(sides):
                x[first + j, c] = y[j, c]
        for i in range(m):
            r = index(below[under + i])
            if r < end:
                for c in range(sides):
                    x[r, c] += y[width + i, c]
            else:
                for c in range(sides):
                    above[r - end, c] += y[width + i, c]
    if root >= 0:
        begin, under = index(rows[number[root]]), index(below_start[root])
        for i in range(index(below_start[root + 1]) - under):
            for c in range(sides):
                left[begin + i, c] = above[below[under + i] - end, c]


forward_many = only_loops(_forward_many)
forward_many.__doc__ = """`forward_two` for any number of right sides, (n, k)."""


def _backward_many(
    values: FloatArray,
    a: Supernodes,
    parts: Subtrees,
    which: IntArray,
    root: int,
    x: FloatArray,
    made: FloatArray,
) -> None:
    order, start, below, value_start = a.order, a.start, a.below, a.value_start
    below_start, number = a.below_start, parts.number
    sides = index(x.shape[1])
    y = np.empty((a.front, sides), values.dtype)
    for s in which[::-1]:
        if number[s] >= 0 and s != root:
            continue
        first, under = index(start[s]), index(below_start[s])
        width, m = index(start[s + 1]) - first, index(below_start[s + 1]) - under
        size, at = width + m, index(value_start[s])
        for j in range(width):
            for c in range(sides):
                y[j, c] = x[first + j, c]
        for i in range(m):
            r = index(below[under + i])
            for c in range(sides):
                y[width + i, c] = x[r, c]
        j = width
        while j >= FOUR:
            j -= FOUR
            k0 = at + j * size + j
            k1, k2, k3 = k0 + size, k0 + TWO * size, k0 + THREE * size
            for i in range(FOUR, size - j):
                e, r, t, d = values[k0 + i], values[k1 + i], values[k2 + i], values[k3 + i]
                for c in range(sides):
                    p = y[j + i, c]
                    y[j, c] -= e * p
                    y[j + ONE, c] -= r * p
                    y[j + TWO, c] -= t * p
                    y[j + THREE, c] -= d * p
            for left in range(FOUR):
                q = THREE - left
                for p in range(q + ONE, FOUR):
                    e = values[k0 + q * size + p]
                    for c in range(sides):
                        y[j + q, c] -= e * y[j + p, c]
                d = values[k0 + q * size + q]
                for c in range(sides):
                    y[j + q, c] *= d
        while j > ZERO:
            j -= ONE
            k0 = at + j * size + j
            for i in range(ONE, size - j):
                e = values[k0 + i]
                for c in range(sides):
                    y[j, c] -= e * y[j + i, c]
            for c in range(sides):
                y[j, c] *= values[k0]
        for j in range(width):
            r = index(order[first + j])
            for c in range(sides):
                x[first + j, c] = made[r, c] = y[j, c]


backward_many = only_loops(_backward_many)
backward_many.__doc__ = """`backward_two` for any number of right sides, (n, k)."""
