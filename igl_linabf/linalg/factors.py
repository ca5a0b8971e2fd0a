"""A common interface to sparse Cholesky factorizations: analyse(pattern) -> factor(values) -> solve(B).

A pattern is the lower triangle of a symmetric matrix in CSC, with the diagonal entry first in each column. If
`block` is 2, each entry of the pattern represents a 2 by 2 block. One `Analysis` of a pattern yields a
`Factor` for each set of values.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from .. import _core
from .._types import ComplexArray, FloatArray, IntArray, Solve


class NotPositiveDefiniteError(ArithmeticError):
    """The matrix is singular or indefinite in double precision; `row` is the row of the first bad pivot."""

    def __init__(self, row: int) -> None:
        super().__init__(f"the matrix is not positive definite in double precision (row {row})")
        self.row = row


@dataclass(frozen=True, eq=False)
class Factor:
    """A factored matrix A.

    Attributes
    ----------
    name : str
        Name of the factorization.
    solve : callable
        Return X such that A X = B, for B of shape (n,) or (n, k).
    """

    name: str
    solve: Solve


class Analysis(ABC):
    """A symbolic analysis: the elimination order and the pattern of the factor, independent of the values."""

    name: str

    @abstractmethod
    def factor(self, values: FloatArray) -> Factor:
        """Factor a symmetric positive definite matrix.

        Parameters
        ----------
        values : (#entries,) or (#entries, 4) float64
            Values of the lower triangle. For blocks, entry (i, j) of the pattern is the block of the upper
            triangle in the rows 2 j, 2 j + 1 and the columns 2 i, 2 i + 1, in row-major order.

        Raises
        ------
        NotPositiveDefiniteError
            The matrix is singular or indefinite.
        """


class Cholesky(Analysis):
    """The symbolic analysis of P A P^T = L L^T by the core, with a minimum degree ordering.

    The factorization is supernodal, and uses as many threads as there are cores.
    """

    name = "supernodal Cholesky"

    def __init__(self, indptr: IntArray, indices: IntArray, block: int = 1) -> None:
        self._symbolic = _core.Symbolic(indptr, indices, block)

    @property
    def memory_bytes(self) -> int:
        """Memory that a factor takes, in bytes."""
        return self._symbolic.bytes

    def factor(self, values: FloatArray) -> Factor:
        made = self._symbolic.factor(np.asarray(values, dtype=np.float64))
        if made.bad_row >= 0:
            raise NotPositiveDefiniteError(made.bad_row)
        return Factor(self.name, made.solve)


def to_real_form(values: ComplexArray) -> FloatArray:
    """Convert the lower triangle of a Hermitian matrix to real 2 by 2 blocks, (#entries, 4).

    The entry a + i b below the diagonal becomes the block [[a, b], [-b, a]] of the upper triangle.
    """
    return np.column_stack((values.real, values.imag, -values.imag, values.real))


def solve_complex(factor: Factor, b: ComplexArray) -> ComplexArray:
    """Solve for complex right-hand sides, (n,) or (n, k), with the factor of a `to_real_form`."""
    parts = np.stack((b.real, b.imag), axis=1)
    x = factor.solve(parts.reshape(2 * len(b), *b.shape[1:])).reshape(parts.shape)
    return np.asarray(x[:, 0] + 1j * x[:, 1])
