"""A common interface to scikit-sparse up to version 0.4 and from version 0.5 on, which wraps CHOLMOD."""

from __future__ import annotations

import re
import warnings
from typing import Any, Protocol

import numpy as np
from scipy import sparse

from .._types import FloatArray, IntArray, Solve
from .factors import NotPositiveDefiniteError

FAILED_COLUMN = re.compile(r"column (\d+)")  # the error has no attribute for the column


class CholmodInterface(Protocol):
    """The symbolic analysis by CHOLMOD of a matrix, given by its lower triangle in CSC."""

    def __init__(self, cholmod: Any, lower: sparse.csc_matrix, mode: str) -> None: ...

    def factor(self, lower: sparse.csc_matrix) -> Solve:
        """Factor a matrix of the same pattern, and return its solver; raise `NotPositiveDefiniteError`."""
        ...


def select_interface(cholmod: Any) -> type[CholmodInterface]:
    """Return the class for the installed version of the module `sksparse.cholmod`."""
    return CholeskyFactorInterface if hasattr(cholmod, "CholeskyFactor") else AnalyzeInterface


class AnalyzeInterface:
    """The interface of scikit-sparse up to version 0.4: the function `analyze` and the class `Factor`."""

    def __init__(self, cholmod: Any, lower: sparse.csc_matrix, mode: str) -> None:
        self._error = cholmod.CholmodNotPositiveDefiniteError
        self._symbolic = cholmod.analyze(lower, mode=mode, ordering_method="amd")

    def factor(self, lower: sparse.csc_matrix) -> Solve:
        numeric = self._symbolic.copy()
        try:
            numeric.cholesky_inplace(lower)
        except self._error as error:
            raise NotPositiveDefiniteError(int(self._symbolic.P()[error.column])) from None
        _check_pivots(numeric.D(), self._symbolic.P())  # the simplicial L D L^T accepts negative pivots
        return lambda b: np.asarray(numeric.solve_A(b))


class CholeskyFactorInterface:
    """The interface of scikit-sparse from version 0.5 on: the class `CholeskyFactor`."""

    def __init__(self, cholmod: Any, lower: sparse.csc_matrix, mode: str) -> None:
        self._error, self._warning = cholmod.CholmodNotPositiveDefiniteError, cholmod.CholmodWarning
        self._symbolic = cholmod.CholeskyFactor(lower.copy(), lower=True, order="amd", supernodal_mode=mode)

    def factor(self, lower: sparse.csc_matrix) -> Solve:
        numeric = self._symbolic.copy()
        try:
            numeric.factorize(lower, ldl=False)
        except self._error as error:
            found = FAILED_COLUMN.search(str(error))
            column = int(found[1]) if found else 0
            raise NotPositiveDefiniteError(int(numeric.perm[column])) from None
        if numeric.rcond == 0:  # CHOLMOD reports no error for matrices with NaN, but their rcond is 0
            _check_pivots(numeric.factor.diagonal(), numeric.perm)

        def solve_quietly(b: FloatArray) -> FloatArray:
            with warnings.catch_warnings():  # callers expect large condition numbers
                warnings.simplefilter("ignore", self._warning)
                return np.asarray(numeric.solve(b))

        return solve_quietly


def _check_pivots(pivots: FloatArray, permutation: IntArray) -> None:
    """Raise `NotPositiveDefiniteError` with the row of the first pivot that is not positive."""
    bad = np.flatnonzero(~(pivots > 0))
    if len(bad):
        raise NotPositiveDefiniteError(int(permutation[bad[0]]))
