"""Multigrid for Laplacians of which a factor takes longer, or does not fit into memory."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from .._types import Array, Solve
from .factors import Analysis, Factored, NotConvergedError, mirrored
from .krylov import conjugate_gradients

RTOL = 1e-10  # where multigrid stands in for a factorisation


@dataclass(frozen=True)
class Multigrid(Analysis):
    """PyAMG's smoothed aggregation: one V-cycle as the preconditioner, O(n) memory."""

    name: str = "PyAMG"

    def factor(self, lower: sparse.csc_array) -> Factored:
        """Solve by conjugate gradients, preconditioned by a V-cycle."""
        full = sparse.csr_matrix(mirrored(lower))
        cycle = _v_cycle(full)

        def solve(b: Array) -> Array:
            columns = b.reshape(len(b), -1).T
            x = np.empty_like(columns)
            for k, column in enumerate(columns):
                x[k], _, converged = conjugate_gradients(full.dot, column, cycle, RTOL)
                if not converged[0]:
                    raise NotConvergedError
            return np.ascontiguousarray(x.T).reshape(b.shape)

        return Factored(self.name, False, solve)

    def preconditioner(self, lower: sparse.csc_array, *, rough: bool = False) -> Factored:
        """One V-cycle a column."""
        cycle = _v_cycle(sparse.csr_matrix(mirrored(lower)))
        return Factored(self.name, False, lambda b: np.column_stack([cycle(column) for column in b.T]))


def _v_cycle(full: sparse.csr_matrix) -> Solve:
    """A V-cycle with symmetric Gauss-Seidel sweeps.

    It is in single precision: a preconditioner needs no more digits, and the sweeps wait for memory.
    PyAMG's own cycle computes two residuals more.
    """
    import pyamg
    from pyamg.relaxation.relaxation import gauss_seidel

    # omega by local rows, as the default estimates a spectral radius from random vectors
    made = pyamg.smoothed_aggregation_solver(
        full,
        symmetry="symmetric",
        smooth=("jacobi", {"omega": 4 / 3, "weighting": "local"}),
        improve_candidates=None,
        presmoother=None,
        postsmoother=None,
    )
    levels = [tuple(map(_single, (level.A, level.P, level.R))) for level in made.levels[:-1]]
    coarsest = linalg.splu(sparse.csc_matrix(made.levels[-1].A))

    def cycle(b: Array, level: int = 0) -> Array:
        if level == len(levels):
            return np.asarray(coarsest.solve(b.astype(np.float64)), dtype=np.float32)
        A, prolong, restrict = levels[level]
        x = np.zeros_like(b)
        gauss_seidel(A, x, b, sweep="symmetric")
        x += prolong @ cycle(restrict @ (b - A @ x), level + 1)
        gauss_seidel(A, x, b, sweep="symmetric")
        return x

    return lambda b: cycle(b.astype(np.float32)).astype(np.float64)


def _single(matrix: Any) -> sparse.csr_matrix:
    return sparse.csr_matrix(matrix, dtype=np.float32)
