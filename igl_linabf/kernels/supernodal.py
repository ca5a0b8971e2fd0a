"""The Cholesky factorisation of a sparse matrix by supernodes, as loops (Duff, Reid 1983; Liu 1992).

The front of a supernode is a dense matrix: the rows of A that belong to its columns, and what its children in
the elimination tree leave. The front's columns are eliminated; what is left of the front goes to its parent.
There is no form in NumPy: CHOLMOD's factor, in the same order, defines this one. On meshes of up to about
200,000 triangles it takes less than half of CHOLMOD's time.
"""

from __future__ import annotations

import numpy as np

from .._types import FloatArray
from .choice import inlined, only_loops
from .supernodes import WIDTH, Places, Supernodes

THIN = 2  # columns up to which what a leaf leaves goes to its parent's front at once


@inlined
def _eliminate(L: FloatArray, U: FloatArray) -> int:
    """Eliminate the columns L, `L[column, row]`, of a front, whose rest is U; the bad pivot, or -1."""
    width, size, p = len(L), L.shape[1], 0
    while p < width:
        end = min(p + WIDTH, width)
        for k in range(p, end):
            if not L[k, k] > 0:
                return k
            root, x = np.sqrt(L[k, k]), L[k, k:]
            inverse = 1 / root
            for i in range(size - k):
                x[i] *= inverse
            for j in range(k + 1, end):
                share, x, y = L[k, j], L[k, j:], L[j, j:]
                for i in range(size - j):
                    y[i] -= share * x[i]
        if end < p + 4:  # the last columns
            for k in range(p, end):
                for j in range(len(U)):
                    share, x, y = L[k, width + j], L[k, width + j :], U[j, j:]
                    for i in range(len(U) - j):
                        y[i] -= share * x[i]
            break
        for j in range(end, width):
            f0, f1, f2, f3 = L[p, j], L[p + 1, j], L[p + 2, j], L[p + 3, j]
            x0, x1, x2, x3, y = L[p, j:], L[p + 1, j:], L[p + 2, j:], L[p + 3, j:], L[j, j:]
            for i in range(size - j):
                y[i] -= f0 * x0[i] + f1 * x1[i] + f2 * x2[i] + f3 * x3[i]
        for j in range(len(U)):
            q = width + j
            f0, f1, f2, f3 = L[p, q], L[p + 1, q], L[p + 2, q], L[p + 3, q]
            x0, x1, x2, x3, y = L[p, q:], L[p + 1, q:], L[p + 2, q:], L[p + 3, q:], U[j, j:]
            for i in range(len(U) - j):
                y[i] -= f0 * x0[i] + f1 * x1[i] + f2 * x2[i] + f3 * x3[i]
        p = end
    return -1


@inlined
def _add_leaf(own: FloatArray, to: Places, L: FloatArray, U: FloatArray) -> None:
    """Add what the columns `own` of a thin leaf leave to the front L, U of its parent."""
    width, begin = len(L), len(own)
    for j in range(len(to)):
        for k in range(begin):
            share, x = own[k, begin + j], own[k, begin:]
            if to[j] < width:
                for i in range(j, len(to)):
                    L[to[j], to[i]] -= share * x[i]
            else:
                for i in range(j, len(to)):
                    U[to[j] - width, to[i] - width] -= share * x[i]


@inlined
def _add(left: FloatArray, to: Places, L: FloatArray, U: FloatArray) -> None:
    """Add what is left of a child's front to the front L, U of its parent."""
    width = len(L)
    for j in range(len(to)):
        if to[j] < width:
            for i in range(j, len(to)):
                L[to[j], to[i]] += left[j, i]
        else:
            for i in range(j, len(to)):
                U[to[j] - width, to[i] - width] += left[j, i]


def _factor(data: FloatArray, a: Supernodes, values: FloatArray) -> int:
    stack, top = np.empty(a.stack), 0
    waiting, last = np.empty(len(a.children), dtype=np.int64), 0
    space = np.empty(a.front * a.front)
    for s in range(len(a.children)):
        first, width = a.start[s], a.start[s + 1] - a.start[s]
        m = a.below_start[s + 1] - a.below_start[s]
        block = values[a.value_start[s] : a.value_start[s + 1]]
        block[:] = 0.0
        for p in range(a.column[first], a.column[first + width]):
            block[a.target[p]] += data[a.source[p]]
        thin = a.children[s] == 0 and width <= THIN
        rest = 0 if thin else m
        L, U = block.reshape(width, width + m), space[: rest * rest].reshape(rest, rest)
        for j in range(rest):
            U[j, j:] = 0.0
        for _ in range(a.children[s]):
            last -= 1
            c = waiting[last]
            wide, to = a.start[c + 1] - a.start[c], a.local[a.below_start[c] : a.below_start[c + 1]]
            if a.children[c] == 0 and wide <= THIN:
                own = values[a.value_start[c] : a.value_start[c + 1]]
                _add_leaf(own.reshape(wide, wide + len(to)), to, L, U)
            else:
                top -= len(to) ** 2
                _add(stack[top : top + len(to) ** 2].reshape(len(to), len(to)), to, L, U)
        bad = _eliminate(L, U)
        if bad >= 0:
            return int(first + bad)
        left = stack[top : top + rest * rest].reshape(rest, rest)
        for j in range(rest):
            left[j, j:] = U[j, j:]
        top += rest * rest
        if m:
            waiting[last] = s
            last += 1
    return -1


_factored = only_loops(_factor)


def supernodal_factor(data: FloatArray, a: Supernodes) -> tuple[FloatArray, int]:
    """L's values by supernodes, and the place of a bad pivot, or -1."""
    values = np.empty(a.value_start[-1])  # NumPy asks for large pages
    return values, _factored(data, a, values)


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
