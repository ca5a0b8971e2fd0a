"""Build the Laplacian of a closed surface, and solve linear systems with Dirichlet conditions."""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from ..._core import laplacian_entries, symmetric_pattern
from ..._types import BoolArray, FloatArray, IntArray
from ...linalg import Analysis, Factor, Solvers
from .constants import MAX_BOND_WEIGHT


class DirichletSolver:
    """A solver of L u = r with u = 0 at fixed nodes.

    The rows of fixed nodes are replaced by rows of the identity. The sparsity pattern therefore does not
    depend on the fixed nodes. It is analysed once, because the analysis takes as long as a factorisation.

    Parameters
    ----------
    lower : (n, n) sparse array
        The lower triangle of L, with the diagonal entry of every node.
    analysis : Analysis
        The symbolic analysis of the sparsity pattern of L.
    """

    def __init__(self, lower: sparse.csc_array, analysis: Analysis) -> None:
        self._lower, self._analysis = lower, analysis
        self._row = lower.indices
        self._column = np.repeat(np.arange(lower.shape[1]), np.diff(lower.indptr))
        self._diagonal = np.flatnonzero(self._row == self._column)

    def solve(self, fixed: IntArray, r: FloatArray) -> FloatArray:
        """Return the solution u for a right-hand side (n,); the values of r at fixed nodes are ignored."""
        return self.make_solver(fixed)(r)

    def make_solver(self, fixed: IntArray) -> Callable[[FloatArray], FloatArray]:
        """Return a function that solves for right-hand sides (n,) or (n, k); the system is factored once."""
        factor, free = self.factor(fixed), self.mask_free_nodes(fixed)
        return lambda r: factor.solve(np.where(free, r.T, 0.0).T)

    def mask_free_nodes(self, fixed: IntArray) -> BoolArray:
        """Return a mask of the nodes that are not fixed, (n,) bool."""
        free = np.ones(self._lower.shape[0], dtype=bool)
        free[fixed] = False
        return free

    def factor(self, fixed: IntArray) -> Factor:
        """Factor the Laplacian with rows of the identity at the fixed nodes."""
        free = self.mask_free_nodes(fixed)
        lower = copy(self._lower)  # copying skips the checks of a new SciPy array
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
        The pairs of nodes that L couples: the ends of edges and of diagonals of polygons.
    cotangent, weight : (#B,) float64
        Half the sum of the cotangents at each bond, and this value clipped to a positive range.
    """

    n: int
    bonds: IntArray
    cotangent: FloatArray
    weight: FloatArray

    @cached_property
    def lower_triangle(self) -> sparse.csc_array:
        """The lower triangle of L, (n, n). Every node has a diagonal entry, even without bonds."""
        return self._build_matrix(self.weight)

    @cached_property
    def full_matrix(self) -> sparse.csc_array:
        """The matrix L, (n, n)."""
        return self.lower_triangle + sparse.tril(self.lower_triangle, -1).T

    @cached_property
    def dirichlet_solver(self) -> DirichletSolver:
        """Solver of L u = r with u = 0 at fixed nodes."""
        return DirichletSolver(self.lower_triangle, self._analysis)

    @cached_property
    def unclipped_dirichlet_solver(self) -> DirichletSolver:
        """Solver of L u = r with u = 0 at fixed nodes, with unclipped cotangents as the weights of L.

        If a cotangent exceeds `MAX_BOND_WEIGHT`, the clipped weights are used.
        """
        if not (np.abs(self.cotangent) < MAX_BOND_WEIGHT).all():
            return self.dirichlet_solver
        return DirichletSolver(self._build_matrix(self.cotangent), self._analysis)

    @property
    def thin_bond_share(self) -> float:
        """Share of bonds whose cotangents have a sum of 0 or less, which indicates thin triangles."""
        return float(np.mean(self.cotangent <= 0)) if len(self.cotangent) else 0.0

    @cached_property
    def _analysis(self) -> Analysis:
        return Solvers().analyse(self.lower_triangle.indptr, self.lower_triangle.indices)

    def _build_matrix(self, weight: FloatArray) -> sparse.csc_array:
        bonds, shape = np.ascontiguousarray(self.bonds.T), (self.n, self.n)
        indptr, indices, slot = symmetric_pattern(bonds, self.n)
        return sparse.csc_array(
            (laplacian_entries(indptr, slot, bonds, weight), indices, indptr), shape=shape
        )
