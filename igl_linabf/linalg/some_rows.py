"""Some rows of symmetric matrices of 2 by 2 blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from .. import kernels
from .._types import FloatArray, IntArray
from .sparsity import Symmetric


class Rows:
    """Some pairs of rows of symmetric matrices of one pattern: found once, filled many times.

    Parameters
    ----------
    matrix : Symmetric
        One of them.
    pairs : (#p,) int64
        Rows 2 r and 2 r + 1 of these r; ascending.
    """

    def __init__(self, matrix: Symmetric, pairs: IntArray) -> None:
        indptr, indices, _ = matrix.blocks
        number = np.full(len(indptr) - 1, -1, dtype=np.int64)
        number[pairs] = np.arange(len(pairs))
        self.pairs = pairs
        self.start, self.column, self._place = kernels.block_rows(indptr, indices, number)
        self._of = np.repeat(pairs, np.diff(self.start))
        self._find_lower(number)

    def _find_lower(self, number: IntArray) -> None:
        """Find the lower triangle in CSC: the blocks of a row from the diagonal on, as columns."""
        at, among = number[self._of], number[self.column]
        below = np.flatnonzero(among >= at)
        count = np.bincount(at[below], minlength=len(self.pairs))
        # two columns for each row, the second of which lacks the entry above the diagonal
        indptr = np.append(0, np.cumsum(np.column_stack((2 * count, 2 * count - 1)).ravel()))
        row, own = among[below], at[below]
        nth = 2 * (np.arange(len(below)) - (np.cumsum(count) - count)[own])
        indices, source = (np.empty(indptr[-1], dtype=np.int64) for _ in range(2))
        for column in range(2):
            for entry in range(2):
                kept = slice(None) if entry >= column else np.flatnonzero(row > own)
                place = indptr[2 * own[kept] + column] + nth[kept] + entry - column
                indices[place], source[place] = 2 * row[kept] + entry, 4 * below[kept] + 2 * column + entry
        self.lower = indices, indptr, source

    def of(self, matrix: Symmetric) -> RowsOf:
        """These rows of `matrix`."""
        return RowsOf(self, kernels.blocks_of_rows(matrix.blocks[2], self.column, self._place, self._of))


@dataclass(frozen=True, eq=False)
class RowsOf:
    """Rows of a matrix.

    Attributes
    ----------
    rows : Rows
    block : (#, 4) float64
    """

    rows: Rows
    block: FloatArray

    def lower(self) -> sparse.csc_array:
        """Lower triangle of what these rows and the same columns have in common."""
        indices, indptr, source = self.rows.lower
        size = len(indptr) - 1
        return sparse.csc_array((self.block.ravel()[source], indices, indptr), shape=(size, size))

    def taken_off(self, x: FloatArray, r: FloatArray) -> FloatArray:
        """r - R^T x; r may be longer than the rows."""
        return kernels.without_rows(self.rows.start, self.rows.column, self.block, x, r)

    def left(self, r: FloatArray, z: FloatArray) -> FloatArray:
        """r - R z in these rows."""
        return kernels.left_at_rows(self.rows.start, self.rows.column, self.block, self.rows.pairs, r, z)
