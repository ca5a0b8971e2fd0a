"""Some rows of a symmetric matrix of 2 by 2 blocks, of which the upper triangle is kept."""

import numpy as np
from scipy import sparse

from .._runtime import unfilled
from .._types import FloatArray, IntArray
from .choice import filled_by, with_loops


def _block_rows(indptr: IntArray, indices: IntArray, number: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    start = np.zeros(number.max() + 2, dtype=np.int64)
    for i in range(len(number)):
        for k in range(indptr[i], indptr[i + 1]):
            if number[i] >= 0:
                start[number[i] + 1] += 1
            if number[indices[k]] >= 0 and indices[k] != i:
                start[number[indices[k]] + 1] += 1
    for i in range(1, len(start)):
        start[i] += start[i - 1]
    column, place = np.empty(start[-1], dtype=np.int64), np.empty(start[-1], dtype=np.int64)
    end = start[:-1].copy()
    for i in range(len(number)):  # what is left of the diagonal comes from the rows before
        for k in range(indptr[i], indptr[i + 1]):
            row = number[i]
            if row >= 0:
                column[end[row]], place[end[row]] = indices[k], k
                end[row] += 1
            row = number[indices[k]]
            if row >= 0 and indices[k] != i:
                column[end[row]], place[end[row]] = i, ~k
                end[row] += 1
    return start, column, place


@with_loops(_block_rows)
def block_rows(indptr: IntArray, indices: IntArray, number: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Start of each row and columns of its blocks, ascending, and their places; ~place of transposed ones.

    `number`, (n,), has the place of a row among the chosen ones, in ascending order, or -1.
    """
    row = np.repeat(np.arange(len(number)), np.diff(indptr))
    own = np.flatnonzero(number[row] >= 0)
    other = np.flatnonzero((number[indices] >= 0) & (indices != row))
    at = np.concatenate((number[row[own]], number[indices[other]]))
    column = np.concatenate((indices[own], row[other])).astype(np.int64)
    order = np.lexsort((column, at))
    start = np.searchsorted(at[order], np.arange(number.max() + 2))
    return start, column[order], np.concatenate((own, ~other))[order]


def _blocks_of_rows(block: FloatArray, column: IntArray, place: IntArray, of: IntArray) -> FloatArray:
    made = np.empty((len(column), 4))
    for k in range(len(column)):
        b = block[place[k] if place[k] >= 0 else ~place[k]]
        first, second = (b[1], b[2]) if place[k] >= 0 else (b[2], b[1])
        if column[k] == of[k]:
            made[k, 0], made[k, 1], made[k, 2], made[k, 3] = 2 * b[0], b[1] + b[2], b[1] + b[2], 2 * b[3]
        else:
            made[k, 0], made[k, 1], made[k, 2], made[k, 3] = b[0], first, second, b[3]
    return made


@with_loops(_blocks_of_rows)
def blocks_of_rows(block: FloatArray, column: IntArray, place: IntArray, of: IntArray) -> FloatArray:
    """The blocks of `block_rows`, (#, 4), of rows `of`; half of those on the diagonal is kept."""
    made = block[np.where(place < 0, ~place, place)]
    made[place < 0] = made[place < 0][:, [0, 2, 1, 3]]
    same = column == of
    made[same] += made[same][:, [0, 2, 1, 3]]
    return made


def _without_rows(
    start: IntArray, column: IntArray, block: FloatArray, x: FloatArray, r: FloatArray, left: FloatArray
) -> None:
    left[:] = r
    for i in range(len(start) - 1):
        u, v = x[2 * i], x[2 * i + 1]
        for k in range(start[i], start[i + 1]):
            j = 2 * column[k]
            left[j] -= block[k, 0] * u + block[k, 2] * v
            left[j + 1] -= block[k, 1] * u + block[k, 3] * v


@filled_by(_without_rows, lambda *args: unfilled(args[-1].shape), in_pieces=False)
def without_rows(
    start: IntArray, column: IntArray, block: FloatArray, x: FloatArray, r: FloatArray
) -> FloatArray:
    """r - R^T x, (n,), of rows R as of `block_rows`; r may be longer than they are."""
    rows = _matrix(start, column, block, len(r))
    return np.asarray(r - (rows.T @ x)[: len(r)])


def _left_at_rows(
    start: IntArray, column: IntArray, block: FloatArray, of: IntArray, r: FloatArray, z: FloatArray
) -> FloatArray:
    made = np.empty(2 * len(of))
    for i in range(len(of)):
        u, v = r[2 * of[i]], r[2 * of[i] + 1]
        for k in range(start[i], start[i + 1]):
            x, y = z[2 * column[k]], z[2 * column[k] + 1]
            u -= block[k, 0] * x + block[k, 1] * y
            v -= block[k, 2] * x + block[k, 3] * y
        made[2 * i], made[2 * i + 1] = u, v
    return made


@with_loops(_left_at_rows)
def left_at_rows(
    start: IntArray, column: IntArray, block: FloatArray, of: IntArray, r: FloatArray, z: FloatArray
) -> FloatArray:
    """r - R z in the rows `of`, (2 #rows,)."""
    own = (2 * of[:, None] + np.arange(2)).ravel()
    rows = _matrix(start, column, block, len(z))
    return np.asarray(r[own] - rows @ np.append(z, np.zeros(len(z) % 2)))


def _matrix(start: IntArray, column: IntArray, block: FloatArray, n: int) -> sparse.bsr_array:
    shape = 2 * (len(start) - 1), n + n % 2
    return sparse.bsr_array((block.reshape(-1, 2, 2), column, start), shape=shape)
