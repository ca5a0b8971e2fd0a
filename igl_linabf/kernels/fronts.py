"""What is done to the front of a supernode, a dense matrix: loops, and threads for the largest ones.

Arrays are flat, indices unsigned, and there are no slices, as in `substitution`. The rest of a front has
rows and columns up to a multiple of four, so that loops by fours end there. What is beyond its end, or on
the wrong side of the diagonal, is never read.
"""

from typing import Any

import numpy as np

from .._runtime import at_once
from .._types import FloatArray
from .choice import inlined, only_loops
from .supernodes import WIDTH, Places
from .unsigned import FOUR, ONE, THREE, TWO, ZERO, index

PANEL = index(64)  # columns whose effect on the rest is added up
PIECE = 32 * WIDTH  # columns that a thread takes at a time


@inlined
def _take(
    X: FloatArray,
    x: int,
    size: int,
    p: int,
    last: int,
    Y: FloatArray,
    y: int,
    step: int,
    shift: int,
    first: int,
    until: int,
) -> None:
    """Take from the columns `first` to `until` of Y what the eliminated columns `p` to `last` of X say.

    A column of X begins every `size` numbers from `x` on, and one of Y every `step` from `y` on. The row of
    Y's column 0 in X is `shift`. Four go with four at a time, which stay in the processor's registers.
    """
    fours, whole = p + ((last - p) & ~THREE), first + ((until - first) & ~THREE)
    for j in range(first, whole, FOUR):
        y0 = y + j * step
        y1, y2, y3 = y0 + step, y0 + TWO * step, y0 + THREE * step
        begin = j - ((j - step) & THREE)  # so that the rows go by fours
        for k in range(p, fours, FOUR):
            x0 = x + k * size + shift
            x1, x2, x3 = x0 + size, x0 + TWO * size, x0 + THREE * size
            a0, a1, a2, a3 = X[x0 + j], X[x1 + j], X[x2 + j], X[x3 + j]
            i = j + ONE
            b0, b1, b2, b3 = X[x0 + i], X[x1 + i], X[x2 + i], X[x3 + i]
            i = j + TWO
            c0, c1, c2, c3 = X[x0 + i], X[x1 + i], X[x2 + i], X[x3 + i]
            i = j + THREE
            d0, d1, d2, d3 = X[x0 + i], X[x1 + i], X[x2 + i], X[x3 + i]
            for i in range(begin, step):
                u, v, w, z = X[x0 + i], X[x1 + i], X[x2 + i], X[x3 + i]
                Y[y0 + i] -= a0 * u + a1 * v + a2 * w + a3 * z
                Y[y1 + i] -= b0 * u + b1 * v + b2 * w + b3 * z
                Y[y2 + i] -= c0 * u + c1 * v + c2 * w + c3 * z
                Y[y3 + i] -= d0 * u + d1 * v + d2 * w + d3 * z
        k = fours
        if last - k >= TWO:
            x0 = x + k * size + shift
            x1 = x0 + size
            a0, a1, b0, b1 = X[x0 + j], X[x1 + j], X[x0 + j + ONE], X[x1 + j + ONE]
            c0, c1, d0, d1 = X[x0 + j + TWO], X[x1 + j + TWO], X[x0 + j + THREE], X[x1 + j + THREE]
            for i in range(begin, step):
                u, v = X[x0 + i], X[x1 + i]
                Y[y0 + i] -= a0 * u + a1 * v
                Y[y1 + i] -= b0 * u + b1 * v
                Y[y2 + i] -= c0 * u + c1 * v
                Y[y3 + i] -= d0 * u + d1 * v
            k += TWO
        if k < last:
            x0 = x + k * size + shift
            a0, b0, c0, d0 = X[x0 + j], X[x0 + j + ONE], X[x0 + j + TWO], X[x0 + j + THREE]
            for i in range(begin, step):
                u = X[x0 + i]
                Y[y0 + i] -= a0 * u
                Y[y1 + i] -= b0 * u
                Y[y2 + i] -= c0 * u
                Y[y3 + i] -= d0 * u
    for j in range(whole, until):
        y0 = y + j * step
        for k in range(p, fours, FOUR):
            x0 = x + k * size + shift
            x1, x2, x3 = x0 + size, x0 + TWO * size, x0 + THREE * size
            a0, a1, a2, a3 = X[x0 + j], X[x1 + j], X[x2 + j], X[x3 + j]
            for i in range(j, step):
                Y[y0 + i] -= a0 * X[x0 + i] + a1 * X[x1 + i] + a2 * X[x2 + i] + a3 * X[x3 + i]
        for k in range(fours, last):
            x0 = x + k * size + shift
            a0 = X[x0 + j]
            for i in range(j, step):
                Y[y0 + i] -= a0 * X[x0 + i]


