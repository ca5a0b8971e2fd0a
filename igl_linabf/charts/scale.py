"""The Laplace systems of a surface with zero at some nodes: one pattern, analysed once for all of them."""

from collections.abc import Callable
from functools import cached_property

import numpy as np
from scipy import sparse

from .._types import FloatArray, IntArray
from ..linalg import Analysis, factored_often


class ZeroAtNodes:
    """Solves L u = r inside with u = 0 at fixed nodes.

    A fixed node keeps its row, as one of the identity: so the pattern is the same for all of them, and
    its ordering, which takes as long as a factorisation, is found once.

    Parameters
    ----------
    laplacian : (n, n) sparse array
        Symmetric, with its diagonal.
    """

    def __init__(self, laplacian: sparse.csr_array) -> None:
        half, nodes = sparse.tril(laplacian).tocoo(), np.arange(laplacian.shape[0])
        index = np.append(half.coords, [nodes, nodes], axis=1)  # a node without edges has a diagonal, too
        values = np.append(half.data, np.zeros(len(nodes)))
        lower = sparse.csc_array((values, index), shape=laplacian.shape)
        lower.sort_indices()
        self._lower = lower
        self._row = lower.indices
        self._column = np.repeat(np.arange(lower.shape[1]), np.diff(lower.indptr))

    @cached_property
    def _analysis(self) -> Analysis:
        return factored_often(self._lower)

    def solve(self, fixed: IntArray, r: FloatArray) -> FloatArray:
        """u for a right side (n,), of which the rows of the fixed nodes do not count."""
        return self.solver(fixed)(r)

    def solver(self, fixed: IntArray) -> Callable[[FloatArray], FloatArray]:
        """`solve` for several right sides: the system is factored once."""
        free = np.ones(self._lower.shape[0], dtype=bool)
        free[fixed] = False
        row, column = self._row, self._column
        data = np.where(free[row] & free[column], self._lower.data, 0.0)
        data[(row == column) & ~free[row]] = 1.0
        lower = sparse.csc_array((data, row, self._lower.indptr), shape=self._lower.shape)
        factored = self._analysis.factor(lower)
        return lambda r: factored.solve(np.where(free, r, 0.0))
