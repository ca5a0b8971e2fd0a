"""Schur columns: the inverse of the Laplacians times the border of the holonomy constraints."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np
from scipy import sparse

from ..._types import ComplexArray, FloatArray, IntArray, Solve
from .constraints import Constraints, HolonomyResidual
from .patterns import Symmetric, solve_pairs

LOOP_CHANGE = 0.1  # columns are reused up to this relative change of the loops
FEW_COLUMNS = 64  # matrices with more columns are sparse
GAPS_AT_A_TIME = 8  # gaps per batch of right-hand sides

NarrowMatrix: TypeAlias = "FloatArray | sparse.csr_array"


def narrow_matrix(
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
        These rows.
    """

    pairs: IntArray
    values: NarrowMatrix

    @cached_property
    def rows(self) -> IntArray:
        """The indices of these rows."""
        return (2 * self.pairs[:, None] + np.arange(2)).ravel()

    @cached_property
    def transposed(self) -> NarrowMatrix:
        """These rows, transposed."""
        return self.values.T

    def transposed_times(self, x: FloatArray) -> FloatArray:
        """Return B^T x."""
        return np.asarray(self.transposed @ x[self.rows])

    def dense(self, n: int) -> FloatArray:
        """Return all 2 n rows."""
        made = np.zeros((2 * n, self.values.shape[1]))
        made[self.rows] = self.values if isinstance(self.values, np.ndarray) else self.values.toarray()
        return made

    def wheel_rows(self, n: int, columns: IntArray) -> FloatArray:
        """Return the second row of each of the n pairs, dense, for some columns."""
        made = np.zeros((n, len(columns)))
        own = self.values[1::2][:, columns]
        made[self.pairs] = own if isinstance(own, np.ndarray) else own.toarray()
        return made

    def row_subset(self, index: IntArray) -> sparse.csr_array:
        """Return the rows with the given indices."""
        place = np.minimum(np.searchsorted(self.rows, index), len(self.rows) - 1)
        found = np.flatnonzero(self.rows[place] == index)
        shape = len(index), len(self.rows)
        chosen = sparse.csr_array((np.ones(len(found)), (found, place[found])), shape=shape)
        return sparse.csr_array(chosen @ self.values)


