"""Symmetric sparse matrices over the rows of a mesh. A pattern is computed once and filled many times."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ... import _core
from ..._types import Array, FloatArray, IntArray, Solve
from ...linalg import Analysis, Solvers
from ...surface import Topology, sum_by_index


@dataclass(frozen=True, eq=False)
class Symmetric:
    """The matrix U + U^T of 2 by 2 blocks, where U is its upper triangle with half the diagonal.

    Attributes
    ----------
    blocks : (int array, int array, (#blocks, 4) float64)
        indptr and indices, as in CSR, and the blocks of U.
    """

    blocks: tuple[IntArray, IntArray, FloatArray]

    @property
    def n_rows(self) -> int:
        """Number of rows of the matrix."""
        return 2 * len(self.blocks[0]) - 2

    def matvec(self, x: FloatArray) -> FloatArray:
        """Multiply the symmetric matrix by x."""
        return _core.block_product(*self.blocks, x)

    def blocks_for_factorisation(self) -> FloatArray:
        """Return the blocks for a factorisation, (#blocks, 4), with complete diagonal blocks."""
        indptr, _, block = self.blocks
        made = block.copy()
        own = block[indptr[:-1]]
        made[indptr[:-1]] += own[:, [0, 2, 1, 3]]
        return made

    def to_sparse(self) -> sparse.csr_array:
        """Return the matrix as a sparse array with both triangles."""
        indptr, indices, block = self.blocks
        upper = sparse.bsr_array(
            (block.reshape(-1, 2, 2), indices, indptr), shape=(self.n_rows, self.n_rows)
        ).tocsr()
        return (upper + upper.T).tocsr()


def replace_rows_by_identity(lower: sparse.csc_array, first: int) -> sparse.csc_array:
    """Replace the rows and columns from `first` on by the identity, in the same pattern."""
    if first == lower.shape[0]:
        return lower
    data = np.where(lower.indices >= first, 0.0, lower.data)
    data[lower.indptr[first:-1]] = 1.0  # the diagonal comes first in its column
    made = copy(lower)
    made.data = data
    return made


def solve_pairs(inverse: Solve, r: FloatArray) -> FloatArray:
    """Return diag(L+, L)^-1 r, (2 #rows, k), where the two rows of a vertex are adjacent."""
    if not len(r):  # there are no interior vertices
        return r
    return inverse(r.reshape(len(r) // 2, -1)).reshape(r.shape)


class Pattern:
    """The graph of the symmetric matrices over some rows of the vertices of a mesh.

    Parameters
    ----------
    topology : Topology
    row : (#V,) int64
        The row of each vertex, -1 if it has none. An edge between vertices of the same row contributes to the
        diagonal.
    n : int
        Number of rows.

    Attributes
    ----------
    indptr, indices : int arrays
        The lower triangle in CSC, with the diagonal first in each column.
    slot : (#E,) int64
        Index of each edge among the entries of a matrix; -1 if the edge joins a row to itself or to no row.
    """

    def __init__(self, topology: Topology, row: IntArray, n: int) -> None:
        self._analyses: dict[tuple[Solvers, int], Analysis] = {}
        self.n, self.topology, self.row = n, topology, row
        # the lower triangle in CSC order is the upper triangle in CSR order
        indptr, indices, self.slot = _core.symmetric_pattern(self.edge_rows, n)
        small = 8 * len(indices) < np.iinfo(np.int32).max
        index = np.int32 if small else np.int64
        self.indptr: IntArray = indptr.astype(index)
        self.indices: IntArray = indices.astype(index)
        # a template: copying an array skips SciPy's checks of new arrays
        self._zero = sparse.csc_array((np.zeros(len(indices)), self.indices, self.indptr), shape=(n, n))

    @property
    def edge_rows(self) -> IntArray:
        """Matrix rows of the two vertices of each edge, (2, #E) int64."""
        return self.row[self.topology.edges.T]

    def get_analysis(self, solvers: Solvers, block: int = 1) -> Analysis:
        """Return the cached analysis of matrices with `block` by `block` blocks in this pattern."""
        key = solvers, block
        if key not in self._analyses:
            self._analyses[key] = solvers.analyse(self.indptr, self.indices, block)
        return self._analyses[key]

    def build_hermitian_matrix(self, entry: Array, diagonal: Array) -> sparse.csc_array:
        """Return the lower triangle of a Hermitian matrix.

        `entry`, (#E,), is the entry from the first to the second end of each edge.
        """
        pairs = np.flatnonzero(self.slot >= 0)
        (i, j), entry = self.edge_rows[:, pairs], entry[pairs]
        made = copy(self._zero)
        made.data = np.zeros(len(self.indices), dtype=np.result_type(entry, diagonal))
        np.add.at(made.data, self.slot[pairs], np.where(i > j, entry, entry.conj()))
        made.data[self.indptr[:-1]] += diagonal
        return made

    def build_laplacian(self, weight: FloatArray) -> sparse.csc_array:
        """Return the lower triangle of L in x^T L x = sum over edges of weight (x_i - x_j)^2.

        x is 0 at ends without a row.
        """
        made = copy(self._zero)
        made.data = _core.laplacian_entries(self.indptr, self.slot, self.edge_rows, weight)
        return made

    def sum_fixed_vertex_terms(self, weight: FloatArray, z: Array) -> FloatArray:
        """Return the contribution of fixed vertices to L x, (n, 2): the sum of weight z over edges to them.

        z contains the complex positions of the fixed vertices, and zeros for free vertices.
        """
        return _core.fixed_vertex_terms(self.edge_rows, self.topology.edges, weight, z, self.n)

    def sum_at_rows(self, rows: IntArray, values: FloatArray) -> FloatArray:
        """Sum `values` over their `rows`, ignoring row -1."""
        return sum_by_index(rows + 1, values, self.n + 1)[1:]


class RowSubset:
    """Some row pairs of matrices with one pattern. The structure is found once and filled many times.

    Parameters
    ----------
    matrix : Symmetric
        A matrix with the pattern.
    pairs : (#p,) int64
        Indices r of the pairs of rows 2 r and 2 r + 1; ascending.

    Attributes
    ----------
    start, column : int64 arrays
        The columns of the blocks of each pair, as indptr and indices in CSR.
    indptr, indices : int64 arrays
        The upper triangle of the principal submatrix of the subset, in CSR.
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

    def extract_blocks(self, matrix: Symmetric) -> SubsetBlocks:
        """Return the blocks of `matrix` in the rows of the subset."""
        return SubsetBlocks(
            self, _core.gather_row_blocks(matrix.blocks[2], self.column, self._place, self._pair)
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

    def blocks_for_factorisation(self) -> FloatArray:
        """Return the blocks of the principal submatrix for a factorisation."""
        return self.block[self.rows.upper]

    def subtract_transposed(self, r: FloatArray, x: FloatArray) -> FloatArray:
        """Return r - R^T x for the rows R of the subset; r may have additional entries."""
        return _core.subtract_rows(self.rows.start, self.rows.column, self.block, x, r)

    def compute_residual(self, r: FloatArray, z: FloatArray) -> FloatArray:
        """Return r - R z for the rows R of the subset, to which r is restricted."""
        return _core.row_residual(self.rows.start, self.rows.column, self.block, self.rows.pairs, r, z)
