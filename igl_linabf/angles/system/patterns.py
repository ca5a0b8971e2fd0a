"""Symmetric sparse matrices over a mesh's rows: the pattern is made once, and filled many times."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ... import _core
from ..._types import Array, FloatArray, IntArray, Solve
from ...linalg import Analysis, Solvers
from ...surface import Topology, sum_by
from .constants import PRODUCT_ROWS


@dataclass(frozen=True, eq=False)
class Symmetric:
    """The matrix U + U^T of 2 by 2 blocks; only U, its upper triangle with half the diagonal, is kept.

    Attributes
    ----------
    blocks : (int array, int array, (#blocks, 4) float64)
        indptr and indices, as in CSR, and the blocks of U.
    """

    blocks: tuple[IntArray, IntArray, FloatArray]

    @property
    def size(self) -> int:
        """Number of rows."""
        return 2 * len(self.blocks[0]) - 2

    def matvec(self, x: FloatArray) -> FloatArray:
        """The matrix times x."""
        return _core.block_product(*self.blocks, x)

    def upper_galerkin(self, C: FloatArray) -> FloatArray:
        """C^T U_ab C, (2, k, 2, k), where U_ab has entry (a, b) of each block of U, and C is (n / 2, k)."""
        n, k = C.shape
        made = np.zeros((k, 4 * k))
        for first in range(0, n, PRODUCT_ROWS):
            last = min(first + PRODUCT_ROWS, n)
            made += C[first:last].T @ _core.products_of_entries(*self.blocks, C, first, last)
        return made.reshape(k, 2, 2, k).transpose(1, 0, 2, 3)

    def values(self) -> FloatArray:
        """The blocks as they are factored, (#blocks, 4): whole on the diagonal."""
        indptr, _, block = self.blocks
        made = block.copy()
        own = block[indptr[:-1]]
        made[indptr[:-1]] += own[:, [0, 2, 1, 3]]
        return made

    def whole(self) -> sparse.csr_array:
        """All entries."""
        indptr, indices, block = self.blocks
        upper = sparse.bsr_array(
            (block.reshape(-1, 2, 2), indices, indptr), shape=(self.size, self.size)
        ).tocsr()
        return (upper + upper.T).tocsr()


def with_identity(lower: sparse.csc_array, first: int) -> sparse.csc_array:
    """The lower triangle with the identity in the rows and columns from `first` on, in the same pattern."""
    if first == lower.shape[0]:
        return lower
    data = np.where(lower.indices >= first, 0.0, lower.data)
    data[lower.indptr[first:-1]] = 1.0  # the diagonal comes first in its column
    made = copy(lower)
    made.data = data
    return made


def solve_pairs(inverse: Solve, r: FloatArray) -> FloatArray:
    """diag(L+, L)^-1 r, (2 #rows, k), where the two rows of a vertex are next to each other."""
    if not len(r):  # no vertex is inside
        return r
    return inverse(r.reshape(len(r) // 2, -1)).reshape(r.shape)


class Pattern:
    """The graph of the symmetric matrices over some rows of a mesh's vertices.

    Parameters
    ----------
    topology : Topology
    row : (#V,) int64
        The row of each vertex, -1 where it has none. An edge between vertices of one row belongs
        to its diagonal.
    n : int
        Number of rows.

    Attributes
    ----------
    indptr, indices : int arrays
        The lower triangle in CSC, the diagonal first in each column.
    slot : (#E,) int64
        The place among a matrix's entries of each edge; -1 where it joins a row to itself, or to none.
    """

    def __init__(self, topology: Topology, row: IntArray, n: int) -> None:
        self._kept: dict[tuple[Solvers, int], Analysis] = {}
        self.n, self.topology, self.row = n, topology, row
        # the lower triangle in CSC order is the upper one in CSR order
        indptr, indices, self.slot = _core.entries(self.ends, n)
        small = 8 * len(indices) < np.iinfo(np.int32).max
        index = np.int32 if small else np.int64
        self.indptr: IntArray = indptr.astype(index)
        self.indices: IntArray = indices.astype(index)
        # SciPy checks the pattern here, once
        self._zero = sparse.csc_array((np.zeros(len(indices)), self.indices, self.indptr), shape=(n, n))

    @property
    def ends(self) -> IntArray:
        """(2, #E) int64: rows of the ends of each edge."""
        return self.row[self.topology.edges.T]

    def analysis(self, solvers: Solvers, block: int = 1) -> Analysis:
        """Of the Laplacians of this pattern, or of matrices of `block` by `block` blocks; made once."""
        asked = solvers, block
        if asked not in self._kept:
            self._kept[asked] = solvers.analyse(self.indptr, self.indices, block)
        return self._kept[asked]

    def hermitian(self, entry: Array, diagonal: Array) -> sparse.csc_array:
        """Lower triangle of the Hermitian matrix with `entry`, (#E,), from first to second end of edges."""
        pairs = np.flatnonzero(self.slot >= 0)
        (i, j), entry = self.ends[:, pairs], entry[pairs]
        made = copy(self._zero)
        made.data = np.zeros(len(self.indices), dtype=np.result_type(entry, diagonal))
        np.add.at(made.data, self.slot[pairs], np.where(i > j, entry, entry.conj()))
        made.data[self.indptr[:-1]] += diagonal
        return made

    def laplacian(self, weight: FloatArray) -> sparse.csc_array:
        """Lower triangle of L in x^T L x = sum over edges of weight (x_i - x_j)^2, x = 0 at missing ends."""
        made = copy(self._zero)
        made.data = _core.laplacian_entries(self.indptr, self.slot, self.ends, weight)
        return made

    def pull(self, weight: FloatArray, z: Array) -> FloatArray:
        """What fixed vertices add to L x: sum of weight z over the edges to them, (n, 2).

        z has the complex positions of vertices, zero at free ones.
        """
        return _core.pulled(self.ends, self.topology.edges, weight, z, self.n)

    def row_sums(self, rows: IntArray, values: FloatArray) -> FloatArray:
        """Sum `values` over their `rows`, leaving out row -1."""
        return sum_by(rows + 1, values, self.n + 1)[1:]


class RowSubset:
    """Some pairs of rows of the symmetric matrices of one pattern: found once, filled many times.

    Parameters
    ----------
    matrix : Symmetric
        One of these matrices.
    pairs : (#p,) int64
        Rows 2 r and 2 r + 1 of these r; ascending.

    Attributes
    ----------
    start, column : int64 arrays
        The columns of the blocks of each pair, as indptr and indices in CSR.
    indptr, indices : int64 arrays
        The upper triangle of the matrix that these rows have with the same columns, in CSR.
    """

    def __init__(self, matrix: Symmetric, pairs: IntArray) -> None:
        indptr, indices, _ = matrix.blocks
        number = np.full(len(indptr) - 1, -1, dtype=np.int64)
        number[pairs] = np.arange(len(pairs))
        self.pairs = pairs
        self.start, self.column, self._place = _core.block_rows(indptr, indices, number)
        self._pair = np.repeat(pairs, np.diff(self.start))
        at, among = number[self._pair], number[self.column]
        self.upper = np.flatnonzero(among >= at)
        self.indices = among[self.upper]
        self.indptr = np.append(0, np.cumsum(np.bincount(at[self.upper], minlength=len(pairs))))

    def of(self, matrix: Symmetric) -> SubsetBlocks:
        """The blocks of `matrix` in these rows."""
        return SubsetBlocks(
            self, _core.blocks_of_rows(matrix.blocks[2], self.column, self._place, self._pair)
        )


@dataclass(frozen=True, eq=False)
class SubsetBlocks:
    """The blocks of a matrix R in a subset of its rows.

    Attributes
    ----------
    rows : RowSubset
    block : (#, 4) float64
    """

    rows: RowSubset
    block: FloatArray

    def values(self) -> FloatArray:
        """The blocks that these rows have with the same columns, as they are factored."""
        return self.block[self.rows.upper]

    def minus_transposed(self, r: FloatArray, x: FloatArray) -> FloatArray:
        """r - R^T x; r may be longer than the rows."""
        return _core.without_rows(self.rows.start, self.rows.column, self.block, x, r)

    def residual(self, r: FloatArray, z: FloatArray) -> FloatArray:
        """r - R z in these rows."""
        return _core.left_at_rows(self.rows.start, self.rows.column, self.block, self.rows.pairs, r, z)
