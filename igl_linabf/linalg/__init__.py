"""Room: linalg."""

from .factors import (
    HOW_TO_GET,
    MAX_CG_STEPS,
    Factor,
    NotConvergedError,
    NotPositiveDefiniteError,
    SolverName,
    Solvers,
    SuperLU,
    blas_of_cholmod,
    conjugate_gradients,
    has_cholmod,
)
from .sparsity import Pattern, Rows, Symmetric

__all__ = [
    "HOW_TO_GET",
    "MAX_CG_STEPS",
    "Factor",
    "NotConvergedError",
    "NotPositiveDefiniteError",
    "Pattern",
    "Rows",
    "SolverName",
    "Solvers",
    "SuperLU",
    "Symmetric",
    "blas_of_cholmod",
    "conjugate_gradients",
    "has_cholmod",
]
