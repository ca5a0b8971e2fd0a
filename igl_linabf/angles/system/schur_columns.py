"""Schur columns: the inverse of the Laplacians times the border of the holonomy constraints."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from scipy import sparse

from ..._types import FloatArray, IntArray, Solve
from .constraints import HolonomyResidual
from .patterns import Symmetric

LOOP_CHANGE = 0.1  # reuse loop columns up to this relative change of the loop constraints
FEW_COLUMNS = 64  # store matrices with more columns as sparse matrices

NarrowMatrix: TypeAlias = "FloatArray | sparse.csr_array"


def build_narrow_matrix(
    values: FloatArray, row: IntArray, column: IntArray, shape: tuple[int, int]
) -> NarrowMatrix:
    """Return a matrix from its entries, dense if it has few columns; duplicate entries are added."""
    if shape[1] > FEW_COLUMNS:
        return sparse.csr_array((values, (row, column)), shape=shape)
    return np.bincount(row * shape[1] + column, values, shape[0] * shape[1]).reshape(shape)


@dataclass(frozen=True, eq=False)
class Border:
    """A matrix B with 2 n rows, most of them zero.

    Attributes
    ----------
    pairs : (#p,) int64
        Indices r of the rows 2 r and 2 r + 1 that may have entries; ascending.
    values : (2 #p, size) matrix
        The rows of B at `pairs`.
    """

    pairs: IntArray
    values: NarrowMatrix

    @cached_property
    def row_indices(self) -> IntArray:
        """The indices of the rows that may have entries."""
        return (2 * self.pairs[:, None] + np.arange(2)).ravel()

    @cached_property
    def transposed(self) -> NarrowMatrix:
        """The transpose of `values`."""
        return self.values.T

    def multiply_transposed(self, x: FloatArray) -> FloatArray:
        """Multiply the transposed border B^T by x."""
        return np.asarray(self.transposed @ x[self.row_indices])

    def to_dense(self, n: int) -> FloatArray:
        """Return B as a dense array with all 2 n rows."""
        made = np.zeros((2 * n, self.values.shape[1]))
        made[self.row_indices] = self.values if isinstance(self.values, np.ndarray) else self.values.toarray()
        return made

    def select_rows(self, index: IntArray) -> sparse.csr_array:
        """Return the rows of B with the given indices."""
        place = np.minimum(np.searchsorted(self.row_indices, index), len(self.row_indices) - 1)
        found = np.flatnonzero(self.row_indices[place] == index)
        shape = len(index), len(self.row_indices)
        chosen = sparse.csr_array((np.ones(len(found)), (found, place[found])), shape=shape)
        return sparse.csr_array(chosen @ self.values)


@dataclass(frozen=True, eq=False)
class SchurColumns:
    """The Schur columns C = A^-1 B of a bordered system, where B is the border of holonomy constraints.

    Attributes
    ----------
    columns : (size, 2 #rows) float64
        The columns of C.
    drawn : HolonomyResidual
        The loops and paths of the constraints.
    schur : (size, size) float64
        D - B^T C in the metric of C.
    """

    columns: FloatArray
    drawn: HolonomyResidual
    schur: FloatArray

    def is_reusable(self, drawn: HolonomyResidual) -> bool:
        """Return True if the loops of the columns are close enough to `drawn` to reuse the columns."""
        q, known = drawn.q, self.drawn
        same = np.array_equal(drawn.constrained, known.constrained)
        return same and float(np.abs(q - known.q).max()) <= LOOP_CHANGE * float(np.abs(q).max())

    def multiply(self, y: FloatArray) -> FloatArray:
        """Multiply the Schur columns C by y."""
        return np.asarray(y @ self.columns)

    def multiply_transposed(self, r: FloatArray) -> FloatArray:
        """Multiply the transposed Schur columns C^T by r."""
        return np.asarray(self.columns @ r)

    def multiply_transposed_by_border(self, B: Border) -> FloatArray:
        """Multiply the transposed Schur columns C^T by the border B."""
        return _multiply_by_border(self.columns, B)

    def galerkin_product(self, S: Symmetric) -> FloatArray:
        """Return the Galerkin product C^T S C of the reduced matrix S and the Schur columns C."""
        return np.array([self.multiply_transposed(S.matvec(column)) for column in self.columns])

    def select_vertex_rows(self, rows: IntArray) -> FloatArray:
        """Return the rows of C of some vertex constraints, (#rows, size)."""
        return self.columns[:, 2 * rows].T


def solve_for_columns(
    inner: Solve, B: Border, D: FloatArray, n: int, drawn: HolonomyResidual
) -> SchurColumns:
    """Return the Schur columns A^-1 B of a border B, given a solver `inner` of A; both have 2 n rows."""
    columns = np.ascontiguousarray(inner(B.to_dense(n)).T)
    return SchurColumns(columns, drawn, D - _multiply_by_border(columns, B))


def _multiply_by_border(columns: FloatArray, B: Border) -> FloatArray:
    """Return C^T B for the columns of C, (size, 2 #rows)."""
    return np.asarray((B.transposed @ columns[:, B.row_indices].T).T)
