"""Symmetric sparse matrices over a mesh's rows: the pattern made once, filled many times."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from ... import _core
from ..._core import block_product, entries, laplacian_entries, products_of_entries, pulled, system_blocks
from ..._types import Array, FloatArray, IntArray, Solve
from ...linalg import Analysis, Solvers
from ...surface import Topology, sum_by

BlockRows = tuple[IntArray, IntArray, FloatArray]

AT_ONCE = 1024  # rows of a matrix that is multiplied by a few columns


@dataclass(frozen=True, eq=False)
class Symmetric:
    """The matrix U + U^T of 2 by 2 blocks; only U, its upper triangle with half the diagonal, is kept.

    Attributes
    ----------
    blocks : (int array, int array, (#blocks, 4) float64)
        indptr and indices, as in CSR, and the blocks of U.
    """

    blocks: BlockRows

    @property
    def size(self) -> int:
        """Number of rows."""
        return 2 * len(self.blocks[0]) - 2

    def matvec(self, x: FloatArray) -> FloatArray:
        return block_product(*self.blocks, x)

    def upper_within(self, C: FloatArray) -> FloatArray:
        """C^T U_ab C, (2, k, 2, k), where U_ab has entry (a, b) of each block of U, and C is (n / 2, k)."""
        n, k = C.shape
        made = np.zeros((k, 4 * k))
        for first in range(0, n, AT_ONCE):  # the products of so many rows stay near
            last = min(first + AT_ONCE, n)
            made += C[first:last].T @ products_of_entries(*self.blocks, C, first, last)
        return made.reshape(k, 2, 2, k).transpose(1, 0, 2, 3)

    def values(self) -> FloatArray:
        """Its blocks, (#blocks, 4), as they are factored: whole on the diagonal."""
        indptr, _, block = self.blocks
        made = block.copy()
        own = block[indptr[:-1]]
        made[indptr[:-1]] += own[:, [0, 2, 1, 3]]
        return made

    def whole(self) -> sparse.csr_array:
        """All of it."""
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


def by_pairs(inverse: Solve, r: FloatArray) -> FloatArray:
    """diag(L+, L)^-1 r, (2 #rows, k), the two rows of a vertex being next to each other."""
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
    slot : (#E,) int64
        The place among a matrix's entries of each edge; -1 where it joins a row to itself, or to none.
    """

    def __init__(self, topology: Topology, row: IntArray, n: int) -> None:
        self._analyses: dict[tuple[Solvers, int], Analysis] = {}
        self.n, self._topology, self._row = n, topology, row
        # the lower triangle in CSC order is the upper one in CSR order
        indptr, indices, self.slot = entries(self.ends, n)
        small = 8 * len(indices) < np.iinfo(np.int32).max
        index = np.int32 if small else np.int64
        self._indptr: IntArray = indptr.astype(index)
        self._indices: IntArray = indices.astype(index)

    @property
    def ends(self) -> IntArray:
        """(2, #E) int64: rows of the ends of each edge."""
        return self._row[self._topology.edges.T]

    def analysis(self, solvers: Solvers, block: int = 1) -> Analysis:
        """Of the Laplacians of this pattern, or of matrices with `block` by `block` ones for their entries.

        It is made once for each choice of solvers.
        """
        asked = solvers, block
        if asked not in self._analyses:
            self._analyses[asked] = solvers.analyse(self._indptr, self._indices, block)
        return self._analyses[asked]

    def hermitian(self, entry: Array, diagonal: Array) -> sparse.csc_array:
        """Lower triangle of the Hermitian matrix with `entry`, (#E,), from first to second end of edges."""
        pairs = np.flatnonzero(self.slot >= 0)
        (i, j), entry = self.ends[:, pairs], entry[pairs]
        data = np.zeros(len(self._indices), dtype=np.result_type(entry, diagonal))
        np.add.at(data, self.slot[pairs], np.where(i > j, entry, entry.conj()))
        data[self._indptr[:-1]] += diagonal
        return self._lower(data)

    def system(self, wheels: int, w: FloatArray, d: FloatArray, cot: FloatArray) -> Symmetric:
        """S of 2 by 2 blocks, as `system_blocks` has it."""
        t, pattern = self._topology, (self._indptr, self._indices)
        block = system_blocks(*pattern, self.slot, self.ends, t.sides, t.corner, self._row, wheels, w, d, cot)
        return Symmetric((*pattern, block))

    def laplacian(self, weight: FloatArray) -> sparse.csc_array:
        """Lower triangle of L in x^T L x = sum over edges of weight (x_i - x_j)^2, x = 0 at missing ends."""
        return self._lower(laplacian_entries(self._indptr, self.slot, self.ends, weight))

    def _lower(self, data: Array) -> sparse.csc_array:
        made = copy(self._empty)
        made.data = data
        return made

    @cached_property
    def _empty(self) -> sparse.csc_array:
        """A matrix of the pattern, which is checked once."""
        none = np.zeros(len(self._indices))
        return sparse.csc_array((none, self._indices, self._indptr), shape=(self.n, self.n))

    def pull(self, weight: FloatArray, z: Array) -> FloatArray:
        """What fixed vertices add to L x: sum of weight z over the edges to them, (n, 2).

        z has the complex positions of vertices, zero at free ones.
        """
        return pulled(self.ends, self._topology.edges, weight, z, self.n)

    def row_sums(self, rows: IntArray, values: FloatArray) -> FloatArray:
        """Sum `values` over their `rows`, leaving out row -1."""
        return sum_by(rows + 1, values, self.n + 1)[1:]


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
