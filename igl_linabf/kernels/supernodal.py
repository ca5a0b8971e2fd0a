"""The Cholesky factorisation of a sparse matrix by supernodes, as loops (Duff, Reid 1983; Liu 1992).

The front of a supernode is a dense matrix: the rows of A that belong to its columns, and what its children in
the elimination tree leave. The front's columns are eliminated; what is left of the front goes to its parent.
Subtrees do not touch each other, so threads work at several of them at a time; the supernodes above them come
after. There is no form in NumPy: CHOLMOD's factor, in the same order, defines this one. On meshes of 10,000
to 200,000 triangles it takes less than half of CHOLMOD's time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._types import FloatArray, IntArray
from .choice import inlined, only_loops
from .fronts import add, add_leaf, eliminate, eliminate_in_threads
from .supernodes import WIDTH, Supernodes

THIN = 2  # columns up to which what a leaf leaves goes to its parent's front at once
ALL, FRONT, LEAVE = 0, 1, 2  # of the work at a supernode: what is before its elimination, and after it
DIGITS = 1e-5  # share of a diagonal entry below which its pivot has no digits left in single precision


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


def _fresh(size: int) -> FloatArray:
    return np.empty(size)


fresh = only_loops(_fresh)
fresh.__doc__ = """An array that is not filled, in small pages.

