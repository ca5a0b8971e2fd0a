"""Symmetric sparse matrices over a mesh's rows: the pattern made once, filled many times."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from .solver import Array
from .topology import FloatArray, IntArray, sum_by


class Pattern:
    """The graph of a symmetric matrix.

    Parameters
    ----------
    ends : (2, #E) int64
        Rows that each edge of the graph joins, -1 where an end has none. An edge within one row
        belongs to its diagonal.
    n : int
        Number of rows.

    Attributes
    ----------
    pairs : (#P,) int64
        The edges that join two different rows: those with an entry off the diagonal.
    downward : (#P,) bool
        Whether the first end of such an edge is the higher row of the two.
    """

    def __init__(self, ends: IntArray, n: int) -> None:
        i, j = ends
        self.n, self.ends = n, ends
        self.pairs = np.flatnonzero((i >= 0) & (j >= 0) & (i != j))
        i, j = i[self.pairs], j[self.pairs]
        self.downward = i > j
        # entries of the lower triangle in CSC order, which is the upper one's in CSR order
        rows = np.arange(n)
        key = np.concatenate((rows, np.minimum(i, j))) * n + np.concatenate((rows, np.maximum(i, j)))
        order = np.argsort(key, kind="stable")
        key = key[order]
        new = np.ones(len(key), dtype=bool)
        np.not_equal(key[1:], key[:-1], out=new[1:])
        slot = np.empty_like(order)
        slot[order] = np.cumsum(new) - 1
        self._diagonal, self._slot = slot[:n], slot[n:]
        key = key[new]
        low = key // max(n, 1)
        index = np.int32 if 8 * len(key) < np.iinfo(np.int32).max else np.int64
        self._high = (key - low * n).astype(index)
        self._indptr = np.zeros(n + 1, dtype=index)
        np.cumsum(np.bincount(low, minlength=n), out=self._indptr[1:])

    def lower(self, entry: Array, diagonal: Array) -> sparse.csc_array:
        """Lower triangle of the Hermitian matrix with `entry` from first to second end of `pairs`."""
        if np.iscomplexobj(entry):
            entry = np.where(self.downward, entry, entry.conj())
        data = self._fill(entry, diagonal)
        return sparse.csc_array((data, self._high, self._indptr), shape=(self.n, self.n))

    def symmetric(self, block: FloatArray, diagonal: FloatArray) -> sparse.csr_array:
        """The whole symmetric matrix of 2 by 2 blocks.

        Entries (0, 0), (0, 1), (1, 0), (1, 1) of the blocks are the rows of `block`, (4, #P) from
        first to second end of `pairs`, and of `diagonal`, (4, n).
        """
        first, second = block[1:3]
        block[1], block[2] = np.where(self.downward, (second, first), (first, second))
        data = self._fill(block.T, diagonal.T / 2).reshape(-1, 2, 2)
        upper = sparse.bsr_array((data, self._high, self._indptr), shape=(2 * self.n, 2 * self.n))
        return (upper + upper.T).tocsr()

    def laplacian(self, weight: FloatArray) -> sparse.csc_array:
        """Lower triangle of L in x^T L x = sum over edges of weight (x_i - x_j)^2, x = 0 at missing ends."""
        i, j = self.ends
        across = np.where(i == j, 0.0, weight)
        return self.lower(-weight[self.pairs], self.row_sums(i, across) + self.row_sums(j, across))

    def row_sums(self, rows: IntArray, values: FloatArray) -> FloatArray:
        """Sum `values` over their `rows`, leaving out row -1."""
        return sum_by(rows + 1, values, self.n + 1)[1:]

    def _fill(self, entry: Array, diagonal: Array) -> Array:
        data = np.zeros((len(self._high), *diagonal.shape[1:]), dtype=np.result_type(entry, diagonal))
        if len(data) == self.n + len(self._slot):
            data[self._slot] = entry
        else:  # several edges between the same two rows
            np.add.at(data, self._slot, entry)
        data[self._diagonal] += diagonal
        return data
