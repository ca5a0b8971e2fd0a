"""Sparse linear algebra: Cholesky factors and conjugate gradients. It knows no mesh.

In: symmetric matrices by their lower triangles. Out: factors, solutions. A pattern is analysed once, its
values are factored, a factor solves: `Solvers.analyse(indptr, indices).factor(values).solve(B)`.
"""

from .cholmod import HOW_TO_GET, blas_of_cholmod, has_cholmod
from .constants import MAX_CG_STEPS
from .factors import Analysis, Cholesky, Factor, NotPositiveDefiniteError, real_form, solve_complex
from .gradients import conjugate_gradients
from .memory import check_memory, factor_bytes
from .solvers import SolverName, Solvers
