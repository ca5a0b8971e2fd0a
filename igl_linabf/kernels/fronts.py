"""The Cholesky factor of a sparse matrix by fronts, and solves with it, as loops (Duff, Reid 1983).

The front of a supernode is a dense matrix: the rows of A that belong to its columns, and what its children in
the elimination tree leave. Its columns are eliminated; what is left goes to its parent. Subtrees do not touch
each other, so threads work at several of them at a time; the supernodes above them come after. The loops are
for one subtree, or for the rest. There is no form in NumPy: CHOLMOD's factor, in the same order, defines
this one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._types import FloatArray, IntArray
from .choice import inlined, only_loops
from .supernodes import Supernodes

WIDTH = 4  # columns that are eliminated together
PANEL = 64  # columns whose effect on the rest is added up


class Subtrees(NamedTuple):
    """Subtrees of an elimination tree, and the supernodes above them.

    Attributes
    ----------
    number : (#s,) int64
        Of which subtree a supernode is the root; -1 for others.
    left, rows : (#subtrees + 1,) int64
        Where what a root leaves begins: its matrix, and the rows of a right side.
    """

    number: IntArray
    left: IntArray
    rows: IntArray


class Work(NamedTuple):
    """Work space: the stack of what fronts leave, a front, places of rows in fronts."""

    stack: FloatArray
    space: FloatArray
    place: IntArray
    local: IntArray

    @classmethod
    def of(cls, a: Supernodes) -> Work:
        places = (np.empty(n, dtype=np.int64) for n in (len(a.order), a.front))
        return cls(np.empty(a.stack), np.empty(a.front**2), *places)


@inlined
def _take_away(F: FloatArray, p: int, last: int, first: int, until: int) -> None:
    """What eliminated columns `p` to `last` of a front take from the columns `first` to `until`.

    Four columns are taken from four at a time, which then stay in the processor's registers and caches.
    """
    size, fours = len(F), p + (last - p) // WIDTH * WIDTH
    whole = first + (until - first) // WIDTH * WIDTH
    for j in range(first, whole, WIDTH):
        for k in range(p, fours, WIDTH):
            for c in range(3):  # the corner, of which there is a triangle only
                for r in range(c, 3):
                    for t in range(k, k + WIDTH):
                        F[j + c, j + r] -= F[t, j + c] * F[t, j + r]
            x0, x1, x2, x3 = F[k, j + 3 :], F[k + 1, j + 3 :], F[k + 2, j + 3 :], F[k + 3, j + 3 :]
            y0, y1, y2, y3 = F[j, j + 3 :], F[j + 1, j + 3 :], F[j + 2, j + 3 :], F[j + 3, j + 3 :]
            a0, a1, a2, a3 = F[k, j], F[k + 1, j], F[k + 2, j], F[k + 3, j]
            b0, b1, b2, b3 = F[k, j + 1], F[k + 1, j + 1], F[k + 2, j + 1], F[k + 3, j + 1]
            c0, c1, c2, c3 = F[k, j + 2], F[k + 1, j + 2], F[k + 2, j + 2], F[k + 3, j + 2]
            d0, d1, d2, d3 = F[k, j + 3], F[k + 1, j + 3], F[k + 2, j + 3], F[k + 3, j + 3]
            for i in range(size - j - 3):
                u, v, w, z = x0[i], x1[i], x2[i], x3[i]
                y0[i] -= a0 * u + a1 * v + a2 * w + a3 * z
                y1[i] -= b0 * u + b1 * v + b2 * w + b3 * z
                y2[i] -= c0 * u + c1 * v + c2 * w + c3 * z
                y3[i] -= d0 * u + d1 * v + d2 * w + d3 * z
    for j in range(first, until):
        for k in range(fours if j < whole else p, last):
            share, x, y = F[k, j], F[k, j:], F[j, j:]
            for i in range(size - j):
                y[i] -= share * x[i]


@inlined
def _eliminate(F: FloatArray, width: int) -> int:
    """Eliminate the first columns of a front, `F[column, row]`; the bad pivot, or -1."""
    size = len(F)
    for first in range(0, width, PANEL):
        last = min(first + PANEL, width)
        for p in range(first, last, WIDTH):
            end = min(p + WIDTH, last)
            for k in range(p, end):
                if not F[k, k] > 0:
                    return k
                root = np.sqrt(F[k, k])
                x = F[k, k:]
                for i in range(size - k):
                    x[i] /= root
                for j in range(k + 1, end):
                    share, x, y = F[k, j], F[k, j:], F[j, j:]
                    for i in range(size - j):
                        y[i] -= share * x[i]
            _take_away(F, p, end, end, last)
        _take_away(F, first, last, last, size)
    return -1


def _factor(
    data: FloatArray,
    a: Supernodes,
    parts: Subtrees,
    which: IntArray,
    root: int,
    left: FloatArray,
    values: FloatArray,
    work: Work,
) -> int:
    stack, space, place, local = work
    waiting, last, top = np.empty(len(which), dtype=np.int64), 0, 0
    for s in which:
        if parts.number[s] >= 0 and s != root:  # it is done
            waiting[last] = s
            last += 1
            continue
        first, width = a.start[s], a.start[s + 1] - a.start[s]
        below = a.below[a.below_start[s] : a.below_start[s + 1]]
        size = width + len(below)
        F = space[: size * size].reshape(size, size)
        for j in range(size):
            F[j, j:] = 0.0
        for j in range(width):
            place[first + j] = j
        for k in range(len(below)):
            place[below[k]] = width + k
        for j in range(width):
            for p in range(a.column[first + j], a.column[first + j + 1]):
                F[j, place[a.row[p]]] += data[a.source[p]]
        while last and a.parent[waiting[last - 1]] == s:  # in postorder, the children are on top
            last -= 1
            c = waiting[last]
            rows = a.below[a.below_start[c] : a.below_start[c + 1]]
            many = len(rows)
            if parts.number[c] >= 0:
                begin = parts.left[parts.number[c]]
                of_child = left[begin : begin + many * many].reshape(many, many)
            else:
                top -= many * many
                of_child = stack[top : top + many * many].reshape(many, many)
            for k in range(many):
                local[k] = place[rows[k]]
            for j in range(many):
                for i in range(j, many):
                    F[local[j], local[i]] += of_child[j, i]
        bad = _eliminate(F, width)
        if bad >= 0:
            return int(first + bad)
        L = values[a.value_start[s] : a.value_start[s + 1]].reshape(width, size)
        for j in range(width):
            L[j, j:] = F[j, j:]
        if not len(below):
            continue
        many = len(below)
        if s == root:
            begin = parts.left[parts.number[s]]
            kept = left[begin : begin + many * many].reshape(many, many)
        else:
            kept = stack[top : top + many * many].reshape(many, many)
            top += many * many
            waiting[last] = s
            last += 1
        for j in range(many):
            kept[j, j:] = F[width + j, width + j :]
    return -1


supernodal_factor = only_loops(_factor)
supernodal_factor.__doc__ = """Fill L's values by the supernodes `which`; the place of a bad pivot, or -1.

They are those of the subtree with this root, in order. With root -1 they are those above all subtrees, and
the roots of these, which leave their rests in `left`.
"""


def _forward(
    values: FloatArray,
    a: Supernodes,
    parts: Subtrees,
    which: IntArray,
    root: int,
    b: FloatArray,
    left: FloatArray,
    x: FloatArray,
) -> None:
    end = a.start[root + 1] if root >= 0 else len(a.order)
    y, z, above = np.empty(a.front), np.empty(a.front), np.empty((len(a.order) - end, 2))
    if root >= 0:
        for p in range(a.below_start[root], a.below_start[root + 1]):
            above[a.below[p] - end] = 0.0
    for s in which:
        first, width, under = a.start[s], a.start[s + 1] - a.start[s], a.below_start[s]
        m = a.below_start[s + 1] - under
        if parts.number[s] >= 0 and s != root:
            begin = parts.rows[parts.number[s]]
            for i in range(m):
                x[a.below[under + i], 0] += left[begin + i, 0]
                x[a.below[under + i], 1] += left[begin + i, 1]
            continue
        for j in range(first, first + width):
            x[j, 0] += b[a.order[j], 0]
            x[j, 1] += b[a.order[j], 1]
        size, at = width + m, a.value_start[s]
        for j in range(width):
            own = at + j * size
            f, g = x[first + j, 0] / values[own + j], x[first + j, 1] / values[own + j]
            x[first + j, 0], x[first + j, 1] = f, g
            for i in range(j + 1, width):
                x[first + i, 0] -= values[own + i] * f
                x[first + i, 1] -= values[own + i] * g
        u, v = y[:m], z[:m]
        u[:] = 0.0
        v[:] = 0.0
        for j in range(width % 2, width, 2):  # two columns at a time
            own = at + j * size
            c, d = values[own + width : own + size], values[own + size + width : own + 2 * size]
            f, g, h, k = x[first + j, 0], x[first + j, 1], x[first + j + 1, 0], x[first + j + 1, 1]
            for i in range(m):
                u[i] += c[i] * f + d[i] * h
                v[i] += c[i] * g + d[i] * k
        if width % 2:
            c, f, g = values[at + width : at + size], x[first, 0], x[first, 1]
            for i in range(m):
                u[i] += c[i] * f
                v[i] += c[i] * g
        for i in range(m):
            r = a.below[under + i]
            if r < end:
                x[r, 0] -= u[i]
                x[r, 1] -= v[i]
            else:
                above[r - end, 0] -= u[i]
                above[r - end, 1] -= v[i]
    if root >= 0:
        begin, under = parts.rows[parts.number[root]], a.below_start[root]
        for i in range(a.below_start[root + 1] - under):
            left[begin + i] = above[a.below[under + i] - end]


supernodal_forward = only_loops(_forward)
supernodal_forward.__doc__ = (
    """L x = P b for two right sides, b (n, 2), in x, zero at first; `which` as in the factor."""
)


def _backward(
    values: FloatArray,
    a: Supernodes,
    parts: Subtrees,
    which: IntArray,
    root: int,
    x: FloatArray,
    made: FloatArray,
) -> None:
    y, z = np.empty(a.front), np.empty(a.front)
    for s in which[::-1]:
        if parts.number[s] >= 0 and s != root:
            continue
        first, width, under = a.start[s], a.start[s + 1] - a.start[s], a.below_start[s]
        m = a.below_start[s + 1] - under
        size, at = width + m, a.value_start[s]
        u, v = y[:m], z[:m]
        for i in range(m):
            u[i], v[i] = x[a.below[under + i], 0], x[a.below[under + i], 1]
        for j in range(width % 2, width, 2):
            own = at + j * size
            c, d = values[own + width : own + size], values[own + size + width : own + 2 * size]
            f = g = h = k = 0.0
            for i in range(m):
                f += c[i] * u[i]
                g += c[i] * v[i]
                h += d[i] * u[i]
                k += d[i] * v[i]
            x[first + j, 0] -= f
            x[first + j, 1] -= g
            x[first + j + 1, 0] -= h
            x[first + j + 1, 1] -= k
        if width % 2:
            c, f, g = values[at + width : at + size], 0.0, 0.0
            for i in range(m):
                f += c[i] * u[i]
                g += c[i] * v[i]
            x[first, 0] -= f
            x[first, 1] -= g
        for j in range(width - 1, -1, -1):
            own = at + j * size
            f, g = x[first + j, 0], x[first + j, 1]
            for i in range(j + 1, width):
                f -= values[own + i] * x[first + i, 0]
                g -= values[own + i] * x[first + i, 1]
            x[first + j, 0], x[first + j, 1] = f / values[own + j], g / values[own + j]
        for j in range(first, first + width):
            made[a.order[j], 0], made[a.order[j], 1] = x[j, 0], x[j, 1]


supernodal_backward = only_loops(_backward)
supernodal_backward.__doc__ = (
    """L^T P made = x, by the supernodes `which` from the last one on; x is overwritten."""
)
