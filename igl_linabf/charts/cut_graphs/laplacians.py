"""The Laplace systems of a surface with zero at some nodes: one pattern, analysed once for all of them."""

from collections.abc import Callable
from copy import copy
from functools import cached_property

import numpy as np
from scipy import sparse

from ..._core import entries, laplacian_entries
from ..._types import BoolArray, FloatArray, IntArray
from ...linalg import Analysis, Factor, Solvers


def laplacian_of(ends: IntArray, weight: FloatArray, n: int) -> sparse.csc_array:
    """The lower triangle of L in x^T L x = sum over bonds of weight (x_i - x_j)^2, by their ends (#B, 2).

    Every node has a diagonal, also one without bonds.
    """
    ends = np.ascontiguousarray(ends.T)
    indptr, indices, slot = entries(ends, n)
    return sparse.csc_array((laplacian_entries(indptr, slot, ends, weight), indices, indptr), shape=(n, n))


class ZeroAtNodes:
    """Solves L u = r inside with u = 0 at fixed nodes.

    A fixed node keeps its row, as one of the identity: so the pattern is the same for all of them, and
    its ordering, which takes as long as a factorisation, is found once.

    Parameters
    ----------
    lower : (n, n) sparse array
        The lower triangle of the Laplacian, as `laplacian_of` makes it.
    """

    def __init__(self, lower: sparse.csc_array) -> None:
        self.lower = lower
        self._row = lower.indices
        self._column = np.repeat(np.arange(lower.shape[1]), np.diff(lower.indptr))
        self._diagonal = np.flatnonzero(self._row == self._column)

    @cached_property
    def analysis(self) -> Analysis:
        """Of the pattern."""
        return Solvers().analyse(self.lower.indptr, self.lower.indices)

    def of(self, lower: sparse.csc_array) -> "ZeroAtNodes":
        """The same with another matrix of the pattern."""
        made = ZeroAtNodes(lower)
        made.__dict__["analysis"] = self.analysis
        return made

    def solve(self, fixed: IntArray, r: FloatArray) -> FloatArray:
        """u for a right side (n,), of which the rows of the fixed nodes do not count."""
        return self.solver(fixed)(r)

    def solver(self, fixed: IntArray) -> Callable[[FloatArray], FloatArray]:
        """`solve` for several right sides, (n,) or (n, k): the system is factored once."""
        factored, free = self.factored(fixed), self.free(fixed)
        return lambda r: factored.solve(np.where(free, r.T, 0.0).T)

    def free(self, fixed: IntArray) -> BoolArray:
        """(n,) bool: the other nodes."""
        free = np.ones(self.lower.shape[0], dtype=bool)
        free[fixed] = False
        return free

    def factored(self, fixed: IntArray) -> Factor:
        """The Laplacian with the identity at the fixed nodes."""
        free, lower = self.free(fixed), copy(self.lower)  # the same pattern, which SciPy need not check again
        lower.data = lower.data * (free[self._row] & free[self._column])
        lower.data[self._diagonal[fixed]] = 1.0
        return self.analysis.factor(lower.data)