@inlined
def _panel(L: FloatArray, at: int, size: int, first: int, last: int, least: FloatArray) -> np.int64:
    """Eliminate the columns `first` to `last` of a front among themselves; the bad pivot, or -1."""
    one = L.dtype.type(1)
    fours = first + ((last - first) & ~THREE)
    for j in range(first, fours, FOUR):
        n, j1, j2, j3 = size - j, j + ONE, j + TWO, j + THREE
        k0 = at + j * size + j
        k1, k2, k3 = k0 + size, k0 + TWO * size, k0 + THREE * size
        pivot = L[k0]
        if not least[j] < pivot < np.inf:
            return np.int64(j)
        a0 = one / np.sqrt(pivot)
        a1, a2, a3 = L[k0 + ONE] * a0, L[k0 + TWO] * a0, L[k0 + THREE] * a0
        pivot = L[k1 + ONE] - a1 * a1
        if not least[j1] < pivot < np.inf:
            return np.int64(j1)
        b1 = one / np.sqrt(pivot)
        b2, b3 = (L[k1 + TWO] - a1 * a2) * b1, (L[k1 + THREE] - a1 * a3) * b1
        pivot = L[k2 + TWO] - a2 * a2 - b2 * b2
        if not least[j2] < pivot < np.inf:
            return np.int64(j2)
        c2 = one / np.sqrt(pivot)
        c3 = (L[k2 + THREE] - a2 * a3 - b2 * b3) * c2
        pivot = L[k3 + THREE] - a3 * a3 - b3 * b3 - c3 * c3
        if not least[j3] < pivot < np.inf:
            return np.int64(j3)
        d3 = one / np.sqrt(pivot)
        L[k0], L[k0 + ONE], L[k0 + TWO], L[k0 + THREE] = a0, a1, a2, a3
        L[k1 + ONE], L[k1 + TWO], L[k1 + THREE] = b1, b2, b3
        L[k2 + TWO], L[k2 + THREE], L[k3 + THREE] = c2, c3, d3
        for i in range(FOUR, n):
            u = L[k0 + i] * a0
            v = (L[k1 + i] - a1 * u) * b1
            w = (L[k2 + i] - a2 * u - b2 * v) * c2
            L[k0 + i], L[k1 + i], L[k2 + i] = u, v, w
            L[k3 + i] = (L[k3 + i] - a3 * u - b3 * v - c3 * w) * d3
        _take(L, at, size, j, j + FOUR, L, at, size, ZERO, j + FOUR, last)
    for j in range(fours, last):
        k0 = at + j * size + j
        pivot = L[k0]
        if not least[j] < pivot < np.inf:
            return np.int64(j)
        a0 = one / np.sqrt(pivot)
        L[k0] = a0
        for i in range(ONE, size - j):
            L[k0 + i] *= a0
        for r in range(j + ONE, last):
            k, k1 = k0 + (r - j), at + r * size + r
            a1 = L[k]
            for i in range(size - r):
                L[k1 + i] -= a1 * L[k + i]
    return np.int64(-1)


