"""Sparse linear algebra without reference to meshes: Cholesky factorization and conjugate gradients.

Symmetric matrices are given by their lower triangles. Analysis, factorization and solution are separate
steps: `Solvers.analyse(indptr, indices).factor(values).solve(B)`.
"""

from .cholmod import CHOLMOD_INSTALL_HINT, find_cholmod_blas, has_cholmod
from .factors import Analysis, Cholesky, Factor, NotPositiveDefiniteError, solve_complex, to_real_form
from .gradients import MAX_CG_STEPS, conjugate_gradients
from .memory import available_memory, check_memory, factor_bytes, format_gigabytes, has_free_memory
from .solvers import SolverName, Solvers
