"""Factorisations of sparse Hermitian matrices: a pattern is analysed once, its values are factored anew.

An `Analysis` belongs to a pattern. `Analysis.factor(lower)` returns a new `Factored` that nobody changes
afterwards. CHOLMOD is used where scikit-sparse is installed; where it is not, the Cholesky factorisation of
Eigen in libigl's own wheel.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import igl
import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from .._types import Array, FloatArray, IntArray, Solve

if TYPE_CHECKING:
    from .sparsity import Symmetric

try:
    from sksparse import cholmod
except ImportError:
    cholmod = None


BLOCKS_UP_TO = 250_000  # rows, above which a factor of 2 by 2 blocks saves no time, and takes much memory
SIMPLICIAL_UP_TO = 25_000  # rows; supernodal CHOLMOD with a good BLAS is faster above
NO_ROWS, NO_EQUATIONS = np.empty(0, dtype=np.int64), sparse.csc_matrix((0, 0))


def has_cholmod() -> bool:
    """Whether scikit-sparse is installed."""
    return cholmod is not None


class NotPositiveDefiniteError(ArithmeticError):
    """The matrix is singular or indefinite in double precision; `row` has the first bad pivot."""

    def __init__(self, row: int) -> None:
        super().__init__(f"the matrix is not positive definite in double precision (row {row})")
        self.row = row


class NotConvergedError(ArithmeticError):
    """Conjugate gradients did not reach their tolerance within their steps."""


@dataclass(frozen=True, eq=False)
class Factored:
    """A matrix that can be solved with.

    Attributes
    ----------
    name : str
    exact : bool
        Whether `solve` is a factorisation's, or one to a tolerance.
    solve : callable
        For one (n,) or several (n, k) right-hand sides.
    single : bool
        Whether it is a factor in single precision.
    halfway : callable or None
        For columns with few entries, by their rows and values, (m, k) both: L^-1 of them where A = L L^T in
        some order, (#, k), without rows of zeros. None where all of `solve` takes little more.
    """

    name: str
    exact: bool
    solve: Solve
    single: bool = False
    halfway: Callable[[IntArray, FloatArray], FloatArray] | None = None


class Analysis:
    """What is known of a pattern before it has values."""

    name: str

    def __init__(self, lower: sparse.csc_array) -> None:
        """Of a matrix of the pattern, given by its lower triangle."""

    def factor(self, lower: sparse.csc_array) -> Factored:
        """Factor a Hermitian positive definite matrix, given by its lower triangle."""
        raise NotImplementedError

    def preconditioner(self, lower: sparse.csc_array, *, rough: bool = False) -> Factored:
        """A symmetric positive definite approximation of its inverse, for (n, k), to be called often.

        With `rough`, a factor may be in single precision.
        """
        return self.factor(lower)

    def of_blocks(self, system: Symmetric) -> Factored | None:
        """The factor of a matrix that has 2 by 2 blocks for the entries of the pattern.

        None where there is no such factor, or no memory for it.
        """
        return None

    def for_one_solve(self, lower: sparse.csc_array) -> Factored:
        """What takes least time to solve with once; a solve may raise NotConvergedError."""
        return self.factor(lower)


class Direct(Analysis):
    """One whose factors have all digits, of any pattern."""

    _whole: Analysis | None = None

    def of_blocks(self, system: Symmetric) -> Factored | None:
        if system.size > 2 * BLOCKS_UP_TO:
            return None
        lower = system.lower()
        if self._whole is None:
            self._whole = type(self)(lower)
        return self._whole.factor(lower)


class Cholmod(Direct):
    """CHOLMOD's symbolic analysis of P A P^T = L D L^H."""

    name = "CHOLMOD"

    def __init__(self, lower: sparse.csc_array, simplicial_up_to: int | None = None) -> None:
        self._supernodal = lower.shape[0] > (
            SIMPLICIAL_UP_TO if simplicial_up_to is None else simplicial_up_to
        )
        self._symbolic = cholmod.analyze(
            lower,
            mode="supernodal" if self._supernodal else "simplicial",
            ordering_method="amd",  # METIS's smaller fill never pays for its analysis
        )

    def factor(self, lower: sparse.csc_array) -> Factored:
        return Factored(self.name, True, self._numeric(lower).solve_A)

    def preconditioner(self, lower: sparse.csc_array, *, rough: bool = False) -> Factored:
        numeric = self._numeric(lower)
        if self._supernodal:
            # this call leaves the factor in simplicial form, in which a solve takes half the time;
            # unpacking costs about one solve
            numeric.solve_LD(np.zeros(lower.shape[0]))
        return Factored(self.name, True, numeric.solve_A)

    def _numeric(self, lower: sparse.csc_array) -> Any:
        numeric = self._symbolic.copy()
        try:
            numeric.cholesky_inplace(lower)
        except cholmod.CholmodNotPositiveDefiniteError as error:
            raise NotPositiveDefiniteError(int(self._symbolic.P()[error.column])) from None
        # the simplicial L D L^H goes on past a negative pivot
        bad = np.flatnonzero(~(numeric.D().real > 0))
        if len(bad):
            raise NotPositiveDefiniteError(int(self._symbolic.P()[bad[0]]))
        return numeric


class IglCholesky(Direct):
    """Eigen's simplicial L L^T with AMD, as libigl's wheel holds it; it orders anew with each factorisation.

    `igl.min_quad_with_fixed_precompute` without fixed values factors a matrix by its lower triangle, and
    `igl.min_quad_with_fixed_solve` solves A x = -b. A Hermitian matrix is factored in its real form
    [[Re, -Im], [Im, Re]].
    """

    name = "igl's Cholesky"

    def factor(self, lower: sparse.csc_array) -> Factored:
        if not lower.shape[0]:
            return Factored(self.name, True, np.copy)
        bad = np.flatnonzero(~np.isfinite(lower.data))
        if len(bad):
            raise NotPositiveDefiniteError(int(lower.indices[bad[0]]))
        n, data, real = lower.shape[0], igl.min_quad_with_fixed_data(), not np.iscomplexobj(lower.data)
        matrix = lower
        if not real:
            Re, Im = mirrored(lower).real, mirrored(lower).imag
            matrix = sparse.tril(sparse.block_array([[Re, -Im], [Im, Re]])).tocsc()
        try:
            igl.min_quad_with_fixed_precompute(sparse.csc_matrix(matrix), NO_ROWS, NO_EQUATIONS, True, data)
        except RuntimeError:
            return SuperLU(lower).factor(lower)  # which names the pivot

        def solve(b: Array) -> Array:
            columns = b.reshape(n, -1)
            parts = columns if real else np.concatenate((columns.real, columns.imag))
            none = np.empty((0, parts.shape[1]))
            x = -igl.min_quad_with_fixed_solve(data, parts, none, none)
            return np.asarray((x if real else x[:n] + 1j * x[n:]).reshape(b.shape))

        return Factored(self.name, True, solve)


class SuperLU(Analysis):
    """SciPy's SuperLU in its symmetric mode; it orders anew with each factorisation."""

    name = "SuperLU"

    def factor(self, lower: sparse.csc_array) -> Factored:
        try:
            lu = linalg.splu(
                mirrored(lower),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError:  # "Factor is exactly singular", without a place
            raise NotPositiveDefiniteError(0) from None
        bad = np.flatnonzero(~(lu.U.diagonal().real > 0))
        if len(bad):
            raise NotPositiveDefiniteError(int(np.argsort(lu.perm_c)[bad[0]]))
        return Factored(self.name, True, lu.solve)


def by_pairs_of_columns(pairs: Solve, b: Array) -> Array:
    """The solutions for one (n,) or several (n, k) right-hand sides, by what solves for two."""
    if not len(b):  # no vertex is inside
        return b
    columns = b.reshape(len(b), -1)
    if columns.shape[1] % 2:
        columns = np.column_stack((columns, np.zeros(len(b))))
    made = [pairs(columns[:, k : k + 2]) for k in range(0, columns.shape[1], 2)]
    x = made[0] if len(made) == 1 else np.hstack(made or [columns])
    return x[:, : b.size // len(b)].reshape(b.shape)


def mirrored(lower: sparse.csc_array) -> sparse.csc_array:
    """The whole Hermitian matrix of which `lower` is the lower triangle."""
    return (lower + sparse.tril(lower, -1).conj().T).tocsc()
