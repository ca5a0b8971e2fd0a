"""Sparse linear algebra without reference to meshes: Cholesky factorization and conjugate gradients.

Symmetric matrices are given by their lower triangles. Analysis, factorization and solution are separate
steps: `Solvers.analyse(indptr, indices).factor(values).solve(B)`.
"""

from .cholmod import HOW_TO_GET, find_cholmod_blas, has_cholmod
from .factors import Analysis, Cholesky, Factor, NotPositiveDefiniteError, real_form, solve_complex
from .gradients import MAX_CG_STEPS, conjugate_gradients
from .memory import check_memory, factor_bytes, format_gigabytes, free_memory, has_free_memory
from .solvers import SolverName, Solvers
