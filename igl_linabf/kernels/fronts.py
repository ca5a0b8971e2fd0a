"""What is done to the front of a supernode, a dense matrix: loops, and threads for the largest ones."""

import numpy as np

from .._runtime import at_once
from .._types import FloatArray
from .choice import inlined, only_loops
from .supernodes import WIDTH, Places

PANEL = 64  # columns whose effect on the rest is added up
PIECE = 32 * WIDTH  # columns that a thread takes at a time


@inlined
def _take(X: FloatArray, p: int, last: int, Y: FloatArray, shift: int, first: int, until: int) -> None:
    """Take from the columns `first` to `until` of Y what the eliminated columns `p` to `last` of X say.

    The row of Y's column 0 in X is `shift`. Four go with four at a time, which stay in the processor's
    registers.
    """
    size = X.shape[1] - shift
    fours, whole = p + (last - p) // WIDTH * WIDTH, first + (until - first) // WIDTH * WIDTH
    for j in range(first, whole, WIDTH):
        q = shift + j
        for k in range(p, fours, WIDTH):
            for c in range(3):  # the corner, of which there is a triangle only
                for r in range(c, 3):
                    for t in range(k, k + WIDTH):
                        Y[j + c, j + r] -= X[t, q + c] * X[t, q + r]
            x0, x1, x2, x3 = X[k, q + 3 :], X[k + 1, q + 3 :], X[k + 2, q + 3 :], X[k + 3, q + 3 :]
            y0, y1, y2, y3 = Y[j, j + 3 :], Y[j + 1, j + 3 :], Y[j + 2, j + 3 :], Y[j + 3, j + 3 :]
            a0, a1, a2, a3 = X[k, q], X[k + 1, q], X[k + 2, q], X[k + 3, q]
            b0, b1, b2, b3 = X[k, q + 1], X[k + 1, q + 1], X[k + 2, q + 1], X[k + 3, q + 1]
            c0, c1, c2, c3 = X[k, q + 2], X[k + 1, q + 2], X[k + 2, q + 2], X[k + 3, q + 2]
            d0, d1, d2, d3 = X[k, q + 3], X[k + 1, q + 3], X[k + 2, q + 3], X[k + 3, q + 3]
            for i in range(size - j - 3):
                u, v, w, z = x0[i], x1[i], x2[i], x3[i]
                y0[i] -= a0 * u + a1 * v + a2 * w + a3 * z
                y1[i] -= b0 * u + b1 * v + b2 * w + b3 * z
                y2[i] -= c0 * u + c1 * v + c2 * w + c3 * z
                y3[i] -= d0 * u + d1 * v + d2 * w + d3 * z
    for j in range(whole, until):
        for k in range(p, fours, WIDTH):
            q = shift + j
            f0, f1, f2, f3 = X[k, q], X[k + 1, q], X[k + 2, q], X[k + 3, q]
            x0, x1, x2, x3, y = X[k, q:], X[k + 1, q:], X[k + 2, q:], X[k + 3, q:], Y[j, j:]
            for i in range(size - j):
                y[i] -= f0 * x0[i] + f1 * x1[i] + f2 * x2[i] + f3 * x3[i]
    for k in range(fours, last):
        for j in range(first, until):
            share, x, y = X[k, shift + j], X[k, shift + j :], Y[j, j:]
            for i in range(size - j):
                y[i] -= share * x[i]


@inlined
def _panel(L: FloatArray, first: int, last: int, least: FloatArray) -> int:
    """Eliminate the columns `first` to `last` of a front among themselves; the bad pivot, or -1."""
    size, one = L.shape[1], L.dtype.type(1)
    for p in range(first, last, WIDTH):
        end = min(p + WIDTH, last)
        for k in range(p, end):
            if not least[k] < L[k, k] < np.inf:
                return k
            inverse, x = one / np.sqrt(L[k, k]), L[k, k:]
            for i in range(size - k):
                x[i] *= inverse
            x[0] = inverse
            for j in range(k + 1, end):
                share, x, y = L[k, j], L[k, j:], L[j, j:]
                for i in range(size - j):
                    y[i] -= share * x[i]
        _take(L, p, end, L, 0, end, last)
    return -1


@inlined
def eliminate(L: FloatArray, U: FloatArray, least: FloatArray) -> int:
    """Eliminate the columns L, `L[column, row]`, of a front, whose rest is U; the bad pivot, or -1.

    A pivot is bad if it is not larger than the `least` of its column.

    The diagonal of L is left inverted: solves multiply by it.
    """
    width = len(L)
    for first in range(0, width, PANEL):
        last = min(first + PANEL, width)
        bad = _panel(L, first, last, least)
        if bad >= 0:
            return bad
        _take(L, first, last, L, 0, last, width)
        _take(L, first, last, U, width, 0, len(U))
    return -1


_panel_alone, _taken = only_loops(_panel), only_loops(_take)


def eliminate_in_threads(L: FloatArray, U: FloatArray, least: FloatArray) -> int:
    """The same by threads, in pieces of the columns that do not depend on their number."""
    width = len(L)
    for first in range(0, width, PANEL):
        last = min(first + PANEL, width)
        if (bad := _panel_alone(L, first, last, least)) >= 0:
            return bad
        pieces = [(L, 0, j, min(j + PIECE, width)) for j in range(last, width, PIECE)]
        pieces += [(U, width, j, min(j + PIECE, len(U))) for j in range(0, len(U), PIECE)]
        at_once(lambda piece: _taken(L, first, last, *piece), pieces)  # noqa: B023
    return -1


@inlined
def add_leaf(own: FloatArray, wide: int, to: Places, L: FloatArray, U: FloatArray) -> None:
    """Add what the columns `own` of a thin leaf, so many, leave to the front L, U of its parent."""
    width, size = len(L), wide + len(to)
    for j in range(len(to)):
        for k in range(wide):
            x = own[k * size + wide : (k + 1) * size]
            share = x[j]
            if to[j] < width:
                for i in range(j, len(to)):
                    L[to[j], to[i]] -= share * x[i]
            else:
                for i in range(j, len(to)):
                    U[to[j] - width, to[i] - width] -= share * x[i]


@inlined
def add(left: FloatArray, to: Places, L: FloatArray, U: FloatArray) -> None:
    """Add what is left of a child's front to the front L, U of its parent."""
    width, size = len(L), len(to)
    for j in range(size):
        x = left[j * size : (j + 1) * size]
        if to[j] < width:
            for i in range(j, size):
                L[to[j], to[i]] += x[i]
        else:
            for i in range(j, size):
                U[to[j] - width, to[i] - width] += x[i]
