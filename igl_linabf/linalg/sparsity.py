"""Symmetric sparse matrices over a mesh's rows: the pattern made once, filled many times."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy import sparse

from .._types import Array, FloatArray, IntArray
from ..kernels import block_product, degrees, filled_blocks, is_fast
from ..surface import Topology, sum_by
from .choice import Solvers
from .factors import Analysis, Multigrid
from .small_blocks import SMALL


class Symmetric:
    """The matrix U + U^T, of which only the upper triangle U, with half the diagonal, is kept."""

    def __init__(self, upper: sparse.csr_array) -> None:
        self.upper, self._lower = upper, upper.T

    @property
    def values(self) -> FloatArray:
        """The entries of U, (nnz,)."""
        return np.asarray(self.upper.data)

    def matvec(self, x: FloatArray) -> FloatArray:
        return np.asarray(self.upper @ x + self._lower @ x)

    def numbered(self, index: IntArray) -> sparse.csr_array:
        """U with the place in `values` of each entry, at least of those in the rows and columns `index`."""
        number = np.arange(self.upper.nnz)
        return sparse.csr_array((number, self.upper.indices, self.upper.indptr), shape=self.upper.shape)

    def lower(self) -> sparse.csc_array:
        """Its lower triangle."""
        return sparse.tril(self.whole()).tocsc()

    def whole(self) -> sparse.csr_array:
        """All of it."""
        return (self.upper + self._lower).tocsr()


class Blocked(Symmetric):
    """The same, kept as 2 by 2 blocks for the compiled product.

    Parameters
    ----------
    indptr, indices : int arrays
        Of the blocks of U, as in CSR.
    block : (#blocks, 4) float64
    """

    def __init__(self, indptr: IntArray, indices: IntArray, block: FloatArray) -> None:
        self._indptr, self._indices, self._block, self._n = indptr, indices, block, len(indptr) - 1

    @property
    def values(self) -> FloatArray:
        return self._block.ravel()

    def matvec(self, x: FloatArray) -> FloatArray:
        return block_product(self._indptr, self._indices, self._block, x)

    def numbered(self, index: IntArray) -> sparse.csr_array:
        chosen = np.zeros(self._n, dtype=bool)
        chosen[index // 2] = True
        row = np.repeat(np.arange(self._n, dtype=self._indices.dtype), np.diff(self._indptr))
        found = np.flatnonzero(chosen[row] | chosen[self._indices])
        indptr = np.searchsorted(row[found], np.arange(self._n + 1))
        number = (4 * found[:, None] + np.arange(4)).reshape(-1, 2, 2)
        shape = (2 * self._n, 2 * self._n)
        return sparse.bsr_array((number, self._indices[found], indptr), shape=shape).tocsr()

    def lower(self) -> sparse.csc_array:
        return self._by_entries.lower()

    def whole(self) -> sparse.csr_array:
        return self._by_entries.whole()

    @cached_property
    def _by_entries(self) -> Symmetric:
        blocks = (self._block.reshape(-1, 2, 2), self._indices, self._indptr)
        return Symmetric(sparse.bsr_array(blocks, shape=(2 * self._n, 2 * self._n)).tocsr())


class Rows:
    """Some rows of symmetric matrices of one pattern: found once, filled many times."""

    def __init__(self, matrix: Symmetric, index: IntArray) -> None:
        number, n = matrix.numbered(index), len(index)
        across, down = number[index].tocoo(), number[:, index].tocoo()
        row = np.concatenate((across.row, down.col))
        order = np.argsort(row, kind="stable")
        row = row[order]
        self._source = np.concatenate((across.data, down.data))[order]
        self._indices = np.concatenate((across.col, down.row))[order]
        self._indptr = np.searchsorted(row, np.arange(n + 1))
        self._shape = (n, number.shape[1])
        place = np.full(number.shape[1], n)
        place[index] = np.arange(n)
        column = place[self._indices]
        among = np.flatnonzero(column <= row)
        key, self._sum = np.unique(column[among] * n + row[among], return_inverse=True)
        self._among = self._source[among]
        self._lower = (key % n, np.searchsorted(key, n * np.arange(n + 1)))

    def of(self, matrix: Symmetric) -> sparse.csr_array:
        """These rows of `matrix`; entries of its diagonal blocks come in two parts."""
        data = matrix.values[self._source]
        return sparse.csr_array((data, self._indices, self._indptr), shape=self._shape)

    def lower(self, matrix: Symmetric) -> sparse.csc_array:
        """Lower triangle of what these rows and columns of `matrix` have in common."""
        data = np.bincount(self._sum, matrix.values[self._among], len(self._lower[0]))
        return sparse.csc_array((data, *self._lower), shape=self._shape[:1] * 2)


def held(lower: sparse.csc_array, first: int) -> sparse.csc_array:
    """The lower triangle with the identity in the rows and columns from `first` on, in the same pattern."""
    if first == lower.shape[0]:
        return lower
    data = np.where(lower.indices >= first, 0.0, lower.data)
    data[lower.indptr[first:-1]] = 1.0  # the diagonal comes first in its column
    return sparse.csc_array((data, lower.indices, lower.indptr), shape=lower.shape)


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
    ends : (2, #E) int64
        Rows of the ends of each edge.
    pairs : (#P,) int64
        The edges that join two different rows: those with an entry off the diagonal.
    downward : (#P,) bool
        Whether the first end of such an edge is the higher row of the two.
    """

    def __init__(self, topology: Topology, row: IntArray, n: int) -> None:
        self._analyses: dict[Solvers, Analysis] = {}
        self._small = topology.corner.shape[1] <= SMALL * topology.n_outer
        self.n, self.ends, self._sides = n, row[topology.edges.T], topology.sides
        i, j = self.ends
        self.pairs = np.flatnonzero((i >= 0) & (j >= 0) & (i != j))
        i, j = i[self.pairs], j[self.pairs]
        self.downward = i > j
        # entries of the lower triangle in CSC order, which is the upper one's in CSR order
        index = np.int32 if 8 * (n + len(i)) < np.iinfo(np.int32).max else np.int64
        rows, low, high = np.arange(n), np.minimum(i, j), np.maximum(i, j)
        off = low * n + high
        if (off[1:] > off[:-1]).all():  # the edges come in this order
            count = np.bincount(low, minlength=n)
            self._indptr = np.zeros(n + 1, dtype=index)
            np.cumsum(count + 1, out=self._indptr[1:])
            self._diagonal, self._slot = self._indptr[:-1].astype(np.int64), np.arange(len(low)) + low + 1
            self._high = np.empty(n + len(low), dtype=index)
            self._high[self._diagonal], self._high[self._slot] = rows, high
            return
        key = np.concatenate((rows * n + rows, off))
        order = np.argsort(key, kind="stable")
        key = key[order]
        new = np.ones(len(key), dtype=bool)
        np.not_equal(key[1:], key[:-1], out=new[1:])
        slot = np.empty_like(order)
        slot[order] = np.cumsum(new) - 1
        self._diagonal, self._slot = slot[:n], slot[n:]
        key = key[new]
        low = key // max(n, 1)
        self._high = (key - low * n).astype(index)
        self._indptr = np.zeros(n + 1, dtype=index)
        np.cumsum(np.bincount(low, minlength=n), out=self._indptr[1:])

    def analysis(self, solvers: Solvers, laplacian: sparse.csc_array) -> Analysis:
        """Of the Laplacians of this pattern, given one of them; made once for each choice of solvers."""
        if solvers not in self._analyses:
            made = solvers.laplacian(laplacian, self._small)
            if isinstance(made, Multigrid):  # no analysis; another time there may be memory for one
                return made
            self._analyses[solvers] = made
        return self._analyses[solvers]

    def lower(self, entry: Array, diagonal: Array) -> sparse.csc_array:
        """Lower triangle of the Hermitian matrix with `entry` from first to second end of `pairs`."""
        if np.iscomplexobj(entry):
            entry = np.where(self.downward, entry, entry.conj())
        data = np.zeros(len(self._high), dtype=np.result_type(entry, diagonal))
        self._fill(data, self._slot, entry)
        data[self._diagonal] += diagonal
        return sparse.csc_array((data, self._high, self._indptr), shape=(self.n, self.n))

    @cached_property
    def upward(self) -> IntArray:
        """The half-edges of `pairs`, (2, #P), that from the lower to the higher row first."""
        sides = self._sides[:, self.pairs]
        return np.where(self.downward, sides[::-1], sides)

    @property
    def lows_and_highs(self) -> IntArray:
        """The lower and the higher row of `pairs`, (2, #P)."""
        return np.sort(self.ends[:, self.pairs], axis=0)

    @cached_property
    def loops(self) -> list[tuple[IntArray, IntArray]]:
        """Half-edges, and their rows, that join vertices of one row."""
        i, j = self.ends
        edges = np.flatnonzero((i == j) & (i >= 0))
        present = [(side[side >= 0], i[edges][side >= 0]) for side in self._sides[:, edges]]
        return [(side, rows) for side, rows in present if len(side)]

    def symmetric(self, block: FloatArray, diagonal: FloatArray) -> Symmetric:
        """The symmetric matrix of 2 by 2 blocks.

        Entries (0, 0), (0, 1), (1, 0), (1, 1) of the blocks are the rows of `block`, (4, #P), from
        lower to higher row of `pairs`, and of `diagonal`, (4, n).
        """
        if is_fast():
            blocks = filled_blocks(len(self._high), self._slot, block, self._diagonal, diagonal)
            return Blocked(np.asarray(self._indptr), np.asarray(self._high), blocks)
        indices, indptr, slot, own = self._blocks
        data = np.zeros(len(indices))
        self._fill(data, slot, block)
        data[own] += diagonal / 2
        return Symmetric(sparse.csr_array((data, indices, indptr), shape=(2 * self.n, 2 * self.n)))

    @cached_property
    def _blocks(self) -> tuple[IntArray, IntArray, IntArray, IntArray]:
        """Of the upper triangle of blocks: CSR's indices and indptr, the places of `block` and `diagonal`."""
        number = np.arange(4 * len(self._high)).reshape(-1, 2, 2)
        half = sparse.bsr_array((number, self._high, self._indptr), shape=(2 * self.n, 2 * self.n)).tocsr()
        place = np.empty_like(half.data)
        place[half.data] = np.arange(len(place))
        place = place.reshape(-1, 4).T
        return half.indices, half.indptr, place[:, self._slot], place[:, self._diagonal]

    def laplacian(self, weight: FloatArray) -> sparse.csc_array:
        """Lower triangle of L in x^T L x = sum over edges of weight (x_i - x_j)^2, x = 0 at missing ends."""
        return self.lower(-weight[self.pairs], degrees(self.ends, weight, self.n))

    def pull(self, weight: FloatArray, edges: IntArray, z: Array) -> FloatArray:
        """What fixed vertices add to L x: sum of weight z over the edges to them, (n, 2).

        `edges` has the vertices of the ends, (2, #E), and z the complex positions, zero at free vertices.
        """
        fixed = z != 0
        near = np.flatnonzero(fixed[edges[0]] | fixed[edges[1]])
        (i, j), weight, ends = self.ends[:, near], weight[near], z[edges[:, near]]
        parts = (weight * ends.real, weight * ends.imag)
        return np.column_stack([self.row_sums(i, b) + self.row_sums(j, a) for a, b in parts])

    def row_sums(self, rows: IntArray, values: FloatArray) -> FloatArray:
        """Sum `values` over their `rows`, leaving out row -1."""
        return sum_by(rows + 1, values, self.n + 1)[1:]

    def _fill(self, data: Array, slot: IntArray, entry: Array) -> None:
        if len(self._high) < self.n + len(self._slot):  # several edges between the same two rows
            np.add.at(data, slot, entry)
        else:
            data[slot] = entry