NumPy asks the system for large ones, and gigabytes of these take it longer than the factor takes.
"""


class Work(NamedTuple):
    """Work space.

    Attributes
    ----------
    stack : (Supernodes.stack,) float
        What fronts leave for their parents.
    space : (Supernodes.front^2,) float
        What is left of a front.
    least : (Supernodes.front,) float
        What pivots of a front must exceed.
    waiting : (#,) int64
        The supernodes whose parents come later.
    size : (2,) int64
        How many these are, and how much of the stack is in use; zeros at first.
    """

    stack: FloatArray
    space: FloatArray
    least: FloatArray
    waiting: IntArray
    size: IntArray


def _factor(
    data: FloatArray,
    a: Supernodes,
    parts: Subtrees,
    which: IntArray,
    root: int,
    values: FloatArray,
    left: FloatArray,
    work: Work,
    does: int = ALL,
) -> int:
    least, waiting, stack, last, top = work.least, work.waiting, work.stack, work.size[0], work.size[1]
    digits = values.dtype.type(DIGITS if values.itemsize < 8 else 0)
    for s in which:
        first, width = a.start[s], a.start[s + 1] - a.start[s]
        m = a.below_start[s + 1] - a.below_start[s]
        if parts.number[s] >= 0 and s != root:  # it is done
            if m:
                waiting[last] = s
                last += 1
            continue
        block = values[a.value_start[s] : a.value_start[s + 1]]
        rest = 0 if a.children[s] == 0 and width <= THIN else m
        L, U = block.reshape(width, width + m), work.space[: rest * rest].reshape(rest, rest)
        if does != LEAVE:
            block[:] = 0.0
            for p in range(a.column[first], a.column[first + width]):
                block[a.target[p]] += data[a.source[p]]
            for j in range(width):
                least[j] = digits * block[j * (width + m + 1)]
            for j in range(rest):
                U[j, j:] = 0.0
            for _ in range(a.children[s]):
                last -= 1
                c = waiting[last]
                wide, to = a.start[c + 1] - a.start[c], a.local[a.below_start[c] : a.below_start[c + 1]]
                if parts.number[c] >= 0:
                    begin = parts.left[parts.number[c]]
                    add(left[begin : begin + len(to) ** 2], to, L, U)
                elif a.children[c] == 0 and wide <= THIN:
                    add_leaf(values[a.value_start[c] : a.value_start[c + 1]], wide, to, L, U)
                else:
                    top -= len(to) ** 2
                    add(stack[top : top + len(to) ** 2], to, L, U)
        if does == ALL:
            bad = eliminate(L, U, least)
            if bad >= 0:
                return int(first + bad)
        if does != FRONT:
            if s == root:
                begin = parts.left[parts.number[s]]
                kept = left[begin : begin + rest * rest]
            else:
                kept = stack[top : top + rest * rest]
                top += rest * rest
            for j in range(rest):
                kept[j * rest + j : (j + 1) * rest] = U[j, j:]
            if m:
                waiting[last] = s
                last += 1
    work.size[0], work.size[1] = last, top
    return -1


supernodal_factor = only_loops(_factor)
supernodal_factor.__doc__ = """Fill L's values by the supernodes `which`; the place of a bad pivot, or -1.

These are those of the subtree with this root, in order. With root -1 they are some of those above all
subtrees, and of the roots of these, which leave their rests in `left`. Values, rests and work space are of
one precision, double or single.
"""


def supernodal_front(
    data: FloatArray, a: Supernodes, parts: Subtrees, s: int, values: FloatArray, left: FloatArray, work: Work
) -> int:
    """The same for one large supernode above all subtrees, in which threads share the work."""
    args = data, a, parts, np.array([s]), -1, values, left, work
    width, rest = int(a.start[s + 1] - a.start[s]), int(a.below_start[s + 1] - a.below_start[s])
    supernodal_factor(*args, FRONT)
    L = values[a.value_start[s] : a.value_start[s + 1]].reshape(width, width + rest)
    bad = eliminate_in_threads(L, work.space[: rest**2].reshape(rest, rest), work.least)
    if bad >= 0:
        return int(a.start[s] + bad)
    return supernodal_factor(*args, LEAVE)


@inlined
def _down(values: FloatArray, at: int, width: int, u: FloatArray, v: FloatArray) -> None:
    """Go on from two right sides at a supernode's columns, at the beginning of u and v, to those below it."""
    size = len(u)
    for j in range(width % WIDTH):
        own = at + j * size
        c, d, p, q = values[own + j + 1 : own + size], values[own + j], u[j + 1 :], v[j + 1 :]
        f, g = u[j] * d, v[j] * d
        u[j], v[j] = f, g
        for i in range(len(c)):
            p[i] -= c[i] * f
            q[i] -= c[i] * g
    for j in range(width % WIDTH, width, WIDTH):  # four columns at a time
        k0 = at + j * size + j
        k1, k2, k3, end0 = k0 + size, k0 + 2 * size, k0 + 3 * size, at + (j + 1) * size
        f0, g0 = u[j] * values[k0], v[j] * values[k0]
        e, d = values[k0 + 1], values[k1 + 1]
        f1, g1 = (u[j + 1] - e * f0) * d, (v[j + 1] - e * g0) * d
        e, r, d = values[k0 + 2], values[k1 + 2], values[k2 + 2]
        f2, g2 = (u[j + 2] - e * f0 - r * f1) * d, (v[j + 2] - e * g0 - r * g1) * d
        e, r, t, d = values[k0 + 3], values[k1 + 3], values[k2 + 3], values[k3 + 3]
        f3 = (u[j + 3] - e * f0 - r * f1 - t * f2) * d
        g3 = (v[j + 3] - e * g0 - r * g1 - t * g2) * d
        u[j], u[j + 1], u[j + 2], u[j + 3] = f0, f1, f2, f3
        v[j], v[j + 1], v[j + 2], v[j + 3] = g0, g1, g2, g3
        c0, c1 = values[k0 + 4 : end0], values[k1 + 4 : end0 + size]
        c2, c3 = values[k2 + 4 : end0 + 2 * size], values[k3 + 4 : end0 + 3 * size]
        p, q = u[j + 4 :], v[j + 4 :]
        for i in range(len(p)):
            p[i] -= c0[i] * f0 + c1[i] * f1 + c2[i] * f2 + c3[i] * f3
            q[i] -= c0[i] * g0 + c1[i] * g1 + c2[i] * g2 + c3[i] * g3


@inlined
def _up(values: FloatArray, at: int, width: int, u: FloatArray, v: FloatArray) -> None:
    """Two solutions at a supernode's columns, in place, from those below it."""
    size, zero = len(u), values.dtype.type(0)
    for j in range(width - WIDTH, width % WIDTH - 1, -WIDTH):
        k0 = at + j * size + j
        k1, k2, k3, end0 = k0 + size, k0 + 2 * size, k0 + 3 * size, at + (j + 1) * size
        c0, c1 = values[k0 + 4 : end0], values[k1 + 4 : end0 + size]
        c2, c3 = values[k2 + 4 : end0 + 2 * size], values[k3 + 4 : end0 + 3 * size]
        p, q = u[j + 4 :], v[j + 4 :]
        f0 = f1 = f2 = f3 = g0 = g1 = g2 = g3 = zero
        for i in range(len(p)):
            f0 += c0[i] * p[i]
            f1 += c1[i] * p[i]
            f2 += c2[i] * p[i]
            f3 += c3[i] * p[i]
            g0 += c0[i] * q[i]
            g1 += c1[i] * q[i]
            g2 += c2[i] * q[i]
            g3 += c3[i] * q[i]
        d = values[k3 + 3]
        f3, g3 = (u[j + 3] - f3) * d, (v[j + 3] - g3) * d
        e, d = values[k2 + 3], values[k2 + 2]
        f2, g2 = (u[j + 2] - f2 - e * f3) * d, (v[j + 2] - g2 - e * g3) * d
        e, r, d = values[k1 + 2], values[k1 + 3], values[k1 + 1]
        f1, g1 = (u[j + 1] - f1 - e * f2 - r * f3) * d, (v[j + 1] - g1 - e * g2 - r * g3) * d
        e, r, t, d = values[k0 + 1], values[k0 + 2], values[k0 + 3], values[k0]
        f0, g0 = (u[j] - f0 - e * f1 - r * f2 - t * f3) * d, (v[j] - g0 - e * g1 - r * g2 - t * g3) * d
        u[j], u[j + 1], u[j + 2], u[j + 3] = f0, f1, f2, f3
        v[j], v[j + 1], v[j + 2], v[j + 3] = g0, g1, g2, g3
    for j in range(width % WIDTH - 1, -1, -1):
        own = at + j * size
        c, d, p, q = values[own + j + 1 : own + size], values[own + j], u[j + 1 :], v[j + 1 :]
        f = g = zero
        for i in range(len(c)):
            f += c[i] * p[i]
            g += c[i] * q[i]
        u[j], v[j] = (u[j] - f) * d, (v[j] - g) * d


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
    y, z, sides = np.empty(a.front, values.dtype), np.empty(a.front, values.dtype), b.shape[1]
    above = np.empty((len(a.order) - end, sides), values.dtype)
    if root >= 0:
        for i in range(a.below_start[root], a.below_start[root + 1]):
            above[a.below[i] - end] = 0.0
    for s in which:
        first, width, under = a.start[s], a.start[s + 1] - a.start[s], a.below_start[s]
        m = a.below_start[s + 1] - under
        if parts.number[s] >= 0 and s != root:
            begin = parts.rows[parts.number[s]]
            for i in range(m):
                for k in range(sides):
                    x[a.below[under + i], k] += left[begin + i, k]
            continue
        size, inside = width + m, m  # rows of the subtree; those above come last
        while inside and a.below[under + inside - 1] >= end:
            inside -= 1
        u, v = y[:size], z[:size]
        for k in range(0, sides, 2):
            for j in range(width):
                i = a.order[first + j]
                u[j], v[j] = x[first + j, k] + b[i, k], x[first + j, k + 1] + b[i, k + 1]
            j = 0
            while j < width and u[j] == 0.0 and v[j] == 0.0:
                x[first + j, k], x[first + j, k + 1] = u[j], v[j]
                j += 1
            if j == width:  # few supernodes hold anything of a side with few entries
                continue
            u[width:] = 0.0
            v[width:] = 0.0
            _down(values, a.value_start[s], width, u, v)
            for j in range(width):
                x[first + j, k], x[first + j, k + 1] = u[j], v[j]
            for i in range(inside):
                r = a.below[under + i]
                x[r, k] += u[width + i]
                x[r, k + 1] += v[width + i]
            for i in range(inside, m):
                r = a.below[under + i] - end
                above[r, k] += u[width + i]
                above[r, k + 1] += v[width + i]
    if root >= 0:
        begin, under = parts.rows[parts.number[root]], a.below_start[root]
        for i in range(a.below_start[root + 1] - under):
            left[begin + i] = above[a.below[under + i] - end]


supernodal_forward = only_loops(_forward)
supernodal_forward.__doc__ = """L x = P b for an even number of right sides, b (n, k), in x, zero at first.

`which` as in the factor. Two sides at a time, while the supernode's values are near.
"""


def _backward(
    values: FloatArray,
    a: Supernodes,
    parts: Subtrees,
    which: IntArray,
    root: int,
    x: FloatArray,
    made: FloatArray,
) -> None:
    y, z, sides = np.empty(a.front, values.dtype), np.empty(a.front, values.dtype), x.shape[1]
    for s in which[::-1]:
        if parts.number[s] >= 0 and s != root:
            continue
        first, width, under = a.start[s], a.start[s + 1] - a.start[s], a.below_start[s]
        m = a.below_start[s + 1] - under
        u, v = y[: width + m], z[: width + m]
        for k in range(0, sides, 2):
            for j in range(width):
                u[j], v[j] = x[first + j, k], x[first + j, k + 1]
            for i in range(m):
                u[width + i], v[width + i] = x[a.below[under + i], k], x[a.below[under + i], k + 1]
            _up(values, a.value_start[s], width, u, v)
            for j in range(width):
                x[first + j, k], x[first + j, k + 1] = u[j], v[j]
                made[a.order[first + j], k], made[a.order[first + j], k + 1] = u[j], v[j]


supernodal_backward = only_loops(_backward)
supernodal_backward.__doc__ = (
    """L^T P made = x, (n, k), by the supernodes `which` from the last one on; x is overwritten."""
)
