"""Matrices over some rows of a larger one, whose analysis is known."""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np
from scipy import sparse

from .._types import Array, BoolArray
from .factors import Analysis, Factored


class Within(Analysis):
    """The analysis of a larger pattern, in which the other rows are those of the identity.

    Parameters
    ----------
    whole : Analysis
    lower : (n, n) sparse array
        A lower triangle of its pattern.
    inside : (n,) bool
        The rows of the smaller matrices, in their order.
    """

    def __init__(self, whole: Analysis, lower: sparse.csc_array, inside: BoolArray) -> None:
        row, column = lower.indices, np.repeat(np.arange(lower.shape[1]), np.diff(lower.indptr))
        self.name, self._whole, self._pattern = whole.name, whole, lower
        self._rows, self._kept = np.flatnonzero(inside), np.flatnonzero(inside[row] & inside[column])
        self._identity = np.where((row == column) & ~inside[row], 1.0, 0.0)

    def factor(self, lower: sparse.csc_array) -> Factored:
        return self.restricted(self._whole.factor(self._filled(lower)))

    def preconditioner(self, lower: sparse.csc_array, *, rough: bool = False) -> Factored:
        return self.restricted(self._whole.preconditioner(self._filled(lower), rough=rough))

    def for_one_solve(self, lower: sparse.csc_array) -> Factored:
        return self.restricted(self._whole.for_one_solve(self._filled(lower)))

    def restricted(self, factored: Factored) -> Factored:
        """A factor of a larger matrix for right-hand sides of the smaller one's rows, zero at the others."""
        rows = self._rows
        place = np.full(self._pattern.shape[0], len(rows))
        place[rows] = np.arange(len(rows))

        def solve(b: Array) -> Array:
            own = np.append(b, np.zeros((1, *b.shape[1:]), dtype=b.dtype), axis=0)
            return np.asarray(factored.solve(own.take(place, axis=0)).take(rows, axis=0))

        return replace(factored, solve=solve, halfway=None)

    def _filled(self, lower: sparse.csc_array) -> sparse.csc_array:
        data = self._identity.astype(lower.dtype)
        data[self._kept] = lower.data
        made = copy(self._pattern)
        made.data = data
        return made
