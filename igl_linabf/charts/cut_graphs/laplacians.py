"""The Laplacian of a closed surface, and its systems with zero at some nodes."""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from ..._core import entries, laplacian_entries
from ..._types import BoolArray, FloatArray, IntArray
from ...linalg import Analysis, Factor, Solvers
from .constants import MAX_BOND_WEIGHT


class DirichletSolver:
    """Solves L u = r with u = 0 at fixed nodes.

    A fixed node keeps its row, as one of the identity. So the pattern is the same whichever nodes are fixed.
    It is analysed once: that takes as long as a factorisation.

    Parameters
    ----------
    lower : (n, n) sparse array
        The lower triangle of L, with every node's diagonal.
    analysis : Analysis
        Of its pattern.
    """

    def __init__(self, lower: sparse.csc_array, analysis: Analysis) -> None:
        self._lower, self._analysis = lower, analysis
        self._row = lower.indices
        self._column = np.repeat(np.arange(lower.shape[1]), np.diff(lower.indptr))
        self._diagonal = np.flatnonzero(self._row == self._column)

    def solve(self, fixed: IntArray, r: FloatArray) -> FloatArray:
        """u for a right side (n,), of which the rows of the fixed nodes do not count."""
        return self.solver(fixed)(r)

    def solver(self, fixed: IntArray) -> Callable[[FloatArray], FloatArray]:
        """`solve` for several right sides, (n,) or (n, k): the system is factored once."""
        factored, free = self.factored(fixed), self.free(fixed)
        return lambda r: factored.solve(np.where(free, r.T, 0.0).T)

    def free(self, fixed: IntArray) -> BoolArray:
        """(n,) bool: the other nodes."""
        free = np.ones(self._lower.shape[0], dtype=bool)
        free[fixed] = False
        return free

    def factored(self, fixed: IntArray) -> Factor:
        """The Laplacian with the identity at the fixed nodes."""
        free = self.free(fixed)
        lower = copy(self._lower)  # the same pattern, which SciPy need not check again
        lower.data = lower.data * (free[self._row] & free[self._column])
        lower.data[self._diagonal[fixed]] = 1.0
        return self._analysis.factor(lower.data)


@dataclass(frozen=True, eq=False)
class SurfaceLaplacian:
    """The Laplacian L of a closed surface: x^T L x is the sum over bonds of weight (x_i - x_j)^2.

    Attributes
    ----------
    n : int
        Number of nodes.
    bonds : (#B, 2) int64
        The nodes that it joins: the ends of the edges, and of the diagonals of polygons.
    cotangent, weight : (#B,) float64
        Of each bond: half the sum of the cotangents; and the same, raised to a positive number.
    """

    n: int
    bonds: IntArray
    cotangent: FloatArray
    weight: FloatArray

    @cached_property
    def lower(self) -> sparse.csc_array:
        """The lower triangle of L, (n, n). Every node has a diagonal, also one without bonds."""
        return self._matrix(self.weight)

    @cached_property
    def dirichlet(self) -> DirichletSolver:
        """Solves systems of L."""
        return DirichletSolver(self.lower, self._analysis)

    @cached_property
    def dirichlet_of_cotangents(self) -> DirichletSolver:
        """The same with the cotangents themselves for weights, if double precision holds them."""
        if not (np.abs(self.cotangent) < MAX_BOND_WEIGHT).all():
            return self.dirichlet
        return DirichletSolver(self._matrix(self.cotangent), self._analysis)

    @property
    def thin_share(self) -> float:
        """Share of the bonds whose cotangents sum to zero or less: their triangles are thin."""
        return float(np.mean(self.cotangent <= 0)) if len(self.cotangent) else 0.0

    @cached_property
    def _analysis(self) -> Analysis:
        return Solvers().analyse(self.lower.indptr, self.lower.indices)

    def _matrix(self, weight: FloatArray) -> sparse.csc_array:
        bonds, shape = np.ascontiguousarray(self.bonds.T), (self.n, self.n)
        indptr, indices, slot = entries(bonds, self.n)
        return sparse.csc_array(
            (laplacian_entries(indptr, slot, bonds, weight), indices, indptr), shape=shape
        )
