"""One interface to sparse Cholesky factors: analyse(pattern) -> factor(values) -> solve(B).

A pattern is the lower triangle of a symmetric matrix in CSC, the diagonal first in each column. With `block`
2, each entry of it stands for a 2 by 2 block. An `Analysis` is made once for a pattern, a `Factor` for its
values.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from .. import _core
from .._types import ComplexArray, FloatArray, IntArray, Solve


class NotPositiveDefiniteError(ArithmeticError):
    """The matrix is singular or indefinite in double precision; `row` has the first bad pivot."""

    def __init__(self, row: int) -> None:
        super().__init__(f"the matrix is not positive definite in double precision (row {row})")
        self.row = row


@dataclass(frozen=True, eq=False)
class Factor:
    """A matrix that can be solved with.

    Attributes
    ----------
    name : str
        What factored it.
    solve : callable
        X of A X = B, for (n,) or (n, k).
    """

    name: str
    solve: Solve


class Analysis(ABC):
    """A symbolic analysis: the order of elimination and the pattern of the factor, before values."""

    name: str

    @abstractmethod
    def factor(self, values: FloatArray) -> Factor:
        """Factor a symmetric positive definite matrix.

        Parameters
        ----------
        values : (#entries,) or (#entries, 4) float64
            Of the lower triangle. For blocks, entry (i, j) of the pattern has the block in the rows 2 j,
            2 j + 1 and the columns 2 i, 2 i + 1, row by row: that of the upper triangle.

        Raises
        ------
        NotPositiveDefiniteError
        """


class Cholesky(Analysis):
    """The core's analysis of P A P^T = L L^T, ordered by minimum degree.

    Its factor is made by supernodes, by as many threads as there are cores.
    """

    name = "supernodal Cholesky"

    def __init__(self, indptr: IntArray, indices: IntArray, block: int = 1) -> None:
        self._symbolic = _core.Symbolic(indptr, indices, block)

    @property
    def bytes(self) -> int:
        """What a factor takes."""
        return self._symbolic.bytes

    def factor(self, values: FloatArray) -> Factor:
        made = self._symbolic.factor(np.asarray(values, dtype=np.float64))
        if made.bad_row >= 0:
            raise NotPositiveDefiniteError(made.bad_row)
        return Factor(self.name, made.solve)


def real_form(values: ComplexArray) -> FloatArray:
    """The 2 by 2 blocks, (#entries, 4), of a Hermitian matrix given by its lower triangle.

    The entry a + i b below the diagonal gives the block [[a, b], [-b, a]] of the upper triangle.
    """
    return np.column_stack((values.real, values.imag, -values.imag, values.real))


def solve_complex(factor: Factor, b: ComplexArray) -> ComplexArray:
    """Solve for (n,) or (n, k) complex right-hand sides, by the factor of a `real_form`."""
    parts = np.stack((b.real, b.imag), axis=1)
    x = factor.solve(parts.reshape(2 * len(b), *b.shape[1:])).reshape(parts.shape)
    return np.asarray(x[:, 0] + 1j * x[:, 1])