@dataclass(frozen=True, eq=False)
class DenseColumns:
    """A dense matrix C.

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

    def serves(self, drawn: HolonomyResidual) -> bool:
        """Return True if the columns can also precondition a system with these loops."""
        return has_nearly_same_loops(drawn, self.drawn)

    def times(self, y: FloatArray) -> FloatArray:
        """Return C y."""
        return np.asarray(y @ self.columns)

    def transposed_times(self, r: FloatArray) -> FloatArray:
        """Return C^T r."""
        return np.asarray(self.columns @ r)

    def transposed_times_border(self, B: Border) -> FloatArray:
        """Return C^T B."""
        return np.asarray((B.transposed @ self.columns[:, B.rows].T).T)

    def galerkin(self, S: Symmetric) -> FloatArray:
        """Return C^T S C."""
        return np.array([self.transposed_times(S.matvec(column)) for column in self.columns])

    def vertex_rows(self, rows: IntArray) -> FloatArray:
        """Return the rows of C of some vertex constraints, (#rows, size)."""
        return self.columns[:, 2 * rows].T


@dataclass(frozen=True, eq=False)
class ComplexColumns:
    """Complex form of `DenseColumns` for vertex and wheel rows with the same inverse.

    The real part of a complex column contains the vertex rows, and its imaginary part the wheel rows.
    `of_gap` contains the column of the imaginary part of each gap. The column of the real part is i times
    this column.

    Attributes
    ----------
    of_gap : (#gaps, #rows) complex128
    drawn : HolonomyResidual
    schur : (size, size) float64
    """

    of_gap: ComplexArray
    drawn: HolonomyResidual
    schur: FloatArray

    def serves(self, drawn: HolonomyResidual) -> bool:
        """Return True if the columns can also precondition a system with these loops."""
        return has_nearly_same_loops(drawn, self.drawn)

    def times(self, y: FloatArray) -> FloatArray:
        """Return C y."""
        both = np.zeros(self.drawn.constrained.size)
        both[self.drawn.constrained.ravel()] = y
        return np.asarray((both[1::2] + 1j * both[0::2]) @ self.of_gap).view(np.float64)

    def transposed_times(self, r: FloatArray) -> FloatArray:
        """Return C^T r."""
        return self._constrained_parts((self.of_gap @ r.view(np.complex128).conj()).conj())

    def transposed_times_border(self, B: Border) -> FloatArray:
        """Return C^T B."""
        border = B.values[0::2] + 1j * B.values[1::2]
        return self._constrained_parts(np.asarray((border.T @ self.of_gap[:, B.pairs].conj().T).T))

    def galerkin(self, S: Symmetric) -> FloatArray:
        """Return C^T S C."""
        products = []
        for column, constrained in zip(self.of_gap, self.drawn.constrained, strict=True):
            for part in np.flatnonzero(constrained):
                real = (column if part else 1j * column).view(np.float64)
                products.append(self.transposed_times(S.matvec(real)))
        return np.array(products)

    def vertex_rows(self, rows: IntArray) -> FloatArray:
        """Return the rows of C of some vertex constraints, (#rows, size)."""
        chosen = self.of_gap[:, rows]
        both = np.stack((-chosen.imag, chosen.real), axis=1).reshape(-1, len(rows))
        return both[self.drawn.constrained.ravel()].T

    def _constrained_parts(self, products: ComplexArray) -> FloatArray:
        """Return products with all columns, (size, ...), from conjugate ones with `of_gap`, (#gaps, ...)."""
        both = np.stack((products.imag, products.real), axis=1)
        return np.asarray(both.reshape(-1, *products.shape[1:])[self.drawn.constrained.ravel()])


@dataclass(frozen=True, eq=False)
class PathColumns:
    """Compact form of `DenseColumns` for closed paths only.

    The column for the scale of a path also serves for its turning.

    Attributes
    ----------
    scale : (#rows, #paths) float64
    path, kind : (size,) int64
        For each column, its path, and 0 if it has vertex rows or 1 if it has wheel rows.
    schur : (size, size) float64
        D - B^T C in the conformal metric of C.
    """

    scale: FloatArray
    path: IntArray
    kind: IntArray
    schur: FloatArray

    def serves(self, drawn: HolonomyResidual) -> bool:
        """Return True if these are the columns of all constraints."""
        path, part = np.nonzero(drawn.constrained)
        return np.array_equal(path, self.path) and np.array_equal(1 - part, self.kind)

    def times(self, y: FloatArray) -> FloatArray:
        """Return C y."""
        both = np.zeros((self.scale.shape[1], 2))
        both[self.path, self.kind] = y
        return np.asarray(self.scale @ both).ravel()

    def transposed_times(self, r: FloatArray) -> FloatArray:
        """Return C^T r."""
        return np.asarray((self.scale.T @ r.reshape(-1, 2))[self.path, self.kind])

    def transposed_times_border(self, B: Border) -> FloatArray:
        """Return C^T B."""
        scale = self.scale[B.pairs]
        both = np.stack([np.asarray(B.values[k::2].T @ scale).T for k in range(2)], axis=1)
        return np.asarray(both[self.path, self.kind])

    def galerkin(self, S: Symmetric) -> FloatArray:
        """Return C^T S C."""
        upper = S.upper_galerkin(self.scale)[self.kind[:, None], self.path[:, None], self.kind, self.path]
        return np.asarray(upper + upper.T)

    def vertex_rows(self, rows: IntArray) -> FloatArray:
        """Return the rows of C of some vertex constraints, (#rows, size)."""
        return np.where(self.kind == 0, self.scale[rows][:, self.path], 0.0)


SchurColumns = DenseColumns | ComplexColumns | PathColumns


def has_nearly_same_loops(drawn: HolonomyResidual, known: HolonomyResidual) -> bool:
    """Return True if both residuals have the same constraints and nearly the same loops."""
    same = np.array_equal(drawn.constrained, known.constrained)
    return same and float(np.abs(drawn.q - known.q).max()) <= LOOP_CHANGE * float(np.abs(drawn.q).max())


def solve_border(inner: Solve, B: Border, n: int, drawn: HolonomyResidual, D: FloatArray) -> DenseColumns:
    """Return A^-1 B from a solver `inner` of A, both with 2 n rows."""
    columns = DenseColumns(np.ascontiguousarray(inner(B.dense(n)).T), drawn, D)
    return replace(columns, schur=D - columns.transposed_times_border(B))


def solve_columns(
    inverse: Solve, constraints: Constraints, drawn: HolonomyResidual, B: Border, D: FloatArray
) -> SchurColumns:
    """Return diag(L_s, L_s)^-1 B in the conformal metric, with one right-hand side per column.

    The vertex rows and wheel rows of a column are the real and imaginary parts of one complex column. The
    column of the other part of the gap is i times this column.
    """
    n, constrained = constraints.n, drawn.constrained
    columns: SchurColumns
    if constraints.wheels < n:
        return solve_border(lambda r: solve_pairs(inverse, r), B, n, drawn, D)
    if len(constraints.paths) == len(constrained):
        path, part = np.nonzero(constrained)
        wheel = B.wheel_rows(n, np.flatnonzero(part == 0))
        columns = PathColumns(inverse(wheel), path, 1 - part, D)
    else:
        of_gap = np.zeros((len(constrained), n), dtype=np.complex128)
        number = np.cumsum(constrained.ravel()).reshape(-1, 2) - 1
        for first in range(0, len(constrained), GAPS_AT_A_TIME):
            some = slice(first, first + GAPS_AT_A_TIME)
            made = of_gap[some].view(np.float64).reshape(-1, n, 2).transpose(0, 2, 1)
            made[constrained[some]] = inverse(B.wheel_rows(n, number[some][constrained[some]])).T
        columns = ComplexColumns(of_gap, drawn, D)
    return replace(columns, schur=D - columns.transposed_times_border(B))