@inlined
def eliminate(
    L: FloatArray, at: int, width: int, size: int, U: FloatArray, rest: int, least: FloatArray
) -> np.int64:
    """Eliminate the columns of a front, a row of L from `at` on for each; the bad pivot, or -1.

    The front's rest is U, with `rest` rows and columns. A pivot is bad if it is not larger than the `least`
    of its column.

    The diagonal of L is left inverted: solves multiply by it.
    """
    for first in range(ZERO, width, PANEL):
        last = min(first + PANEL, width)
        bad = _panel(L, at, size, first, last, least)
        if bad >= 0:
            return bad
        _take(L, at, size, first, last, L, at, size, ZERO, last, width)
        _take(L, at, size, first, last, U, ZERO, rest, width, ZERO, rest)
    return np.int64(-1)


_panel_alone, _taken = only_loops(_panel), only_loops(_take)


def eliminate_in_threads(
    L: FloatArray, at: int, width: int, size: int, U: FloatArray, rest: int, least: FloatArray
) -> int:
    """The same by threads, in pieces of the columns that do not depend on their number."""
    begin, wide = index(at), index(size)
    for p in range(0, width, int(PANEL)):
        end = min(p + int(PANEL), width)
        first, last = index(p), index(end)
        bad = int(_panel_alone(L, begin, wide, first, last, least))
        if bad >= 0:
            return bad
        pieces: list[tuple[Any, ...]]
        pieces = [(L, begin, wide, ZERO, j, min(j + PIECE, width)) for j in range(end, width, PIECE)]
        pieces += [(U, ZERO, rest, width, j, min(j + PIECE, rest)) for j in range(0, rest, PIECE)]

        def take(piece: tuple[Any, ...]) -> None:
            Y, *to = piece
            _taken(L, begin, wide, first, last, Y, *map(index, to))  # noqa: B023

        at_once(take, pieces)
    return -1


@inlined
def _eliminated(to: Places, under: int, n: int, width: int) -> Any:
    """How many of a child's n rows are among the `width` columns that its parent eliminates."""
    inner = ZERO
    while inner < n and to[under + inner] < width:
        inner += ONE
    return inner


@inlined
def add(
    left: FloatArray,
    begin: int,
    step: int,
    to: Places,
    under: int,
    n: int,
    L: FloatArray,
    at: int,
    width: int,
    size: int,
    U: FloatArray,
    rest: int,
) -> None:
    """Add what is left of a child's front to the front L, U of its parent.

    These are n columns, one every `step` numbers from `begin` on, and `to` has their places from `under` on.
    """
    inner = _eliminated(to, under, n, width)
    for j in range(inner):
        own, row = begin + j * step, at + to[under + j] * size
        for i in range(j, n):
            L[row + to[under + i]] += left[own + i]
    for j in range(inner, n):
        own, row = begin + j * step, (to[under + j] - width) * rest - width
        for i in range(j, n):
            U[row + to[under + i]] += left[own + i]


@inlined
def add_leaf(
    own: FloatArray,
    begin: int,
    wide: int,
    to: Places,
    under: int,
    n: int,
    L: FloatArray,
    at: int,
    width: int,
    size: int,
    U: FloatArray,
    rest: int,
) -> None:
    """Add what the columns of a thin leaf leave, which are `wide`, one or two, and `own` from `begin` on."""
    inner, k0 = _eliminated(to, under, n, width), begin + wide
    if wide == ONE:
        for j in range(inner):
            row, f = at + to[under + j] * size, own[k0 + j]
            for i in range(j, n):
                L[row + to[under + i]] -= f * own[k0 + i]
        for j in range(inner, n):
            row, f = (to[under + j] - width) * rest - width, own[k0 + j]
            for i in range(j, n):
                U[row + to[under + i]] -= f * own[k0 + i]
    else:
        k1 = k0 + wide + n
        for j in range(inner):
            row, f, g = at + to[under + j] * size, own[k0 + j], own[k1 + j]
            for i in range(j, n):
                L[row + to[under + i]] -= f * own[k0 + i] + g * own[k1 + i]
        for j in range(inner, n):
            row, f, g = (to[under + j] - width) * rest - width, own[k0 + j], own[k1 + j]
            for i in range(j, n):
                U[row + to[under + i]] -= f * own[k0 + i] + g * own[k1 + i]
