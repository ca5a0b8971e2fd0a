"""The Cholesky factorisation of a sparse matrix by supernodes, as loops (Duff, Reid 1983; Liu 1992).

A supernode is a run of columns of the factor with the same rows below them. Its front is a dense matrix: the
rows of A that belong to its columns, and what its children in the elimination tree leave. The front's columns
are eliminated; what is left of the front goes to its parent. There is no form in NumPy: CHOLMOD's factor, in
the same order, defines this one. On meshes of up to about 200,000 triangles it takes half of CHOLMOD's time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._types import FloatArray, IntArray
from .choice import inlined, only_loops

SMALL, MEDIUM = 16, 48  # columns
ZEROS_OF_SMALL, ZEROS_OF_MEDIUM, ZEROS = 0.8, 0.1, 0.05  # share of a supernode's entries that may be zeros
WIDTH = 4  # columns that are eliminated together


class Supernodes(NamedTuple):
    """A pattern, analysed.

    Attributes
    ----------
    order : (n,) int64
        The row of A that comes at each place: P A P^T = L L^T.
    column : (n + 1,) int64
    row, source : int64 arrays
        The lower triangle of P A P^T by columns: rows, and where in A's data each entry is.
    start : (#s + 1,) int64
        The first column of each supernode.
    below_start : (#s + 1,) int64
    below : int64 array
        The rows below each supernode's columns, ascending.
    children : (#s,) int64
        How many children each has in the elimination tree.
    value_start : (#s + 1,) int64
        Where its part of L's values begins, a row of it for each column.
    stack, front : int
        Sizes of the work space.
    """

    order: IntArray
    column: IntArray
    row: IntArray
    source: IntArray
    start: IntArray
    below_start: IntArray
    below: IntArray
    children: IntArray
    value_start: IntArray
    stack: int
    front: int


@inlined
def _permuted(indptr: IntArray, indices: IntArray, place: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """The lower triangle of P A P^T by columns, `place` being the inverse of the order."""
    n = len(place)
    column = np.zeros(n + 2, dtype=np.int64)
    for j in range(n):
        for p in range(indptr[j], indptr[j + 1]):
            column[min(place[j], place[indices[p]]) + 2] += 1
    for j in range(n):
        column[j + 2] += column[j + 1]
    row, source = np.empty(indptr[n], dtype=np.int64), np.empty(indptr[n], dtype=np.int64)
    for j in range(n):
        for p in range(indptr[j], indptr[j + 1]):
            a, b = place[j], place[indices[p]]
            at = column[min(a, b) + 1]
            column[min(a, b) + 1] += 1
            row[at], source[at] = max(a, b), p
    return column, row, source


@inlined
def _by_rows(column: IntArray, row: IntArray, n: int) -> tuple[IntArray, IntArray]:
    """The same entries by rows: where each row begins, and their columns."""
    begin = np.zeros(n + 2, dtype=np.int64)
    for q in range(len(row)):
        begin[row[q] + 2] += 1
    for j in range(n):
        begin[j + 2] += begin[j + 1]
    before = np.empty(len(row), dtype=np.int64)
    for j in range(n):
        for q in range(column[j], column[j + 1]):
            before[begin[row[q] + 1]] = j
            begin[row[q] + 1] += 1
    return begin, before


@inlined
def _tree(begin: IntArray, before: IntArray, n: int) -> IntArray:
    """The parent of each column in the elimination tree (Liu 1986); -1 at roots."""
    parent, ancestor = np.full(n, -1, dtype=np.int64), np.full(n, -1, dtype=np.int64)
    for i in range(n):
        for p in range(begin[i], begin[i + 1]):
            k = before[p]
            while k >= 0 and k < i:
                above = ancestor[k]
                ancestor[k] = i
                if above < 0:
                    parent[k] = i
                k = above
    return parent


@inlined
def _counts(column: IntArray, row: IntArray, parent: IntArray) -> IntArray:
    """The number of entries of each column of L, the columns in postorder (Gilbert, Ng, Peyton 1994)."""
    n = len(parent)
    first, count = np.full(n, -1, dtype=np.int64), np.zeros(n, dtype=np.int64)
    for k in range(n):
        count[k] = first[k] < 0  # the leaves
        j = k
        while j >= 0 and first[j] < 0:
            first[j] = k
            j = parent[j]
    last_first, last_leaf = np.full(n, -1, dtype=np.int64), np.full(n, -1, dtype=np.int64)
    ancestor = np.arange(n)
    for j in range(n):
        if parent[j] >= 0:
            count[parent[j]] -= 1
        for q in range(column[j], column[j + 1]):
            i = row[q]
            if i == j or first[j] <= last_first[i]:
                continue
            # j is a leaf of the subtree of row i: from there up, its path is new to the least common ancestor
            last_first[i] = first[j]
            leaf = last_leaf[i]
            last_leaf[i] = j
            count[j] += 1
            if leaf >= 0:
                top = leaf
                while top != ancestor[top]:
                    top = ancestor[top]
                while leaf != top:
                    ancestor[leaf], leaf = top, ancestor[leaf]
                count[top] -= 1
        if parent[j] >= 0:
            ancestor[j] = parent[j]
    for j in range(n):
        if parent[j] >= 0:
            count[parent[j]] += count[j]
    return count


@inlined
def _columns(parent: IntArray, count: IntArray) -> tuple[IntArray, IntArray]:
    """The first columns of the supernodes, and the rows of each; small ones take in zeros to be wider."""
    n = len(parent)
    start, number = np.empty(n + 1, dtype=np.int64), 0
    for j in range(n):
        if j == 0 or parent[j - 1] != j or count[j - 1] != count[j] + 1:
            start[number] = j
            number += 1
    start[number] = n
    end, size, zeros = np.empty(number, np.int64), np.empty(number, np.int64), np.zeros(number, np.int64)
    first = np.ones(number, dtype=np.bool_)
    for s in range(number - 1, -1, -1):
        end[s], size[s] = start[s + 1], count[start[s]]
        if s == number - 1 or parent[start[s + 1] - 1] != start[s + 1]:
            continue
        own, width = end[s] - start[s], end[s + 1] - start[s]
        rows = own + size[s + 1]
        missing = zeros[s + 1] + own * (rows - size[s])
        share = ZEROS_OF_SMALL if width <= SMALL else ZEROS_OF_MEDIUM if width <= MEDIUM else ZEROS
        if width <= WIDTH or missing < share * (width * rows - width * (width - 1) / 2):
            first[s + 1] = False
            end[s], size[s], zeros[s] = end[s + 1], rows, missing
    kept = np.flatnonzero(first)
    return np.append(start[kept], n), size[kept]


def _supernodes(
    indptr: IntArray, indices: IntArray, order: IntArray
) -> tuple[IntArray, IntArray, IntArray, IntArray, IntArray, IntArray, IntArray, IntArray, int, int]:
    n = len(order)
    place = np.empty(n, dtype=np.int64)
    for i in range(n):
        place[order[i]] = i
    column, row, source = _permuted(indptr, indices, place)
    begin, before = _by_rows(column, row, n)
    parent = _tree(begin, before, n)
    start, size = _columns(parent, _counts(column, row, parent))
    number = len(size)
    of, above = np.empty(n, dtype=np.int64), np.full(number, -1, dtype=np.int64)
    below_start, value_start = np.zeros(number + 1, np.int64), np.zeros(number + 1, np.int64)
    for s in range(number):
        width = start[s + 1] - start[s]
        below_start[s + 1] = below_start[s] + size[s] - width
        value_start[s + 1] = value_start[s] + size[s] * width
        of[start[s] : start[s + 1]] = s
    children, left = np.zeros(number, dtype=np.int64), np.zeros(number, dtype=np.int64)
    depth = stack = front = 0
    for s in range(number):
        depth += (size[s] - (start[s + 1] - start[s])) ** 2 - left[s]
        stack, front = max(stack, depth), max(front, size[s])
        if parent[start[s + 1] - 1] >= 0:
            above[s] = of[parent[start[s + 1] - 1]]
            children[above[s]] += 1
            left[above[s]] += (below_start[s + 1] - below_start[s]) ** 2
    below, end = np.empty(below_start[number], dtype=np.int64), below_start[:-1].copy()
    seen = np.full(number, -1, dtype=np.int64)
    for i in range(n):
        seen[of[i]] = i
        for p in range(begin[i], begin[i + 1]):
            s = of[before[p]]
            while seen[s] != i:  # row i is in the supernodes up the tree from there
                seen[s] = i
                below[end[s]] = i
                end[s] += 1
                s = above[s]
    return column[: n + 1].copy(), row, source, start, below_start, below, children, value_start, stack, front


_analysed = only_loops(_supernodes)


def supernodes(indptr: IntArray, indices: IntArray, order: IntArray) -> Supernodes:
    """Analyse a symmetric pattern, given by its lower triangle in CSC, for a postordered elimination."""
    return Supernodes(order, *_analysed(indptr, indices, order))


@inlined
def _eliminate(F: FloatArray, width: int) -> int:
    """Eliminate the first columns of a front, `F[column, row]`; the bad pivot, or -1."""
    size, p = len(F), 0
    while p < width:
        end = min(p + WIDTH, width)
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
        if end == p + 4:
            for j in range(end, size):
                f0, f1, f2, f3 = F[p, j], F[p + 1, j], F[p + 2, j], F[p + 3, j]
                x0, x1, x2, x3, y = F[p, j:], F[p + 1, j:], F[p + 2, j:], F[p + 3, j:], F[j, j:]
                for i in range(size - j):
                    y[i] -= f0 * x0[i] + f1 * x1[i] + f2 * x2[i] + f3 * x3[i]
        else:
            for k in range(p, end):
                for j in range(end, size):
                    share, x, y = F[k, j], F[k, j:], F[j, j:]
                    for i in range(size - j):
                        y[i] -= share * x[i]
        p = end
    return -1


def _factor(data: FloatArray, a: Supernodes) -> tuple[FloatArray, int]:
    n, values = len(a.order), np.empty(a.value_start[-1])
    stack, top = np.empty(a.stack), 0
    waiting, last = np.empty(len(a.children), dtype=np.int64), 0
    place, local = np.empty(n, dtype=np.int64), np.empty(a.front, dtype=np.int64)
    space = np.empty(a.front * a.front)
    for s in range(len(a.children)):
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
        for _ in range(a.children[s]):  # in postorder, the children are on top
            last -= 1
            c = waiting[last]
            rows = a.below[a.below_start[c] : a.below_start[c + 1]]
            top -= len(rows) ** 2
            left = stack[top : top + len(rows) ** 2].reshape(len(rows), len(rows))
            for k in range(len(rows)):
                local[k] = place[rows[k]]
            for j in range(len(rows)):
                for i in range(j, len(rows)):
                    F[local[j], local[i]] += left[j, i]
        bad = _eliminate(F, width)
        if bad >= 0:
            return values, first + bad
        L = values[a.value_start[s] : a.value_start[s + 1]].reshape(width, size)
        for j in range(width):
            L[j, j:] = F[j, j:]
        if len(below):
            left = stack[top : top + len(below) ** 2].reshape(len(below), len(below))
            for j in range(len(below)):
                left[j, j:] = F[width + j, width + j :]
            top += len(below) ** 2
            waiting[last] = s
            last += 1
    return values, -1


supernodal_factor = only_loops(_factor)
supernodal_factor.__doc__ = """L's values by supernodes, and the place of a bad pivot, or -1."""


def _solve(values: FloatArray, a: Supernodes, b: FloatArray) -> FloatArray:
    n, start, below_start, begin = len(a.order), a.start, a.below_start, a.value_start
    below, order = a.below, a.order
    x, y, z = np.empty((n, 2)), np.empty(a.front), np.empty(a.front)
    for i in range(n):
        x[i, 0], x[i, 1] = b[order[i], 0], b[order[i], 1]
    for s in range(len(start) - 1):  # L y = P b
        first, width, under = start[s], start[s + 1] - start[s], below_start[s]
        m = below_start[s + 1] - under
        size, at = width + m, begin[s]
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
            x[below[under + i], 0] -= u[i]
            x[below[under + i], 1] -= v[i]
    for s in range(len(start) - 2, -1, -1):  # L^T P x = y
        first, width, under = start[s], start[s + 1] - start[s], below_start[s]
        m = below_start[s + 1] - under
        size, at = width + m, begin[s]
        u, v = y[:m], z[:m]
        for i in range(m):
            u[i], v[i] = x[below[under + i], 0], x[below[under + i], 1]
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
    made = np.empty_like(x)
    for i in range(n):
        made[order[i], 0], made[order[i], 1] = x[i, 0], x[i, 1]
    return made


supernodal_solve = only_loops(_solve)
supernodal_solve.__doc__ = """A^-1 b for two right-hand sides, (n, 2), by the values of the factor."""
