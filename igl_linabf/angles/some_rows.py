"""Some rows of symmetric matrices of 2 by 2 blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .. import _core
from .._types import FloatArray, IntArray
from .patterns import Symmetric


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
        self.start, self.column, self._place = _core.block_rows(indptr, indices, number)
        self._of = np.repeat(pairs, np.diff(self.start))
        at, among = number[self._of], number[self.column]
        self.upper = np.flatnonzero(among >= at)  # of what these rows and the same columns have in common
        self.indices = among[self.upper]
        self.indptr = np.append(0, np.cumsum(np.bincount(at[self.upper], minlength=len(pairs))))

    def of(self, matrix: Symmetric) -> RowsOf:
        """These rows of `matrix`."""
        return RowsOf(self, _core.blocks_of_rows(matrix.blocks[2], self.column, self._place, self._of))


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

    def values(self) -> FloatArray:
        """The blocks that these rows and the same columns have in common, as they are factored."""
        return self.block[self.rows.upper]

    def taken_off(self, x: FloatArray, r: FloatArray) -> FloatArray:
        """r - R^T x; r may be longer than the rows."""
        return _core.without_rows(self.rows.start, self.rows.column, self.block, x, r)

    def left(self, r: FloatArray, z: FloatArray) -> FloatArray:
        """r - R z in these rows."""
        return _core.left_at_rows(self.rows.start, self.rows.column, self.block, self.rows.pairs, r, z)
