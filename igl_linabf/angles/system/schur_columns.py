"""Matrices with one column for each closing row, and what the Laplacians' inverse makes of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from scipy import sparse

from ..._types import BoolArray, ComplexArray, FloatArray, IntArray
from .constraints import HolonomyResidual
from .patterns import Symmetric

Tall: TypeAlias = "FloatArray | sparse.csr_array"

ALIKE = 0.1  # relative difference of loops up to which one's columns serve for the other
DENSE = 64  # columns up to which their entries are kept dense, for quick products


def tall(values: FloatArray, row: IntArray, column: IntArray, shape: tuple[int, int]) -> Tall:
    """A matrix of few columns from its entries, dense or sparse; those of the same place are added."""
    if shape[1] > DENSE:
        return sparse.csr_array((values, (row, column)), shape=shape)
    return np.bincount(row * shape[1] + column, values, shape[0] * shape[1]).reshape(shape)


@dataclass(frozen=True, eq=False)
class Border:
    """A matrix B with few rows that are not zero.

    Attributes
    ----------
    pairs : (#p,) int64
        Rows 2 r and 2 r + 1 of these r may have entries; ascending.
    values : (2 #p, size) matrix
        These rows.
    """

    pairs: IntArray
    values: Tall

    @cached_property
    def rows(self) -> IntArray:
        """The numbers of these rows."""
        return (2 * self.pairs[:, None] + np.arange(2)).ravel()

    @cached_property
    def transposed(self) -> Tall:
        return self.values.T

    def onto(self, x: FloatArray) -> FloatArray:
        """B^T x."""
        return np.asarray(self.transposed @ x[self.rows])

    def whole(self, n: int) -> FloatArray:
        """All `n` rows, dense."""
        made = np.zeros((n, self.values.shape[1]))
        made[self.rows] = self.values if isinstance(self.values, np.ndarray) else self.values.toarray()
        return made

    def second(self, n: int, columns: IntArray) -> FloatArray:
        """The second row of each of `n` pairs, dense, of some columns only."""
        made = np.zeros((n, len(columns)))
        own = self.values[1::2][:, columns]
        made[self.pairs] = own if isinstance(own, np.ndarray) else own.toarray()
        return made

    def at(self, index: IntArray) -> sparse.csr_array:
        """The rows of some numbers."""
        place = np.minimum(np.searchsorted(self.rows, index), len(self.rows) - 1)
        found = np.flatnonzero(self.rows[place] == index)
        shape = len(index), len(self.rows)
        chosen = sparse.csr_array((np.ones(len(found)), (found, place[found])), shape=shape)
        return sparse.csr_array(chosen @ self.values)


@dataclass(frozen=True, eq=False)
class Columns:
    """A dense matrix C.

    Attributes
    ----------
    each : (size, 2 #rows) float64
        Its columns.
    holonomy : HolonomyResidual
        What they were made for.
    schur : (size, size) float64
        D - B^T C in the metric of C.
    """

    each: FloatArray
    holonomy: HolonomyResidual
    schur: FloatArray

    def serves(self, holonomy: HolonomyResidual) -> bool:
        """Whether these loops are drawn nearly as those that the columns were made for."""
        return alike(holonomy, self.holonomy)

    def along(self, y: FloatArray) -> FloatArray:
        """C y."""
        return np.asarray(y @ self.each)

    def onto(self, r: FloatArray) -> FloatArray:
        """C^T r."""
        return np.asarray(self.each @ r)

    def onto_border(self, B: Border) -> FloatArray:
        """C^T B."""
        return np.asarray((B.transposed @ self.each[:, B.rows].T).T)

    def within(self, S: Symmetric) -> FloatArray:
        """C^T S C."""
        return np.array([self.onto(S.matvec(c)) for c in self.each])

    def vertex_rows(self, rows: IntArray) -> FloatArray:
        """Some rows of C, those of vertex constraints."""
        return self.each[:, 2 * rows].T


@dataclass(frozen=True, eq=False)
class ColumnsOfGaps:
    """The same where vertex rows and wheel rows have one inverse: two columns of a gap are a complex one.

    A column has vertex rows for its real parts, and wheel rows for its imaginary ones. That of a gap's
    imaginary part is `of_gap`, and that of its real part is i times it.

    Attributes
    ----------
    of_gap : (#gaps, #rows) complex128
    holonomy : HolonomyResidual
    schur : (size, size) float64
    """

    of_gap: ComplexArray
    holonomy: HolonomyResidual
    schur: FloatArray

    @cached_property
    def _asked(self) -> BoolArray:
        return self.holonomy.asked.ravel()

    def _parts(self, products: ComplexArray) -> FloatArray:
        """Products with all columns from those of `of_gap`, conjugate, (#gaps, ...)."""
        both = np.stack((products.imag, products.real), axis=1)
        return np.asarray(both.reshape(-1, *products.shape[1:])[self._asked])

    def serves(self, holonomy: HolonomyResidual) -> bool:
        return alike(holonomy, self.holonomy)

    def along(self, y: FloatArray) -> FloatArray:
        every = np.zeros(len(self._asked))
        every[self._asked] = y
        return np.asarray((every[1::2] + 1j * every[0::2]) @ self.of_gap).view(np.float64)

    def onto(self, r: FloatArray) -> FloatArray:
        return self._parts((self.of_gap @ r.view(np.complex128).conj()).conj())

    def onto_border(self, B: Border) -> FloatArray:
        border = B.values[0::2] + 1j * B.values[1::2]
        return self._parts(np.asarray((border.T @ self.of_gap[:, B.pairs].conj().T).T))

    def vertex_rows(self, rows: IntArray) -> FloatArray:
        chosen = self.of_gap[:, rows]
        return np.stack((-chosen.imag, chosen.real), axis=1).reshape(-1, len(rows))[self._asked].T

    def within(self, S: Symmetric) -> FloatArray:
        return np.array([self.onto(S.matvec(c)) for c in self._each()])

    def _each(self) -> Iterator[FloatArray]:
        for column, asked in zip(self.of_gap, self.holonomy.asked, strict=True):
            for part in np.flatnonzero(asked):
                yield (column if part else 1j * column).view(np.float64)


@dataclass(frozen=True, eq=False)
class ColumnsOfPaths:
    """The same of closed paths alone: a column for the scale of a path is one for its turning, too.

    Attributes
    ----------
    scale : (#rows, #paths) float64
    path, kind : (size,) int64
        Of each column the path, and 0 if it is for vertex rows, 1 if it is for wheel rows.
    schur : (size, size) float64
        D - B^T C in the conformal metric of C.
    """

    scale: FloatArray
    path: IntArray
    kind: IntArray
    schur: FloatArray

    def serves(self, holonomy: HolonomyResidual) -> bool:
        """Whether these are the columns of all that is asked for."""
        path, part = np.nonzero(holonomy.asked)
        return np.array_equal(path, self.path) and np.array_equal(1 - part, self.kind)

    def along(self, y: FloatArray) -> FloatArray:
        both = np.zeros((self.scale.shape[1], 2))
        both[self.path, self.kind] = y
        return np.asarray(self.scale @ both).ravel()

    def onto(self, r: FloatArray) -> FloatArray:
        return np.asarray((self.scale.T @ r.reshape(-1, 2))[self.path, self.kind])

    def onto_border(self, B: Border) -> FloatArray:
        scale = self.scale[B.pairs]
        both = np.stack([np.asarray(B.values[k::2].T @ scale).T for k in range(2)], axis=1)
        return np.asarray(both[self.path, self.kind])

    def vertex_rows(self, rows: IntArray) -> FloatArray:
        return np.where(self.kind == 0, self.scale[rows][:, self.path], 0.0)

    def within(self, S: Symmetric) -> FloatArray:
        upper = S.upper_within(self.scale)[self.kind[:, None], self.path[:, None], self.kind, self.path]
        return np.asarray(upper + upper.T)


SchurColumns = Columns | ColumnsOfGaps | ColumnsOfPaths


def alike(holonomy: HolonomyResidual, known: HolonomyResidual) -> bool:
    """Whether two of them constrain the same of loops that are drawn nearly alike."""
    q = holonomy.q
    same = np.array_equal(holonomy.asked, known.asked)
    return same and float(np.abs(q - known.q).max()) <= ALIKE * float(np.abs(q).max())
