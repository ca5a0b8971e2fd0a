"""The factor P A P^T = L D L^T of a matrix of small diagonal blocks: loops only, which numba compiles.

A is given by its lower triangle in columns (CSC). Each block is ordered by itself. Without numba, a library
factors such matrices.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._types import FloatArray, IntArray
from .choice import compiled, inlined
from .unsigned import ONE
from .words import lowest, ones

Index = NDArray[np.uint32]  # unsigned, as the compiled loops then need not look for negative ones
Bits = NDArray[np.uint64]

SIX = np.uint64(6)
FEW = 4  # neighbours in a word that are written without asking whether they are there


class Symbolic(NamedTuple):
    """What the pattern tells of the factor. Rows and columns of L are in the order of elimination.

    Attributes
    ----------
    order : (n,) uint32
        The row of A that is eliminated as k-th; a block's rows stay together.
    indptr, rows : (n + 1,) and (nnz of L,) uint32
        The columns of L below the diagonal.
    row_indptr, columns : (n + 1,) and (nnz of L,) uint32
        The same by rows.
    own_indptr, own, source : (n + 1,) and (nnz of A - n,) uint32
        The entries of A by the rows of L, without the diagonal: their columns, and their places in A's data.
    """

    order: Index
    indptr: Index
    rows: Index
    row_indptr: Index
    columns: Index
    own_indptr: Index
    own: Index
    source: Index


class Factor(NamedTuple):
    """The factor of a matrix: L, a column's entries at `symbolic.rows`; the inverse of D."""

    symbolic: Symbolic
    below: FloatArray
    inverse: FloatArray


def blocks_of(indptr: IntArray, indices: IntArray) -> IntArray:
    """Where the diagonal blocks of a lower triangle with its whole diagonal begin, and n at the end."""
    n = len(indptr) - 1
    if not n:
        return np.zeros(1, dtype=np.int64)
    reach = np.maximum.accumulate(np.maximum.reduceat(indices, indptr[:-1]))
    return np.concatenate(([0], np.flatnonzero(reach == np.arange(n)) + 1))


@inlined
def _eliminated(near: Bits, first: int, order: Index, indptr: Index, rows: Index) -> bool:
    """Order a block by minimum degree; `rows` gets the neighbours of each row from when it is eliminated.

    Row i of `near` has the bits of i and of its neighbours in the block that begins at row `first`, and zeros
    up to a multiple of four words. False if there is no room for all in `rows`.
    """
    n, words = near.shape
    degree, own = np.empty(n, dtype=np.int64), np.empty(words, dtype=np.uint64)
    alive, low = np.zeros(words, dtype=np.uint64), np.zeros(words, dtype=np.uint64)  # low: of least degree
    for v in range(n):
        alive[v >> 6] |= ONE << np.uint64(v & 63)
        count = np.int64(-1)
        for i in range(words):
            count += ones(near[v, i])
        degree[v] = count
    most, at, bits, size = np.int64(-1), words - 1, np.uint64(0), np.int64(indptr[first])
    for k in range(first, first + n):
        passed = 0
        bits &= low[at]
        while not bits:
            at = at + 1 if at + 1 < words else 0
            bits = low[at]
            passed += 1
            if passed > words:
                most, passed = np.int64(2 * n), 0
                for v in range(n):
                    most = min(most, degree[v])
                for v in range(n):
                    low[v >> 6] |= np.uint64(degree[v] <= most) << np.uint64(v & 63)
                bits = low[at]
        v, bit = (at << 6) + lowest(bits), bits & (~bits + ONE)
        if size + degree[v] + FEW > len(rows):
            return False
        bits ^= bit
        alive[at] ^= bit
        low[at] ^= bit
        order[k], degree[v], begin = first + v, 2 * n, size
        for i in range(words):
            left, base = near[v, i] & alive[i], first + (i << 6)
            own[i], count = left, ones(left)
            for q in range(FEW):  # without a branch; what is too many is overwritten
                rows[size + q] = base + lowest(left)
                left &= left - ONE
            for q in range(FEW, count):
                rows[size + q] = base + lowest(left)
                left &= left - ONE
            size += count
        for p in range(begin, size):
            u, count = np.uint64(rows[p] - first), np.int64(-1)
            for j in range(0, words, 4):  # at a time in registers
                a, b = (near[u, j] | own[j]) & alive[j], (near[u, j + 1] | own[j + 1]) & alive[j + 1]
                c, d = near[u, j + 2] | own[j + 2], near[u, j + 3] | own[j + 3]
                c, d = c & alive[j + 2], d & alive[j + 3]
                near[u, j], near[u, j + 1], near[u, j + 2], near[u, j + 3] = a, b, c, d
                count += ones(a) + ones(b) + ones(c) + ones(d)
            degree[u], word, bit = count, u >> SIX, ONE << (u & np.uint64(63))
            low[word] = low[word] | bit if count <= most else low[word] & ~bit
        indptr[k + 1] = size
    return True


@inlined
def _linked(near: Bits, first: int, ends: IntArray) -> None:
    """Set the bits of each row and of its neighbours in the block that begins at row `first`."""
    near[:] = 0
    last = first + len(near)
    for j in range(len(near)):
        near[j, j >> 6] |= ONE << np.uint64(j & 63)
    for e in range(ends.shape[1]):
        if max(ends[0, e], ends[1, e]) < last:
            i, j = ends[0, e] - first, ends[1, e] - first
            near[j, i >> 6] |= ONE << np.uint64(i & 63)
            near[i, j >> 6] |= ONE << np.uint64(j & 63)


