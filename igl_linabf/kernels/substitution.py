"""Solves with the Cholesky factor of `supernodal`, as loops: for one right side, or two.

All indices are unsigned: loops need not look for negative ones. There are no slices and parts, which count
who refers to an array: that would take as long as the few products of a small supernode.
"""

from __future__ import annotations

import numpy as np

from .._types import FloatArray, IntArray
from .choice import only_loops
from .supernodal import Subtrees
from .supernodes import Supernodes
from .unsigned import FOUR, ONE, THREE, TWO, ZERO, index


def _forward_two(
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
    y, above = np.empty((a.front, 2), values.dtype), np.empty((len(order) - end, 2), values.dtype)
    if root >= 0:
        for i in range(below_start[root], below_start[root + 1]):
            above[below[i] - end, 0] = above[below[i] - end, 1] = 0.0
    for s in which:
        first, under = index(start[s]), index(below_start[s])
        width, m = index(start[s + 1]) - first, index(below_start[s + 1]) - under
        if number[s] >= 0 and s != root:
            begin = index(rows[number[s]])
            for i in range(m):
                r = index(below[under + i])
                x[r, 0] += left[begin + i, 0]
                x[r, 1] += left[begin + i, 1]
            continue
        size, inside, at = width + m, m, index(value_start[s])
        while inside > ZERO and below[under + inside - ONE] >= end:  # those above the subtree come last
            inside -= ONE
        for j in range(width):
            i = index(order[first + j])
            y[j, 0], y[j, 1] = x[first + j, 0] + b[i, 0], x[first + j, 1] + b[i, 1]
        j = ZERO
        while j < width and y[j, 0] == 0.0 and y[j, 1] == 0.0:
            x[first + j, 0], x[first + j, 1] = y[j, 0], y[j, 1]
            j += ONE
        if j == width:  # few supernodes hold anything of a side with few entries
            continue
        for i in range(width, size):
            y[i, 0] = y[i, 1] = 0.0
        j = ZERO
        while j < width & THREE:
            k0 = at + j * size + j
            f, g = y[j, 0] * values[k0], y[j, 1] * values[k0]
            y[j, 0], y[j, 1] = f, g
            for i in range(ONE, size - j):
                y[j + i, 0] -= values[k0 + i] * f
                y[j + i, 1] -= values[k0 + i] * g
            j += ONE
        while j < width:  # four columns at a time
            k0 = at + j * size + j
            k1, k2, k3 = k0 + size, k0 + TWO * size, k0 + THREE * size
            f0, g0 = y[j, 0] * values[k0], y[j, 1] * values[k0]
            e, d = values[k0 + ONE], values[k1 + ONE]
            f1, g1 = (y[j + ONE, 0] - e * f0) * d, (y[j + ONE, 1] - e * g0) * d
            e, r, d = values[k0 + TWO], values[k1 + TWO], values[k2 + TWO]
            f2, g2 = (y[j + TWO, 0] - e * f0 - r * f1) * d, (y[j + TWO, 1] - e * g0 - r * g1) * d
            e, r, t, d = values[k0 + THREE], values[k1 + THREE], values[k2 + THREE], values[k3 + THREE]
            f3 = (y[j + THREE, 0] - e * f0 - r * f1 - t * f2) * d
            g3 = (y[j + THREE, 1] - e * g0 - r * g1 - t * g2) * d
            y[j, 0], y[j + ONE, 0], y[j + TWO, 0], y[j + THREE, 0] = f0, f1, f2, f3
            y[j, 1], y[j + ONE, 1], y[j + TWO, 1], y[j + THREE, 1] = g0, g1, g2, g3
            for i in range(FOUR, size - j):
                e, r, t, d = values[k0 + i], values[k1 + i], values[k2 + i], values[k3 + i]
                y[j + i, 0] -= e * f0 + r * f1 + t * f2 + d * f3
                y[j + i, 1] -= e * g0 + r * g1 + t * g2 + d * g3
            j += FOUR
        for j in range(width):
            x[first + j, 0], x[first + j, 1] = y[j, 0], y[j, 1]
        for i in range(inside):
            r = index(below[under + i])
            x[r, 0] += y[width + i, 0]
            x[r, 1] += y[width + i, 1]
        for i in range(inside, m):
            r = below[under + i] - end
            above[r, 0] += y[width + i, 0]
            above[r, 1] += y[width + i, 1]
    if root >= 0:
        begin, under = index(rows[number[root]]), index(below_start[root])
        for i in range(index(below_start[root + 1]) - under):
            r = below[under + i] - end
            left[begin + i, 0], left[begin + i, 1] = above[r, 0], above[r, 1]


forward_two = only_loops(_forward_two)
forward_two.__doc__ = (
    """L x = P b for two right sides, b (n, 2), in x, zero at first; `which` as in the factor."""
)


def _forward_one(
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
    y, above = np.empty(a.front, values.dtype), np.empty(len(order) - end, values.dtype)
    if root >= 0:
        for i in range(below_start[root], below_start[root + 1]):
            above[below[i] - end] = 0.0
    for s in which:
        first, under = index(start[s]), index(below_start[s])
        width, m = index(start[s + 1]) - first, index(below_start[s + 1]) - under
        if number[s] >= 0 and s != root:
            begin = index(rows[number[s]])
            for i in range(m):
                x[below[under + i]] += left[begin + i]
            continue
        size, inside, at = width + m, m, index(value_start[s])
        while inside > ZERO and below[under + inside - ONE] >= end:  # those above the subtree come last
            inside -= ONE
        for j in range(width):
            y[j] = x[first + j] + b[index(order[first + j])]
        for i in range(width, size):
            y[i] = 0.0
        j = ZERO
        while j < width & THREE:
            k0 = at + j * size + j
            f = y[j] * values[k0]
            y[j] = f
            for i in range(ONE, size - j):
                y[j + i] -= values[k0 + i] * f
            j += ONE
        while j < width:
            k0 = at + j * size + j
            k1, k2, k3 = k0 + size, k0 + TWO * size, k0 + THREE * size
            f0 = y[j] * values[k0]
            f1 = (y[j + ONE] - values[k0 + ONE] * f0) * values[k1 + ONE]
            f2 = (y[j + TWO] - values[k0 + TWO] * f0 - values[k1 + TWO] * f1) * values[k2 + TWO]
            f3 = y[j + THREE] - values[k0 + THREE] * f0 - values[k1 + THREE] * f1 - values[k2 + THREE] * f2
            f3 *= values[k3 + THREE]
            y[j], y[j + ONE], y[j + TWO], y[j + THREE] = f0, f1, f2, f3
            for i in range(FOUR, size - j):
                y[j + i] -= (
                    values[k0 + i] * f0 + values[k1 + i] * f1 + values[k2 + i] * f2 + values[k3 + i] * f3
                )
            j += FOUR
        for j in range(width):
            x[first + j] = y[j]
        for i in range(inside):
            x[below[under + i]] += y[width + i]
        for i in range(inside, m):
            above[below[under + i] - end] += y[width + i]
    if root >= 0:
        begin, under = index(rows[number[root]]), index(below_start[root])
        for i in range(index(below_start[root + 1]) - under):
            left[begin + i] = above[below[under + i] - end]


forward_one = only_loops(_forward_one)
forward_one.__doc__ = """The same for one right side, (n,)."""


def _backward_two(
    values: FloatArray,
    a: Supernodes,
    parts: Subtrees,
    which: IntArray,
    root: int,
    x: FloatArray,
    made: FloatArray,
) -> None:
    order, start, below, value_start = a.order, a.start, a.below, a.value_start
    below_start, number, zero = a.below_start, parts.number, values.dtype.type(0)
    y, z = np.empty(a.front, values.dtype), np.empty(a.front, values.dtype)
    for s in which[::-1]:
        if number[s] >= 0 and s != root:
            continue
        first, under = index(start[s]), index(below_start[s])
        width, m = index(start[s + 1]) - first, index(below_start[s + 1]) - under
        size, at = width + m, index(value_start[s])
        for j in range(width):
            y[j], z[j] = x[first + j, 0], x[first + j, 1]
        for i in range(m):
            r = index(below[under + i])
            y[width + i], z[width + i] = x[r, 0], x[r, 1]
        j = width
        while j >= FOUR:
            j -= FOUR
            k0 = at + j * size + j
            k1, k2, k3 = k0 + size, k0 + TWO * size, k0 + THREE * size
            f0 = f1 = f2 = f3 = g0 = g1 = g2 = g3 = zero
            for i in range(FOUR, size - j):
                p, q = y[j + i], z[j + i]
                e, r, t, d = values[k0 + i], values[k1 + i], values[k2 + i], values[k3 + i]
                f0 += e * p
                f1 += r * p
                f2 += t * p
                f3 += d * p
                g0 += e * q
                g1 += r * q
                g2 += t * q
                g3 += d * q
            d = values[k3 + THREE]
            f3, g3 = (y[j + THREE] - f3) * d, (z[j + THREE] - g3) * d
            e, d = values[k2 + THREE], values[k2 + TWO]
            f2, g2 = (y[j + TWO] - f2 - e * f3) * d, (z[j + TWO] - g2 - e * g3) * d
            e, r, d = values[k1 + TWO], values[k1 + THREE], values[k1 + ONE]
            f1, g1 = (y[j + ONE] - f1 - e * f2 - r * f3) * d, (z[j + ONE] - g1 - e * g2 - r * g3) * d
            e, r, t, d = values[k0 + ONE], values[k0 + TWO], values[k0 + THREE], values[k0]
            f0, g0 = (y[j] - f0 - e * f1 - r * f2 - t * f3) * d, (z[j] - g0 - e * g1 - r * g2 - t * g3) * d
            y[j], y[j + ONE], y[j + TWO], y[j + THREE] = f0, f1, f2, f3
            z[j], z[j + ONE], z[j + TWO], z[j + THREE] = g0, g1, g2, g3
        while j > ZERO:
            j -= ONE
            k0 = at + j * size + j
            f = g = zero
            for i in range(ONE, size - j):
                f += values[k0 + i] * y[j + i]
                g += values[k0 + i] * z[j + i]
            y[j], z[j] = (y[j] - f) * values[k0], (z[j] - g) * values[k0]
        for j in range(width):
            r = index(order[first + j])
            x[first + j, 0], x[first + j, 1] = y[j], z[j]
            made[r, 0], made[r, 1] = y[j], z[j]


backward_two = only_loops(_backward_two)
backward_two.__doc__ = (
    """L^T P made = x, (n, 2), by the supernodes `which` from the last one on; x is overwritten."""
)


def _backward_one(
    values: FloatArray,
    a: Supernodes,
    parts: Subtrees,
    which: IntArray,
    root: int,
    x: FloatArray,
    made: FloatArray,
) -> None:
    order, start, below, value_start = a.order, a.start, a.below, a.value_start
    below_start, number, zero = a.below_start, parts.number, values.dtype.type(0)
    y = np.empty(a.front, values.dtype)
    for s in which[::-1]:
        if number[s] >= 0 and s != root:
            continue
        first, under = index(start[s]), index(below_start[s])
        width, m = index(start[s + 1]) - first, index(below_start[s + 1]) - under
        size, at = width + m, index(value_start[s])
        for j in range(width):
            y[j] = x[first + j]
        for i in range(m):
            y[width + i] = x[below[under + i]]
        j = width
        while j >= FOUR:
            j -= FOUR
            k0 = at + j * size + j
            k1, k2, k3 = k0 + size, k0 + TWO * size, k0 + THREE * size
            f0 = f1 = f2 = f3 = zero
            for i in range(FOUR, size - j):
                p = y[j + i]
                f0 += values[k0 + i] * p
                f1 += values[k1 + i] * p
                f2 += values[k2 + i] * p
                f3 += values[k3 + i] * p
            f3 = (y[j + THREE] - f3) * values[k3 + THREE]
            f2 = (y[j + TWO] - f2 - values[k2 + THREE] * f3) * values[k2 + TWO]
            f1 = (y[j + ONE] - f1 - values[k1 + TWO] * f2 - values[k1 + THREE] * f3) * values[k1 + ONE]
            f0 = y[j] - f0 - values[k0 + ONE] * f1 - values[k0 + TWO] * f2 - values[k0 + THREE] * f3
            f0 *= values[k0]
            y[j], y[j + ONE], y[j + TWO], y[j + THREE] = f0, f1, f2, f3
        while j > ZERO:
            j -= ONE
            k0 = at + j * size + j
            f = zero
            for i in range(ONE, size - j):
                f += values[k0 + i] * y[j + i]
            y[j] = (y[j] - f) * values[k0]
        for j in range(width):
            x[first + j] = y[j]
            made[index(order[first + j])] = y[j]


backward_one = only_loops(_backward_one)
backward_one.__doc__ = """The same for one right side, (n,)."""
