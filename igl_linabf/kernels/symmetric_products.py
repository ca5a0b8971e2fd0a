"""Products of symmetric matrices, of which the upper triangle is kept, with one or a few columns."""

import numpy as np
from scipy import sparse

from .._runtime import at_once, unfilled
from .._types import FloatArray, IntArray
from .choice import filled_by, instead, pieces_of, run
from .unsigned import ONE, TWO, index


def _block_product(
    indptr: IntArray,
    indices: IntArray,
    block: FloatArray,
    x: FloatArray,
    first: int,
    last: int,
    y: FloatArray,
) -> None:
    y[:] = 0.0
    before = TWO * index(first)
    for i in range(index(first), index(last)):
        row = TWO * i
        u, v = x[row], x[row + ONE]
        s = t = 0.0
        for k in range(index(indptr[i]), index(indptr[i + ONE])):
            column = TWO * index(indices[k])
            a, b, c, d = block[k, 0], block[k, 1], block[k, 2], block[k, 3]
            p, q, at = x[column], x[column + ONE], column - before
            s += a * p + b * q
            t += c * p + d * q
            y[at] += a * u + c * v
            y[at + ONE] += b * u + d * v
        y[row - before] += s
        y[row - before + ONE] += t


def _block_product_in_threads(
    indptr: IntArray, indices: IntArray, block: FloatArray, x: FloatArray
) -> FloatArray:
    # a row adds to what is below it, too: two parts of the rows have a vector each, from their first row on
    parts = [(*piece, unfilled(len(x) - 2 * piece[0])) for piece in pieces_of(len(indptr) - 1, 2)]
    at_once(lambda part: run(_block_product, indptr, indices, block, x, *part), parts)
    y: FloatArray = parts[0][2]
    for first, _, more in parts[1:]:
        y[2 * first :] += more
    return y


@instead(_block_product_in_threads, _block_product)
def block_product(indptr: IntArray, indices: IntArray, block: FloatArray, x: FloatArray) -> FloatArray:
    """(U + U^T) x, U of 2 by 2 blocks: `block`, (#blocks, 4), at rows and columns as in CSR."""
    upper = sparse.bsr_array((block.reshape(-1, 2, 2), indices, indptr), shape=(len(x), len(x)))
    return np.asarray(upper @ x + upper.T @ x)


def _product_with_pairs(
    indptr: IntArray, indices: IntArray, data: FloatArray, x: FloatArray, first: int, last: int, y: FloatArray
) -> None:
    y[:] = 0.0
    for i in range(first, last):
        u, v, s, t = x[i, 0], x[i, 1], 0.0, 0.0
        for k in range(indptr[i], indptr[i + 1]):
            j, a = indices[k], data[k]
            if j == i:
                s += a * u
                t += a * v
                continue
            s += a * x[j, 0]
            t += a * x[j, 1]
            y[j - first, 0] += a * u
            y[j - first, 1] += a * v
        y[i - first, 0] += s
        y[i - first, 1] += t


def _product_with_pairs_in_threads(
    indptr: IntArray, indices: IntArray, data: FloatArray, x: FloatArray
) -> FloatArray:
    # as in `_block_product_in_threads`
    parts = [(*piece, unfilled((len(x) - piece[0], 2))) for piece in pieces_of(len(indptr) - 1, 2)]
    at_once(lambda part: run(_product_with_pairs, indptr, indices, data, x, *part), parts)
    y: FloatArray = parts[0][2]
    for first, _, more in parts[1:]:
        y[first:] += more
    return y


@instead(_product_with_pairs_in_threads, _product_with_pairs)
def product_with_pairs(indptr: IntArray, indices: IntArray, data: FloatArray, x: FloatArray) -> FloatArray:
    """A x of a symmetric matrix, by its lower triangle in CSC, and two columns x, (n, 2)."""
    lower = sparse.csc_array((data, indices, indptr), shape=(len(x), len(x)))
    return np.asarray(lower @ x + lower.T @ x - lower.diagonal()[:, None] * x)


def _products_of_entries(
    indptr: IntArray, indices: IntArray, block: FloatArray, C: FloatArray, rows: IntArray, made: FloatArray
) -> None:
    k = C.shape[1]
    for i in range(rows[0], rows[1]):
        own = made[i - rows[0]]
        for c in range(k):
            s = t = u = v = 0.0
            for p in range(indptr[i], indptr[i + 1]):
                x = C[indices[p], c]
                s += block[p, 0] * x
                t += block[p, 1] * x
                u += block[p, 2] * x
                v += block[p, 3] * x
            own[c], own[k + c], own[2 * k + c], own[3 * k + c] = s, t, u, v


@filled_by(
    _products_of_entries,
    lambda indptr, indices, block, C, rows: unfilled((rows[1] - rows[0], 4 * C.shape[1])),
    in_pieces=False,
)
def products_of_entries(
    indptr: IntArray, indices: IntArray, block: FloatArray, C: FloatArray, rows: IntArray
) -> FloatArray:
    """The rows from rows[0] up to rows[1] of U_e C, next to each other for e = 0 .. 3, (#, 4 k).

    U_e has entry e of each block, as in `block_product`, and C is (n, k).
    """
    shape = (len(C), len(C))
    each = [
        sparse.csr_array((entry, indices, indptr), shape=shape)[rows[0] : rows[1]] @ C for entry in block.T
    ]
    return np.hstack(each)