@inlined
def _analysed(
    start: IntArray, ends: IntArray, begin: IntArray
) -> tuple[Index, Index, Index, Index, Index, Index, Index, Index]:
    """`Symbolic` of the blocks that begin at the rows `start`.

    The entries of A join the rows `ends`, (2, #entries), those of a block from `begin` on; n for none.
    """
    n, one = start[-1], np.uint32(1)
    order, place = np.empty(n, dtype=np.uint32), np.empty(n, dtype=np.uint32)
    indptr, row_indptr = np.zeros(n + 1, dtype=np.uint32), np.empty(n + 1, dtype=np.uint32)
    given = np.empty(16 * n + FEW, dtype=np.uint32)
    for b in range(len(start) - 1):
        first, last = start[b], start[b + 1]
        near = np.empty((last - first, (last - first + 255) >> 8 << 2), dtype=np.uint64)
        own_ends = ends[:, begin[b] : begin[b + 1]]
        _linked(near, first, own_ends)
        while not _eliminated(near, first, order, indptr, given):
            given = np.concatenate((given, given))
            _linked(near, first, own_ends)
    filled, at = np.zeros(n, dtype=np.uint32), np.uint32(0)
    for p in range(indptr[n]):
        filled[given[p]] += one
    for k in range(n):
        v = order[k]
        place[v], row_indptr[k], size = k, at, filled[v]
        filled[v] = at
        at += size
    row_indptr[n] = at
    columns, rows = np.empty(at, dtype=np.uint32), np.empty(at, dtype=np.uint32)
    for k in range(n):
        for p in range(indptr[k], indptr[k + 1]):
            v = given[p]
            columns[filled[v]] = k
            filled[v] += one
    filled[:] = indptr[:-1]
    for k in range(n):  # ascending
        for e in range(row_indptr[k], row_indptr[k + 1]):
            j = columns[e]
            rows[filled[j]] = k
            filled[j] += one
    own_indptr = np.zeros(n + 2, dtype=np.uint32)  # own_indptr[k + 1] goes from the first to the last of k
    for e in range(ends.shape[1]):
        if max(ends[0, e], ends[1, e]) < n:
            own_indptr[max(place[ends[0, e]], place[ends[1, e]]) + 2] += one
    for k in range(n):
        own_indptr[k + 2] += own_indptr[k + 1]
    own, source = np.empty(own_indptr[n + 1], dtype=np.uint32), np.empty(own_indptr[n + 1], dtype=np.uint32)
    for e in range(ends.shape[1]):
        if max(ends[0, e], ends[1, e]) < n:
            i, j = place[ends[0, e]], place[ends[1, e]]
            k = max(i, j) + 1
            own[own_indptr[k]], source[own_indptr[k]] = min(i, j), e
            own_indptr[k] += one
    return order, indptr, rows, row_indptr, columns, own_indptr[:-1], own, source


def _analysed_columns(
    start: IntArray, indptr: IntArray, indices: IntArray
) -> tuple[Index, Index, Index, Index, Index, Index, Index, Index]:
    ends = np.empty((2, len(indices)), dtype=np.int64)
    for j in range(len(indptr) - 1):
        for p in range(indptr[j], indptr[j + 1]):
            ends[0, p], ends[1, p] = j, indices[p]
        ends[0, indptr[j]] = len(indptr) - 1  # the diagonal
    return _analysed(start, ends, indptr[start].astype(np.int64))


def analysed(indptr: IntArray, indices: IntArray) -> Symbolic:
    """Order the blocks of a matrix by minimum degree, and find the pattern of its factor.

    The diagonal is the first entry of each column.
    """
    return Symbolic(*compiled(_analysed_columns)(blocks_of(indptr, indices), indptr, indices))


@inlined
def _factored(
    data: FloatArray,
    diagonal: FloatArray,
    order: Index,
    indptr: Index,
    rows: Index,
    row_indptr: Index,
    columns: Index,
    own_indptr: Index,
    own: Index,
    source: Index,
) -> tuple[int, FloatArray, FloatArray]:
    """Row by row (Davis 2005). The first row with a bad pivot, or -1; L and the inverse of D."""
    n = len(indptr) - 1
    below, inverse = np.empty(len(rows)), np.empty(n)
    y, filled = np.zeros(n), indptr[:-1].copy()
    for k in range(n):
        for e in range(own_indptr[k], own_indptr[k + 1]):
            y[own[e]] += data[source[e]]
        d = diagonal[order[k]]
        for e in range(row_indptr[k], row_indptr[k + 1]):
            j = columns[e]
            value = y[j]
            y[j] = 0.0
            for p in range(indptr[j], filled[j]):
                y[rows[p]] -= below[p] * value
            entry = value * inverse[j]
            d -= entry * value
            below[filled[j]] = entry
            filled[j] += 1
        if not d > 0:
            return k, below, inverse
        inverse[k] = 1 / d
    return -1, below, inverse


def factored(symbolic: Symbolic, data: FloatArray, diagonal: FloatArray) -> tuple[int, Factor]:
    """The factor of the matrix with these entries; its first row without a positive pivot, or -1."""
    bad, below, inverse = compiled(_factored)(data, diagonal, *symbolic)
    return (-1 if bad < 0 else int(symbolic.order[bad])), Factor(symbolic, below, inverse)
